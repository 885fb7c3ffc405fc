#include "lake/motion/saved_corrections.h"

#include <gmock/gmock.h>

#include "lake/core/atomic_file.h"
#include "lake/core/json.h"
#include "lake/core/provenance.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using motion::UnappliedCorrections;
using testing::HasSubstr;
using testing::IsEmpty;

class SavedCorrections : public testing::Test {
 protected:
  SavedCorrections() { Track({}); }

  // As lake-track leaves it, made with these of the saved files.
  void Track(const std::map<std::string, std::string>& roles) const {
    Json inputs = {{{"role", "video"}, {"sha256", "00"}}};
    for (const auto& [file, role] : roles) inputs.push_back({{"role", role}, {"sha256", Sha256OfFile(folder_ / file)}});
    WriteJsonFile(folder_ / "summary.json", {{"program", "lake-track"}, {"inputs", inputs}});
  }
  void Save(const std::string& rows) const {
    WriteTextFile(folder_ / "corrections.csv", "frame,marker,x_px,y_px\n" + rows);
  }
  std::string Warning() const { return UnappliedCorrections(folder_.Path()); }

  TemporaryFolder folder_;
};

TEST_F(SavedCorrections, AreNotSaidWhereThereAreNone) {
  EXPECT_THAT(Warning(), IsEmpty());
  Save("");
  EXPECT_THAT(Warning(), IsEmpty());
}

TEST_F(SavedCorrections, AreSaidUntilTheFolderIsTrackedWithThem) {
  Save("5,knee,10,20\n6,knee,,\n");
  WriteTextFile(folder_ / "events_corrected.csv", "repetition,event,frame,time_s\n1,onset,30,\n");
  WriteJsonFile(folder_ / "review.json", {{"command", "lake track a.mp4 --corrections it"}});
  EXPECT_THAT(Warning(), AllOf(HasSubstr(folder_.Path().string()), HasSubstr("3 corrections"),
                               HasSubstr("lake track a.mp4 --corrections it")));
  Track({{"corrections.csv", "corrections"}});
  EXPECT_THAT(Warning(), HasSubstr("the 1 correction saved"));
  Track({{"corrections.csv", "corrections"}, {"events_corrected.csv", "events"}});
  EXPECT_THAT(Warning(), IsEmpty());
}

TEST_F(SavedCorrections, ThatWereTakenBackAreSaid) {
  Save("5,knee,10,20\n");
  Track({{"corrections.csv", "corrections"}});
  Save("");
  EXPECT_THAT(Warning(), AllOf(HasSubstr("taken back"), HasSubstr("lake review ")));
}

TEST_F(SavedCorrections, OfAnotherProgramsFolderAreNotLookedFor) {
  Save("5,knee,10,20\n");
  WriteJsonFile(folder_ / "summary.json", {{"program", "lake-gait"}});
  EXPECT_THAT(Warning(), IsEmpty());
  std::filesystem::remove(folder_ / "summary.json");
  EXPECT_THAT(Warning(), IsEmpty());
}

}  // namespace
}  // namespace lake
