// Walking by lake-gait: its files, and what is said where nobody walks forward.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/program_run.h"
#include "gait/drawn_walk.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

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

}  // namespace
}  // namespace lake
