// lake-run as a user runs it: exit codes, one-line errors, interrupted and gone on with.
#include <gmock/gmock.h>

#include <set>

#include "cli/program_run.h"
#include "lake/core/json.h"
#include "places.h"

namespace lake {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// The linkage moving, which these tests do not look at, is most of a simulation's time.
constexpr const char* kNoAnimation = "simulate: {animation: false}\n";

// The first rise of each of the sample study's videos.
class RunProgram : public testing::Test {
 protected:
  static std::string Sample(const std::string& name) {
    return "\"" + (SourceDir() / "data/sts-study" / name).string() + "\"";
  }

  void WriteStudy(const std::string& rest = "") {
    WriteTextFile(
        folder_ / "study.yaml",
        fmt::format("camera: {}\nhuman: {{video: {}, end_s: 4.17, overlay: false}}\nexo: {{video: {}, end_s: 4.67, "
                    "overlay: false, markers: [ankle, knee, hip, waist, exo_knee], seeds: "
                    "[\"knee=728,431\", \"exo_knee=740,415\"]}}\n{}",
                    Sample("camera.yaml"), Sample("human.mp4"), Sample("exo.mp4"), rest));
  }

  void ExpectRefused(const std::string& arguments, int exit_code, const std::string& text) {
    lake::ExpectRefused(folder_, "lake-run --quiet -o results " + arguments, exit_code, text);
    EXPECT_EQ(FilesIn(folder_ / "results"), 0u);
  }

  TemporaryFolder folder_;
};

TEST_F(RunProgram, RefusesStudiesThatCannotBe) {
  ExpectRefused("absent.yaml", 1, "absent.yaml: no such file");
  ExpectRefused("", 2, "study");
  WriteStudy("compair: {}\n");
  ExpectRefused("study.yaml", 1, "study.yaml:4: unknown key 'compair'");
  WriteStudy("design: {problem: no-problem.yaml, worn: no-design.yaml}\n");
  ExpectRefused("study.yaml", 1, "2 files are missing");
}

TEST_F(RunProgram, InterruptedGoesOnWhereItWas) {
  WriteStudy(kNoAnimation);
  const std::string run = "lake-run study.yaml --quiet -o results";
  const Outcome stopped =
      Shell(folder_, run +
                         " & while kill -0 $! && [ ! -e results/human/.human.lake-step.json ]; do sleep 0.02; done; "
                         "kill -TERM $!; wait $!");
  EXPECT_EQ(stopped.exit_code, 143) << stopped.err;
  EXPECT_THAT(stopped.err, HasSubstr("lake-run: interrupted"));
  EXPECT_FALSE(fs::exists(folder_ / "results/report.html"));
  std::set<std::string> finished;
  for (const auto& entry : fs::recursive_directory_iterator(folder_ / "results")) {
    const std::string name = entry.path().filename().string();
    constexpr std::string_view kStamp = ".lake-step.json";
    if (name.ends_with(kStamp)) {
      finished.insert(name.substr(1, name.size() - 1 - kStamp.size()));
    } else if (name.starts_with(".")) {
      EXPECT_THAT(name, testing::EndsWith(".lake-files.json")) << "half-written";
    }
  }
  EXPECT_TRUE(finished.contains("human"));

  const Json summary = DoneJson(folder_, run + " --json");
  for (const Json& step : summary["steps"])
    EXPECT_EQ(step["done"].get<bool>(), !finished.contains(step["name"].get<std::string>())) << step["name"];
  EXPECT_EQ(summary, Json::parse(ReadTextFile(folder_ / "results/summary.json")));
  EXPECT_TRUE(fs::is_regular_file(folder_ / "results/report.html"));
}

// The steps write what the programs write; the front door does the same.
TEST_F(RunProgram, WritesWhatTheProgramsWrite) {
  WriteStudy(kNoAnimation);
  Done(folder_, "lake run study.yaml --quiet -o results");
  const std::string track = "lake-track --quiet --no-overlay --camera " + Sample("camera.yaml");
  Done(folder_, track + " --end 4.17 -o human " + Sample("human.mp4"));
  Done(folder_, track +
                    " --end 4.67 --markers ankle,knee,hip,waist,exo_knee --seed knee=728,431 --seed "
                    "exo_knee=740,415 -o exo " +
                    Sample("exo.mp4"));
  Done(folder_, "lake-compare human exo -o comparison && lake-optimize --quiet -o optimum");
  for (const char* file :
       {"human/tracks.csv", "human/kinematics.csv", "exo/trajectory.csv", "exo/events.csv",
        "comparison/misalignment.csv", "comparison/comparison.json", "optimum/design.yaml", "optimum/optimum.csv"})
    EXPECT_EQ(ReadTextFile(folder_ / "results" / file), ReadTextFile(folder_ / file)) << file;
}

TEST_F(RunProgram, EndsAsTheStepThatFailed) {
  // No design comes near 0.001 % of the shank at one speed.
  WriteStudy("reoptimize: {max_misalignment_percent: 0.001, human_only: true, starts: 3}\n");
  const Outcome outcome = Shell(folder_, "lake-run study.yaml --quiet -o results");
  EXPECT_EQ(outcome.exit_code, 3) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("lake-run: step redesign"));
  EXPECT_TRUE(fs::is_regular_file(folder_ / "results/redesign/design.yaml")) << "the nearest, marked as such";
  EXPECT_TRUE(fs::is_regular_file(folder_ / "results/optimum/design.yaml"));
  EXPECT_FALSE(fs::exists(folder_ / "results/simulation"));
}

// What a scheduler asks and does: the plan writes nothing, and a step alone neither the study's summary nor another
// step.
TEST_F(RunProgram, PlansAndDoesStepsOneByOne) {
  // On one thread steps follow one another, so that a plan's time is the sum of theirs.
  constexpr const char* kPlan = "lake-run study.yaml --plan --threads 1 -o results";
  WriteStudy();
  const Json plan = DoneJson(folder_, kPlan);
  EXPECT_EQ(FilesIn(folder_ / "results"), 0u);
  EXPECT_EQ(plan["steps"][3]["name"], "optimum");
  EXPECT_TRUE(plan["steps"][3]["last_run"].is_null());
  ExpectRefused("study.yaml --only report", 1, "step human leaves, which has not been done");
  ExpectRefused("study.yaml --only stroke", 1, "no step 'stroke' in this study");
  ExpectRefused("study.yaml --only human --plan", 2, "not with --only");
  Done(folder_, "lake-run study.yaml --quiet -o results --only optimum");
  EXPECT_TRUE(fs::is_regular_file(plan["steps"][3]["outputs"][0].get<std::string>()));
  EXPECT_FALSE(fs::exists(folder_ / "results/summary.json"));
  EXPECT_FALSE(fs::exists(folder_ / "results/human"));
  const Json again = DoneJson(folder_, kPlan);
  EXPECT_TRUE(again["steps"][3]["due"].is_null());
  EXPECT_GT(again["steps"][3]["last_run"]["seconds"], 0);
  EXPECT_GT(again["steps"][3]["last_run"]["memory_mb"], 10);
}

}  // namespace
}  // namespace lake
