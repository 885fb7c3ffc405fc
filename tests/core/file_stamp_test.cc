// Contents that are known without being read again, and those that are not.
#include "lake/core/file_stamp.h"

#include <gtest/gtest.h>

#include <fstream>

#include "lake/core/provenance.h"
#include "lake/core/run.h"
#include "places.h"
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

// That this process has asked for, as Linux counts them.
std::uintmax_t BytesRead() {
  std::ifstream io("/proc/self/io");
  std::string key;
  std::uintmax_t count = 0;
  io >> key >> count;
  EXPECT_EQ(key, "rchar:");
  return count;
}

TEST(ContentHash, OfAnUntouchedInputIsReadOnceInAWholeRun) {
  const fs::path recording = SourceDir() / "data/sts-study/human.mp4";
  const TemporaryFolder folder;
  const std::uintmax_t before = BytesRead();
  lake::Run run({"lake-x", "lake-x", {}, folder / "out", true});
  run.AddInput(recording, "text");
  run.AddInput(recording, "text");
  run.WriteSummary(Json::object());
  EXPECT_LT(BytesRead() - before, 3 * fs::file_size(recording) / 2);
}

TEST(ContentHash, IsThatOfTheContentAlsoWhereTheTimeOfWritingIsPutBack) {
  const TemporaryFolder folder;
  const fs::path path = folder / "in.csv";
  std::ofstream(path) << "one";
  const std::string of_one = Sha256OfFile(path);
  const auto time = fs::last_write_time(path);
  std::ofstream(path) << "two";
  fs::last_write_time(path, time);
  EXPECT_EQ(of_one, Sha256OfText("one"));
  EXPECT_EQ(Sha256OfFile(path), Sha256OfText("two"));
}

class Untouched : public testing::Test {
 protected:
  // Changed three seconds before it was seen.
  FileStamp known_{10, 1'000'000'000, 1'000'000'000, 7, true, 4'000'000'000};
  FileStamp now_{10, 1'000'000'000, 1'000'000'000, 7, true, 9'000'000'000};
};

TEST_F(Untouched, IfNothingDiffers) {
  EXPECT_TRUE(IsUntouched(now_, known_));
}

TEST_F(Untouched, NotIfOneOfItsMarksDiffers) {
  for (const auto mark : {&FileStamp::size, &FileStamp::modified_ns, &FileStamp::changed_ns}) {
    FileStamp other = now_;
    other.*mark -= 1;
    EXPECT_FALSE(IsUntouched(other, known_));
  }
  now_.inode = 8;
  EXPECT_FALSE(IsUntouched(now_, known_));
}

TEST_F(Untouched, NotIfItsLastChangeWasTooFreshToTellFromALaterOne) {
  known_.seen_ns = 2'500'000'000;
  EXPECT_FALSE(IsUntouched(now_, known_));
}

TEST_F(Untouched, NotIfItIsNoFile) {
  now_.is_file = false;
  EXPECT_FALSE(IsUntouched(now_, known_));
}

}  // namespace
}  // namespace lake
