// lake-optimize as a user calls it: exit codes, files, one-line errors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>

#include "lake/core/angles.h"
#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"
#include "lake/problem/problem_file.h"
#include "lake/problem/problem_options.h"
#include "load_profile.h"
#include "places.h"
#include "program_run.h"
#include "synthesis/program_run.h"
#include "temporary_folder.h"

namespace lake {
namespace {

TEST(LakeOptimize, WritesEverythingThatTheInterfaceNames) {
  const TemporaryFolder folder;
  const Ended ended = RunProgram("--starts 5 --certify 0.5 -o " + folder.Path().string());
  EXPECT_EQ(ended.exit_code, 0) << ended.text;
  for (const char* name :
       {"design.yaml", "optimum.csv", "constraints.csv", "summary.json", "sensitivity.csv", "sensitivity.png",
        "starts.csv", "margin.csv", "margin.png", "convergence.csv", "convergence.png", "options.toml"})
    EXPECT_GT(std::filesystem::file_size(folder / name), 0u) << name;
  const Json summary = ReadJsonFile(folder / "summary.json");
  for (const char* key : {"range_deg", "status", "constraint_violation", "kkt_error", "certified_upper_bound_deg"})
    EXPECT_TRUE(summary.contains(key)) << key;
  EXPECT_EQ(summary["starts"].size(), 5u);
}

// The time of the proof is the user's own limit: the bound so far is written, and the run is no failure.
TEST(LakeOptimize, AProofThatMayTakeNoLongerEndsWithTheGapSoFar) {
  const TemporaryFolder folder;
  const std::string problem = (SourceDir() / "calibration/problems/buildable.yaml").string();
  const Ended ended = RunProgram("--problem " + problem + " --starts 1 --certify 0.001 --certify-time 0.1 -o " +
                                 (folder / "out").string());
  EXPECT_EQ(ended.exit_code, 0) << ended.text;
  EXPECT_NE(ended.text.find("the time of --certify-time was over"), std::string::npos) << ended.text;
  const Json summary = ReadJsonFile(folder / "out/summary.json");
  EXPECT_EQ(summary["certificate"]["ended_by"], "time");
  EXPECT_FALSE(summary["certificate"]["reached"].get<bool>());
  EXPECT_GT(summary["certified_upper_bound_deg"].get<double>(), summary["range_deg"].get<double>());
}

TEST(LakeOptimize, OptionsOverruleTheFile) {
  const TemporaryFolder folder;
  std::ofstream(folder / "problem.yaml") << "margins: {grashof_mm: 5, singularity_mm: 5}\n";
  const std::string common = "--starts 1 --quiet --problem " + (folder / "problem.yaml").string();
  RunProgram(common + " -o " + (folder / "file").string());
  RunProgram(common + " --grashof-margin 2 --singularity-margin 2 -o " + (folder / "option").string());
  // The ranges at margins of 5 and 2 mm, certified in certificate_test.
  EXPECT_NEAR(ReadJsonFile(folder / "file/summary.json")["range_deg"].get<double>(), 143.647, 1e-3);
  EXPECT_NEAR(ReadJsonFile(folder / "option/summary.json")["range_deg"].get<double>(), 153.770, 1e-3);
}

TEST(LakeOptimize, WrittenOptionsReadBack) {
  const TemporaryFolder folder;
  RunProgram("--starts 3 --certify --yield 0.1 --grashof-margin 2 --singularity-margin 2 --quiet -o " +
             (folder / "first").string());
  const Ended again =
      RunProgram("--config " + (folder / "first/options.toml").string() + " -o " + (folder / "second").string());
  ASSERT_EQ(again.exit_code, 0) << again.text;
  Json first = ReadJsonFile(folder / "first/summary.json"), second = ReadJsonFile(folder / "second/summary.json");
  for (const char* key : {"range_deg", "links", "yield", "certified_upper_bound_deg"})
    EXPECT_EQ(first[key], second[key]) << key;
  EXPECT_EQ(first["options"]["certify"], "0.1");
  EXPECT_EQ(second["starts"].size(), 3u);
}

// A file that an option names is read before the options that change what it holds, wherever these stand.
TEST(LakeOptimize, OptionsOfAConfigurationOverruleTheProblemFileToo) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "problem.yaml", "margins: {grashof_mm: 5, singularity_mm: 5}\n");
  WriteTextFile(folder / "options.toml", "grashof-margin=2\nsingularity-margin=2\nstarts=1\n");
  const Ended ended = RunProgram("--config " + (folder / "options.toml").string() + " --problem " +
                                 (folder / "problem.yaml").string() + " --quiet -o " + (folder / "out").string());
  ASSERT_EQ(ended.exit_code, 0) << ended.text;
  EXPECT_NEAR(ReadJsonFile(folder / "out/summary.json")["range_deg"].get<double>(), 153.770, 1e-3);
  EXPECT_EQ(RunProgram("--problem " + (folder / "none.yaml").string() + " --help").exit_code, 0);
}

TEST(LakeOptimize, WithoutSolutionExitsWithThreeAndLeavesTheReason) {
  const TemporaryFolder folder;
  const Ended ended = RunProgram("--starts 2 --quiet --min-moment-arm 60 -o " + folder.Path().string());
  EXPECT_EQ(ended.exit_code, 3);
  EXPECT_THAT(ended.text, ::testing::HasSubstr("cannot hold together"));
  EXPECT_EQ(std::ranges::count(ended.text, '\n'), 1);
  EXPECT_EQ(ReadJsonFile(folder / "summary.json")["status"], "infeasible");
}

// Once it was taken and made no difference: the leg stayed as long as the file has it.
TEST(LakeOptimize, AHeightDoesNotGoWithTheLegOfAProblemFile) {
  const TemporaryFolder folder;
  WriteTextFile(folder / "problem.yaml",
                "clearances: {seat_mm: 5}\nbody: {height_mm: 1750, mass_kg: 70, thigh_mm: 410, shank_mm: 400}\n");
  const Ended refused =
      RunProgram("--problem " + (folder / "problem.yaml").string() + " --height 1950 -o " + (folder / "out").string());
  EXPECT_EQ(refused.exit_code, 2) << refused.text;
  EXPECT_THAT(refused.text, testing::HasSubstr("--height 1950 mm: the file has the person's own thigh and "
                                               "shank (410 and 400 mm)"));
  const auto height_mm = [](problem::SynthesisProblem problem, const std::map<std::string, std::string>& given) {
    OptionList options = OptionsOf(problem);
    for (Option& option : options.All())
      if (const auto found = given.find(option.Name()); found != given.end()) option.Give({found->second});
    options.Apply();
    return *problem.clearances.body.height_mm;
  };
  problem::SynthesisProblem problem = problem::ReadProblem(folder / "problem.yaml");
  EXPECT_EQ(height_mm(problem, {{"height", "1950"}, {"thigh", "470"}, {"shank", "460"}}), 1950);
  EXPECT_EQ(height_mm(problem, {{"mass", "80"}}), 1750);
  problem.clearances.body.leg.reset();
  EXPECT_EQ(height_mm(problem, {{"height", "1950"}}), 1950);
}

TEST(LakeOptimize, WrongInputIsOneLineAndNothingIsWritten) {
  const TemporaryFolder folder;
  ExpectRefused(
      {
          {"--no-such-option", 2, "no-such-option"},
          {"--starts", 2, "--starts needs a value: INT"},
          {"--comparison --human-only", 2, "--comparison needs a value: DIR"},
          {"--threads 0", 2, "--threads must be at least 1"},
          {"--start 1,2,3", 2, "6 numbers"},
          {"--height 1750", 2, "give --clear-seat or --clear-limb too"},
          {"--clear-seat 5 --thigh 410", 2, "--thigh and --shank"},
          {"--clear-limb 5", 2, "give mount: behind"},
          {"--mount below", 2, "--mount"},
          {"--clear-limb -1", 2, "--clear-limb must be at least 0, not -1"},
          {"--robust 7", 2, "robust_mm"},
          {"--start 0,85,85,80,80,235", 2, "l1 is 0 mm"},
          {"--start nan,85,85,80,80,235", 2, "nan"},
          {"--starts 0", 2, "starts"},
          {"--certify -1", 2, "--certify must be positive"},
          {"--certify-time 5", 2, "--certify-time limits --certify: give --certify as well"},
          {"--certify=nan", 2, "--certify"},
          {"--yield 0", 2, "--yield must be positive"},
          {"--yield=-1", 2, "--yield must be positive"},
          {"--round -1", 2, "--round"},
          {"--max-length 200", 2, "must exceed"},
          {"--max-force 0", 2, "--max-force must be positive"},
          {"--knee-torque 40000", 2, "knee_torque_nm 40000 N m: a knee's moment lies between -1000 and 1000 N m"},
          {"--max-force 1e6", 2, "max_force_n 1000000 N: an actuator's force lies between 0 and 100000 N"},
          {"--max-angle nan", 2, "--max-angle"},
          {"--problem /no/such/file.yaml", 1, "no such file"},
      },
      folder / "out");
}

// lake-optimize with a load profile and actuators, as a user runs it.

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
