// Walking by lake-gait and lake-compare: their files, and what is said where nobody walks forward.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/program_run.h"
#include "gait/drawn_walk.h"
#include "gait/worn_joint_marker.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

class WalkingProgram : public testing::Test {
 protected:
  Outcome Gait(const DrawnWalkOptions& drawn, const std::string& options) {
    motion::WriteMarkerCsv(folder_ / "walk.csv", DrawWalk(drawn));
    return Shell(folder_, "lake-gait walk.csv --json -o W " + options);
  }
  TemporaryFolder folder_;
};

TEST_F(WalkingProgram, WritesTheStrides) {
  DrawnWalkOptions drawn;
  drawn.noise_mm = 0.5;
  const Outcome outcome = Gait(drawn, "");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Json summary = Json::parse(outcome.out);
  EXPECT_EQ(summary["movement"], "walking");
  EXPECT_EQ(summary["walking"]["ground"], "overground");
  EXPECT_EQ(summary["walking"]["incomplete_strides"], 2);
  const CsvTable cycles = CsvTable::Read(folder_ / "W/gait_cycles.csv");
  const int strides = summary["walking"]["strides"];
  EXPECT_EQ(static_cast<int>(cycles.Rows()), strides + 2);
  // As drawn; the tolerance is that of tests/gait/walking_test.cc.
  EXPECT_NEAR(cycles.RequiredNumber(0, cycles.Column("stride_s")), drawn.stride_s, 0.01);
  EXPECT_TRUE(CsvTable::Read(folder_ / "W/events.csv").Has("sd_s"));
  const CsvTable kinematics = CsvTable::Read(folder_ / "W/kinematics.csv");
  int in_stride = 0;
  for (std::size_t row = 0; row < kinematics.Rows(); ++row)
    in_stride += kinematics.Number(row, kinematics.Column("percent")).has_value() ? 1 : 0;
  EXPECT_NEAR(in_stride, strides * drawn.stride_s * drawn.rate_hz, 5);
  EXPECT_TRUE(fs::exists(folder_ / "W/gait_cycles.png"));
  EXPECT_FALSE(fs::exists(folder_ / "W/sit_to_stand.csv"));
}

TEST_F(WalkingProgram, SaysWhatItLeavesOut) {
  DrawnWalkOptions drawn;
  drawn.is_backward = true;
  const Outcome outcome = Gait(drawn, "");
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("the person walks backward"));
  EXPECT_THAT(outcome.err, HasSubstr("repetition and percent are left empty"));
  EXPECT_FALSE(fs::exists(folder_ / "W/gait_cycles.csv"));
  EXPECT_EQ(Gait({}, "--movement dancing").exit_code, 2);
}

// A walk, and a slower one back with the exoskeleton's joint 12 mm from the knee.
class WalkingComparisonProgram : public testing::Test {
 protected:
  WalkingComparisonProgram() {
    DrawnWalkOptions drawn;
    drawn.noise_mm = 0.5;
    motion::WriteMarkerCsv(folder_ / "walk.csv", DrawWalk(drawn));
    drawn.stride_s = 1.5;
    drawn.stride_mm = 1100;
    drawn.length_s = 8;
    drawn.direction = -1;
    motion::MarkerRecording worn = DrawWalk(drawn);
    AddWornJoint({9, -7.93725}, -1, worn);
    motion::WriteMarkerCsv(folder_ / "worn.csv", worn);
  }
  TemporaryFolder folder_;
};

TEST_F(WalkingComparisonProgram, ComparesWalks) {
  const Outcome outcome = Shell(folder_, "lake-compare walk.csv worn.csv -o C");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("path difference at equal percent of the stride, relative to the hip,"));
  const Json comparison = ReadJsonFile(folder_ / "C/comparison.json");
  EXPECT_EQ(comparison["movement"], "walking");
  EXPECT_NEAR(comparison["joint"]["rms_mm"].get<double>(), 12, 0.5);
  EXPECT_NEAR(comparison["duration_s"]["exo"].get<double>(), 1.5, 0.02);
  const std::string report = ReadTextFile(folder_ / "C/report.html");
  EXPECT_THAT(report, HasSubstr("relative to the hip, x in the direction of walking"));
  for (const std::string& text : {outcome.out, comparison.dump(), report, ReadTextFile(folder_ / "C/misalignment.svg")})
    for (const char* of_rises :
         {"the rise", "rise (%)", "from rise", "seat-off", "what seat", "to standing", "stroke program"})
      EXPECT_THAT(text, Not(HasSubstr(of_rises)));
  EXPECT_FALSE(fs::exists(folder_ / "C/cuffs.csv"));
  // By what lake-gait wrote, and by the first comparison's curve.
  ASSERT_EQ(Shell(folder_, "lake-gait worn.csv -o W").exit_code, 0);
  ASSERT_EQ(Shell(folder_, "lake-compare C W -o D").exit_code, 0);
  EXPECT_NEAR(ReadJsonFile(folder_ / "D/comparison.json")["joint"]["rms_mm"].get<double>(), 12, 0.5);
}

TEST_F(WalkingComparisonProgram, RefusesAnotherMovement) {
  ASSERT_EQ(Shell(folder_, "lake-compare walk.csv worn.csv -o C").exit_code, 0);
  Json of_rises = ReadJsonFile(folder_ / "C/comparison.json");
  of_rises["movement"] = "sit-to-stand";
  WriteJsonFile(folder_ / "C/comparison.json", of_rises);
  const Outcome outcome = Shell(folder_, "lake-compare C worn.csv -o D");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("C is of sit-to-stand and worn.csv of walking"));
}

}  // namespace
}  // namespace lake
