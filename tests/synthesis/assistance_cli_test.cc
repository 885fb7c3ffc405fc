// lake-optimize with a load profile and actuators, as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"
#include "load_profile.h"
#include "places.h"
#include "program_run.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class LakeOptimizeWithLoads : public ::testing::Test {
 protected:
  LakeOptimizeWithLoads() {
    fs::create_directories(folder_);
    Json profile;
    for (const problem::LoadSample& sample : MadeUpProfile().samples) {
      profile["percent"].push_back(sample.percent);
      profile["time_s"].push_back(sample.percent * 0.016);
      profile["knee_deg"].push_back(DegreesFromRadians(sample.knee_rad));
      profile["knee_nm"].push_back(sample.knee_nm);
    }
    WriteJsonFile(folder_ / "loads.json", profile);
    std::ofstream(folder_ / "own.csv") << "name,closed_mm,stroke_mm,max_force_n,no_load_speed_mm_s,force_speed_points\n"
                                          "weak,240,120,20,30,\nstrong,240,120,1500,60,20 mm/s at 1500 N\n";
  }
  ~LakeOptimizeWithLoads() override { fs::remove_all(folder_); }

  // `text`: options, in which @ stands for the folder.
  Ended Go(std::string text) {
    for (std::size_t at; (at = text.find('@')) != std::string::npos;) text.replace(at, 1, folder_.string() + "/");
    return RunProgram("--problem " + Quoted(SourceDir() / "calibration/problems/buildable.yaml") +
                      " --starts 2 --quiet -o " + (folder_ / "out").string() + " " + text);
  }

  const fs::path folder_ = fs::temp_directory_path() /
                           (std::string("lake_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(LakeOptimizeWithLoads, FindsTheShortestDurationOfAnActuator) {
  const Ended ended = Go("--profile @loads.json --assist 0.4 --actuator @own.csv:strong --duration free");
  ASSERT_EQ(ended.exit_code, 0) << ended.text;
  EXPECT_THAT(ended.text, HasSubstr("strong gives 40 % of the knee moment in a rise of"));
  const Json summary = ReadJsonFile(folder_ / "out/summary.json"), &assistance = summary["assistance"];
  EXPECT_THAT(summary["inputs"].dump(), HasSubstr("own.csv")) << "what is known of the actuator stands there";
  EXPECT_FALSE(fs::exists(folder_ / "out/margin.csv")) << "margins of a range that nobody sought";
  const CsvTable table = CsvTable::Read(folder_ / "out/assistance.csv");
  ASSERT_EQ(table.Rows(), 101u);
  const double shortest_s = assistance["shortest_duration_s"];
  double longest_s = 0;
  for (std::size_t i = 0; i < table.Rows(); ++i)
    longest_s = std::max(longest_s, *table.Number(i, table.Column("least_duration_s")));
  EXPECT_NEAR(longest_s, shortest_s, 1e-9);
  EXPECT_EQ(*table.Number(assistance["limiting_percent"].get<int>(), table.Column("least_duration_s")), longest_s);
  EXPECT_GE(shortest_s, assistance["any_linkage_duration_s"].get<double>());
  const Ended faster =
      Go("--profile @loads.json --assist 0.4 --actuator @own.csv:strong --duration " + FormatNumber(shortest_s * 0.9));
  EXPECT_EQ(faster.exit_code, 3);
  EXPECT_THAT(faster.text, HasSubstr("relax duration"));
}

TEST_F(LakeOptimizeWithLoads, ComparesTheActuatorsOfAFile) {
  const Ended ended = Go("--profile @loads.json --actuators @own.csv");
  ASSERT_EQ(ended.exit_code, 0) << ended.text;
  const CsvTable table = CsvTable::Read(folder_ / "out/actuators_front.csv");
  const std::size_t name = table.Column("actuator"), status = table.Column("status"), time = table.Column("duration_s");
  double last_s = 0;
  for (std::size_t i = 0; i < table.Rows(); ++i) {
    if (table.Text(i, name) == "weak") {
      EXPECT_EQ(table.Text(i, status), "no design");
      EXPECT_THAT(table.Text(i, table.Column("reason")), HasSubstr("force ≤ 20 N"));
    } else {
      EXPECT_EQ(table.Text(i, status), "solved");
      EXPECT_GE(*table.Number(i, time), last_s * (1 - 1e-6)) << "a larger share cannot be had in less time";
      last_s = *table.Number(i, time);
    }
  }
  EXPECT_TRUE(fs::exists(folder_ / "out/actuators_front.png"));
}

TEST_F(LakeOptimizeWithLoads, WrongInputIsOneLine) {
  const struct {
    const char *options, *reason;
    int exit_code;
  } cases[] = {
      {"--assist 0.4", "--profile", 2},
      {"--profile @loads.json --assist 1.4", "between 0 and 1", 2},
      {"--profile @none.json", "none.json", 1},
      {"--profile @own.csv", "own.csv", 1},
      {"--profile @loads.json --actuator nobody", "no actuator 'nobody'", 1},
      {"--profile @loads.json --actuator @own.csv", "name one", 1},
      {"--profile @loads.json --duration 5", "--actuator", 2},
      {"--profile @loads.json --actuator LA23-2500 --duration free", "not known", 2},
      {"--profile @loads.json --actuator LA31-1000 --duration 0", "above 0", 2},
      {"--profile @loads.json --actuator LA31-1000 --duration free --certify", "--certify", 2},
      {"--profile @loads.json --rest standing", "--actuator", 2},
      {"--actuators @own.csv", "--profile", 2},
      {"--profile @loads.json --actuators @none.csv", "none.csv", 1},
      {"--profile @loads.json --actuators @own.csv --duration free --actuator LA31-1000", "omit one", 2},
  };
  for (const auto& [options, reason, exit_code] : cases) {
    const Ended ended = Go(options);
    EXPECT_EQ(ended.exit_code, exit_code) << options << ": " << ended.text;
    EXPECT_THAT(ended.text, HasSubstr(reason)) << options;
    EXPECT_EQ(std::count(ended.text.begin(), ended.text.end(), '\n'), 1) << ended.text;
    EXPECT_FALSE(fs::exists(folder_ / "out")) << options;
  }
}

}  // namespace
}  // namespace lake
