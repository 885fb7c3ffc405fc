// lake-optimize as a user calls it: exit codes, files, one-line errors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>

#include "lake/core/atomic_file.h"
#include "lake/core/json.h"
#include "lake/problem/problem_file.h"
#include "lake/problem/problem_options.h"
#include "places.h"
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

}  // namespace
}  // namespace lake
