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
#include "temporary_folder.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class LakeOptimizeWithLoads : public ::testing::Test {
 protected:
  LakeOptimizeWithLoads() {
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

  // `text`: options, in which @ stands for the folder.
  std::string Arguments(std::string text) {
    for (std::size_t at; (at = text.find('@')) != std::string::npos;)
      text.replace(at, 1, folder_.Path().string() + "/");
    return "--problem " + Quoted(SourceDir() / "calibration/problems/buildable.yaml") + " --starts 2 " + text;
  }
  Ended Go(const std::string& text) {
    return RunProgram(Arguments(text) + " --quiet -o " + (folder_ / "out").string());
  }

  TemporaryFolder folder_;
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
  std::vector<Refusal> refusals = {
      {"--assist 0.4", 2, "--profile"},
      {"--profile @loads.json --assist 1.4", 2, "between 0 and 1"},
      {"--profile @none.json", 1, "none.json"},
      {"--profile @own.csv", 1, "own.csv"},
      {"--profile @loads.json --actuator nobody", 1, "no actuator 'nobody'"},
      {"--profile @loads.json --actuator @own.csv", 1, "name one"},
      {"--profile @loads.json --duration 5", 2, "--actuator"},
      {"--profile @loads.json --actuator LA23-2500 --duration free", 2, "not known"},
      {"--profile @loads.json --actuator LA31-1000 --duration 0", 2, "above 0"},
      {"--profile @loads.json --actuator LA31-1000 --duration free --certify", 2, "--certify"},
      {"--profile @loads.json --rest standing", 2, "--actuator"},
      {"--actuators @own.csv", 2, "--profile"},
      {"--profile @loads.json --actuators @none.csv", 1, "none.csv"},
      {"--profile @loads.json --actuators @own.csv --duration free --actuator LA31-1000", 2, "omit one"},
  };
  for (Refusal& refusal : refusals) refusal.arguments = Arguments(refusal.arguments);
  ExpectRefused(refusals, folder_ / "out");
}

}  // namespace
}  // namespace lake
