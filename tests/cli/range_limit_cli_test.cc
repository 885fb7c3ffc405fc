// A mechanism's measured range against its limits, as lake-gait says it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "cli/program_run.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"

namespace lake {
namespace {

using testing::HasSubstr;

class RangeLimit : public testing::Test {
 protected:
  // A mechanism with its shank held upright, bent from 4° to 112° and back three times in twelve seconds.
  void SetUp() override {
    std::ofstream out(folder_ / "trial.csv");
    out << "frame,time_s";
    for (const char* name : {"ankle", "knee", "hip"})
      out << fmt::format(",{0}_x_mm,{0}_y_mm,{0}_sigma_mm,{0}_status", name);
    for (int frame = 0; frame <= 720; ++frame) {
      const double time_s = frame / 60.0, knee = (58 - 54 * std::cos(M_PI * time_s / 2)) * M_PI / 180;
      out << fmt::format("\n{},{},0,0,0.05,detected,0,400,0.05,detected,{},{},0.05,detected", frame, time_s,
                         -420 * std::sin(knee), 400 + 420 * std::cos(knee));
    }
    out << '\n';
  }

  Outcome Test(const std::string& options) {
    return Shell(folder_, "lake-gait trial.csv --facing right --quiet -o G " + options);
  }
  CsvTable Table() { return CsvTable::Read(folder_ / "G/range_limit.csv"); }

  TemporaryFolder folder_;
};

TEST_F(RangeLimit, IsKeptByMoreThanTheUncertainty) {
  const Outcome outcome = Test("--range-limit 0,120 --placement-sd 0.5 --depth-sd 0");
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const CsvTable table = Table();
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
  const double fine_deg = value(1, "expanded_deg");
  ASSERT_EQ(Test("--range-limit 0,120 --placement-sd 5 --depth-sd 0").exit_code, 0);
  EXPECT_NEAR(Table().RequiredNumber(1, Table().Column("expanded_deg")) / fine_deg, 10, 0.3);
}

TEST_F(RangeLimit, FailsWhereItIsPassedOrNotShownToBeKept) {
  ASSERT_EQ(Test("--range-limit 0,112.1 --placement-sd 0.5").exit_code, 0);
  CsvTable table = Table();
  EXPECT_EQ(table.Text(0, table.Column("result")), "pass");
  EXPECT_EQ(table.Text(1, table.Column("result")), "fail");
  EXPECT_THAT(ReadTextFile(folder_ / "G/range_limit.html"), HasSubstr("not shown to be kept"));
  ASSERT_EQ(Test("--range-limit 6,120 --placement-sd 0.5").exit_code, 0);
  table = Table();
  EXPECT_EQ(table.Text(0, table.Column("result")), "fail");
  EXPECT_NEAR(table.RequiredNumber(0, table.Column("margin_deg")), -2, 0.05);
  EXPECT_THAT(ReadTextFile(folder_ / "G/range_limit.html"), HasSubstr("the limit is passed"));
  EXPECT_EQ(Test("--range-limit 120,0").exit_code, 2);
}

}  // namespace
}  // namespace lake
