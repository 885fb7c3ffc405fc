// comparison.json: what was written is read back; what is not such a file is refused in one line.
#include "lake/compare/comparison_file.h"

#include <gmock/gmock.h>

#include <functional>

#include "closed_form.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "message_of.h"
#include "temporary_folder.h"

namespace lake {
namespace {

using testing::HasSubstr;

compare::Misalignment Compared() {
  ClosedFormLeg other;
  other.peak_shank_deg = 22;
  compare::MisalignmentOptions options;
  options.intervals = false;
  return compare::CompareTrials({{MakeCurve({})}, {}}, {{MakeCurve(other, IssueWarp, {8, -3})}, {}}, options);
}

class ComparisonFile : public testing::Test {
 protected:
  void Write(const Json& json) { WriteJsonFile(folder_ / "comparison.json", json); }

  void ExpectRefused(const std::function<void(Json&)>& change, const std::string& text) {
    Json json = json_;
    change(json);
    Write(json);
    EXPECT_THAT(MessageOf([&] { compare::ReadComparison(folder_.Path()); }),
                testing::AllOf(HasSubstr("comparison.json"), HasSubstr(text), testing::Not(HasSubstr("\n"))));
  }

  TemporaryFolder folder_;
  const compare::Misalignment misalignment_ = Compared();
  const Json json_ = compare::ComparisonJson(misalignment_);
};

TEST_F(ComparisonFile, CurvesReadBackAsTheSameNumbers) {
  Write(json_);
  for (const auto& path : {folder_.Path(), folder_ / "comparison.json"}) {
    const compare::ComparedCurves curves = compare::ReadComparison(path);
    for (const auto& [read, written] :
         {std::pair(&curves.human, &misalignment_.human), std::pair(&curves.exo, &misalignment_.exo)}) {
      EXPECT_EQ(read->ankle, written->ankle);
      EXPECT_EQ(read->knee, written->knee);
      EXPECT_EQ(read->hip, written->hip);
      EXPECT_EQ(read->knee_deg, written->knee_deg);
      EXPECT_EQ(read->knee_sigma_mm, written->knee_sigma_mm);
      EXPECT_EQ(read->duration_s, written->duration_s);
    }
    compare::MisalignmentOptions options;
    options.intervals = false;
    const compare::Misalignment again = compare::CompareTrials({{curves.human}, {}}, {{curves.exo}, {}}, options);
    EXPECT_EQ(again.metrics.relative_rms, misalignment_.metrics.relative_rms);
    EXPECT_EQ(again.decomposition.timing, misalignment_.decomposition.timing);
  }
}

TEST_F(ComparisonFile, OtherVersionsAreNamed) {
  ExpectRefused([](Json& j) { j.erase("format"); }, "made by an older version of lake-compare");
  ExpectRefused([](Json& j) { j["format"] = 0; }, "made by an older version of lake-compare");
  ExpectRefused([](Json& j) { j["format"] = "one"; }, "made by an older version of lake-compare");
  ExpectRefused([](Json& j) { j["format"] = 2; }, "made by a newer version of lake-compare");
  ExpectRefused([](Json& j) { j["format"] = 4294967297; }, "made by a newer version of lake-compare");
}

TEST_F(ComparisonFile, DamagedCurvesAreNamed) {
  ExpectRefused([](Json& j) { j.erase("curves"); }, "'percent' is missing");
  ExpectRefused([](Json& j) { j["curves"] = 5; }, "'percent' is missing");
  ExpectRefused([](Json& j) { j["curves"].erase("human_hip_y_mm"); }, "'human_hip_y_mm' is missing");
  ExpectRefused([](Json& j) { j["curves"]["exo_knee_x_mm"].erase(0); }, "curves.exo_knee_x_mm must be a list of 101");
  ExpectRefused([](Json& j) { j["curves"]["exo_knee_x_mm"] = "many"; }, "curves.exo_knee_x_mm must be a list of 101");
  ExpectRefused([](Json& j) { j["curves"]["human_knee_x_mm"][7] = nullptr; }, "curves.human_knee_x_mm[7] = null");
  ExpectRefused([](Json& j) { j["curves"]["human_knee_x_mm"][7] = "x"; }, "is not a number");
  ExpectRefused([](Json& j) { j["curves"]["percent"][3] = 3.5; }, "does not run from 0 to 100");
  ExpectRefused([](Json& j) { j["curves"]["shank_mm"][50] = 1; }, "curves.shank_mm[50] = 1 contradicts");
  ExpectRefused([](Json& j) { j["duration_s"].erase("exo"); }, "duration_s.exo is missing");
  ExpectRefused([](Json& j) { j["duration_s"] = {1, 2}; }, "duration_s.human is missing");
  ExpectRefused([](Json& j) { j["duration_s"]["exo"] = 0; }, "duration_s.exo = 0 is not above 0");
  ExpectRefused([](Json& j) { j["noise_floor_mm"] = -1; }, "noise_floor_mm = -1 is below 0");
}

TEST_F(ComparisonFile, OtherFilesAreRefused) {
  ExpectRefused([](Json& j) { j = Json::array({1, 2}); }, "not a comparison");
  ExpectRefused([](Json& j) { j = {{"program", "lake-track"}}; }, "not a comparison");
  WriteTextFile(folder_ / "comparison.json", "{\"format\": 1,");
  EXPECT_THAT([&] { compare::ReadComparison(folder_.Path()); },
              testing::ThrowsMessage<Error>(HasSubstr("not JSON: parse error")));
  EXPECT_THAT(
      [&] { compare::ReadComparison(folder_ / "absent"); },
      testing::ThrowsMessage<Error>(HasSubstr("not there; a comparison is the folder that lake-compare wrote")));
}

}  // namespace
}  // namespace lake
