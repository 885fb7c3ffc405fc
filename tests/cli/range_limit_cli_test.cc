// A mechanism's measured range against its limits, as lake-gait says it.
#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <regex>

#include "cli/program_run.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"

namespace lake {
namespace {

using testing::HasSubstr;

class RangeLimit : public testing::Test {
 protected:
  // A mechanism with its shank held upright, bent from 4° to 112° and back three times in twelve seconds. In the frames
  // between these two the ankle alone is seen.
  void Write(int hidden_from, int hidden_to) {
    std::ofstream out(folder_ / "trial.csv");
    out << "frame,time_s";
    for (const char* name : {"ankle", "knee", "hip"})
      out << fmt::format(",{0}_x_mm,{0}_y_mm,{0}_sigma_mm,{0}_status", name);
    for (int frame = 0; frame <= 720; ++frame) {
      const double time_s = frame / 60.0, knee = (58 - 54 * std::cos(M_PI * time_s / 2)) * M_PI / 180;
      out << fmt::format("\n{},{},0,0,0.05,detected", frame, time_s);
      if (frame > hidden_from && frame < hidden_to)
        out << ",,,,missing,,,,missing";
      else
        out << fmt::format(",0,400,0.05,detected,{},{},0.05,detected", -420 * std::sin(knee),
                           400 + 420 * std::cos(knee));
    }
    out << '\n';
  }

  void SetUp() override { Write(0, 0); }

  CsvTable Test(const std::string& options) {
    Done(folder_, kGait + options);
    return CsvTable::Read(folder_ / "G/range_limit.csv");
  }

  const std::string kGait = "lake-gait trial.csv --facing right --quiet -o G ";

  TemporaryFolder folder_;
};

TEST_F(RangeLimit, IsKeptByMoreThanTheUncertainty) {
  const CsvTable table = Test("--range-limit 0,120 --placement-sd 0.5 --depth-sd 0");
  ASSERT_EQ(table.Rows(), 2u);
  const auto value = [&](std::size_t row, const char* column) {
    return table.RequiredNumber(row, table.Column(column));
  };
  EXPECT_NEAR(value(0, "measured_deg"), 4, 0.05);
  EXPECT_NEAR(value(1, "measured_deg"), 112, 0.05);
  EXPECT_EQ(value(0, "visits"), 4);  // begins and ends there
  EXPECT_EQ(value(1, "visits"), 3);
  for (const std::size_t row : {0, 1}) {
    EXPECT_EQ(table.Text(row, table.Column("result")), "pass");
    EXPECT_GT(value(row, "expanded_deg"), 0.1);  // markers 0.5 mm beside axes that are 400 mm apart
    EXPECT_LT(value(row, "expanded_deg"), 0.5);
  }
  EXPECT_TRUE(ReadJsonFile(folder_ / "G/summary.json")["range_limit"]["passes"].get<bool>());
  EXPECT_THAT(ReadTextFile(folder_ / "G/range_limit.html"), HasSubstr("Pass: the measured range"));
  // Markers that are placed more roughly make it more uncertain, in proportion.
  const CsvTable rough = Test("--range-limit 0,120 --placement-sd 5 --depth-sd 0");
  EXPECT_NEAR(rough.RequiredNumber(1, rough.Column("expanded_deg")) / value(1, "expanded_deg"), 10, 0.3);
}

// Of segments of 400 and 420 mm: each marker 0.5 mm beside its axis, the knee's 10 mm · 0.1 off by its distance.
TEST_F(RangeLimit, TheUncertaintyIsOfPlacesAndDistancesAndNotOfScale) {
  const double knee = 1 / 400.0 + 1 / 420.0, placement = 0.5 * std::hypot(knee, 1 / 400.0, 1 / 420.0);
  const double expanded_deg = 2 * std::hypot(placement, 10 * 0.1 * knee) * 180 / M_PI;
  for (const char* scale : {"0", "5"}) {
    const CsvTable table =
        Test(fmt::format("--range-limit 0,120 --placement-sd 0.5 --depth-sd 10 --view-slope 0.1 --scale-sd {}", scale));
    for (const std::size_t row : {0, 1})
      EXPECT_NEAR(table.RequiredNumber(row, table.Column("expanded_deg")), expanded_deg, 0.01) << scale;
  }
}

// For two seconds of twelve, in which it goes to its largest angle and back.
TEST_F(RangeLimit, IsNotShownWhereTheAngleIsUnknownTooOften) {
  Write(300, 420);
  const CsvTable table = Test("--range-limit -60,230 --placement-sd 0.5 --depth-sd 0");
  for (const std::size_t row : {0, 1}) {
    EXPECT_EQ(table.Text(row, table.Column("result")), "not shown");
    EXPECT_GT(table.RequiredNumber(row, table.Column("unknown_percent")), 5);
    EXPECT_GT(table.RequiredNumber(row, table.Column("unknown_frames")), 36);
    EXPECT_LT(table.RequiredNumber(row, table.Column("unknown_frames")), 120);
  }
  EXPECT_FALSE(ReadJsonFile(folder_ / "G/summary.json")["range_limit"]["passes"].get<bool>());
  EXPECT_THAT(ReadTextFile(folder_ / "G/range_limit.html"), HasSubstr("Not shown: "));
  EXPECT_THAT(ReadTextFile(folder_ / "G/range_limit.html"), HasSubstr("Frames without a measured angle: "));
}

TEST_F(RangeLimit, FailsWhereItIsPassedOrNotShownToBeKept) {
  CsvTable table = Test("--range-limit 0,112.1 --placement-sd 0.5");
  EXPECT_EQ(table.Text(0, table.Column("result")), "pass");
  EXPECT_EQ(table.Text(1, table.Column("result")), "fail");
  EXPECT_THAT(ReadTextFile(folder_ / "G/range_limit.html"), HasSubstr("not shown to be kept"));
  table = Test("--range-limit 6,120 --placement-sd 0.5");
  EXPECT_EQ(table.Text(0, table.Column("result")), "fail");
  EXPECT_NEAR(table.RequiredNumber(0, table.Column("margin_deg")), -2, 0.05);
  EXPECT_THAT(ReadTextFile(folder_ / "G/range_limit.html"), HasSubstr("the limit is passed"));
  ExpectRefused(folder_, kGait + "--range-limit 120,0", 2, "--range-limit");
  WriteTextFile(folder_ / "trial.csv",
                std::regex_replace(ReadTextFile(folder_ / "trial.csv"), std::regex("knee"), "elbow"));
  ExpectRefused(folder_, kGait + "--range-limit 0,120 --distance reach=ankle,elbow", 2,
                "--range-limit needs the markers ankle, knee and hip");
}

}  // namespace
}  // namespace lake
