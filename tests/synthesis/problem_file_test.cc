#include "lake/problem/problem_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <sstream>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/problem/load_profile.h"
#include "message_of.h"
#include "places.h"
#include "temporary_folder.h"

namespace lake {
namespace {

class ProblemFile : public ::testing::Test {
 protected:
  std::filesystem::path Write(const std::string& text) {
    WriteTextFile(folder_ / "problem.yaml", text);
    return folder_ / "problem.yaml";
  }
  std::string ErrorOf(const std::string& text) {
    return MessageOf([&] { problem::ReadProblem(Write(text)); });
  }
  TemporaryFolder folder_;
};

// As it is written it is the paper's problem; with every key set that needs no other file, each is known.
TEST_F(ProblemFile, TheTemplateIsThePapersProblemAndAllItsKeysAreKnown) {
  const problem::SynthesisProblem read = problem::ReadProblem(Write(problem::ProblemTemplate()));
  const problem::SynthesisProblem paper;
  EXPECT_EQ(read.d_min_mm, paper.d_min_mm);
  EXPECT_FALSE(read.limits["max_force_n"] || read.clearances.AreAsked());
  std::istringstream lines(problem::ProblemTemplate());
  std::string text;
  int keys = 0;
  for (std::string line; std::getline(lines, line);) {
    const bool is_key = line.find(':') < line.rfind('#') || line.back() == ':';
    const bool needs_a_file = line.find("actuator:") != line.npos || line.find("profile:") != line.npos ||
                              line.find("assist:") != line.npos || line.find("duration_s:") != line.npos;
    if (!is_key || needs_a_file || line.find(" for `lake") != line.npos) continue;
    text += (line.starts_with('#') ? line.substr(1) : line) + "\n";
    ++keys;
  }
  EXPECT_GT(keys, 40);
  EXPECT_EQ(ErrorOf(text), "") << text;
}

TEST_F(ProblemFile, PapersFileIsTheDefaultProblem) {
  const problem::SynthesisProblem read = problem::ReadProblem(SourceDir() / "calibration/problems/paper.yaml");
  const problem::SynthesisProblem paper;
  EXPECT_EQ(read.d_min_mm, paper.d_min_mm);
  EXPECT_EQ(read.start.Values(), paper.start.Values());
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(read.bounds[i].lower, paper.bounds[i].lower);
    EXPECT_EQ(read.bounds[i].upper, paper.bounds[i].upper);
  }
  EXPECT_EQ(problem::RequirementsOf(read).size(), problem::RequirementsOf(paper).size());
}

TEST_F(ProblemFile, AllKeysArrive) {
  const problem::SynthesisProblem problem = problem::ReadProblem(
      Write("d_min_mm: 240\nd_max_mm: 360\nbounds: {l5: [40, 60]}\nstart: {l1: 70}\nmargins: {grashof_mm: "
            "1, singularity_mm: 2}\n"
            "load: {knee_torque_nm: 30, max_force_n: 1500}\nmin_moment_arm_mm: 12\nmin_transmission_deg: "
            "9\nmax_angle_deg: 150\n"
            "standing_deg: 3\n"));
  EXPECT_EQ(problem.d_min_mm, 240);
  EXPECT_EQ(problem.limits["d_max_mm"], 360);
  EXPECT_EQ(problem.bounds[4].upper, 60);
  EXPECT_EQ(problem.bounds[0].upper, 100);
  EXPECT_EQ(problem.start.l1, 70);
  EXPECT_EQ(problem.start.l2, 85);
  EXPECT_EQ(problem.grashof_margin_mm, 1);
  EXPECT_EQ(problem.singularity_margin_mm, 2);
  EXPECT_EQ(problem.knee_torque_nm, 30);
  EXPECT_EQ(problem.limits["max_force_n"], 1500);
  EXPECT_EQ(problem.limits["min_moment_arm_mm"], 12);
  EXPECT_EQ(problem.limits["min_transmission_deg"], 9);
  EXPECT_EQ(problem.limits["max_angle_deg"], 150);
  EXPECT_EQ(problem.standing_deg, 3);
}

TEST_F(ProblemFile, ErrorsNameFileLineAndReason) {
  const struct {
    const char *text, *line, *reason;
  } cases[] = {
      {"d_min_mm: 242\nmargin: {grashof_mm: 1}\n", ":2:", "unknown key 'margin'; did you mean 'margins'?"},
      {"links: {l1: 59}\n", ":1:", "is a design, not a problem"},
      {"bounds:\n  l1: [90, 80]\n", ":2:", "contradict"},
      {"bounds:\n  l1: [90]\n", ":2:", "2 numbers"},
      {"bounds:\n  l9: [1, 2]\n", ":2:", "unknown key 'l9'"},
      {"bounds:\n  l1: [0, 80]\n", ":2:", "above 0"},
      {"bounds:\n  l1: [50, .nan]\n", ":2:", "a finite number, not"},
      {"start:\n  l1: -3\n", ":2:", "l1 is -3 mm"},
      {"d_min_mm: 242\nd_max_mm: 200\n", ":2:", "must exceed"},
      {"margins:\n  grashof_mm: -1\n", ":2:", "at least 0"},
      {"load:\n  max_force_n: 0\n", ":2:", "must be positive"},
      {"min_transmission_deg: 95\n", ":1:", "between 0 and 90"},
      {"max_angle_deg: 200\n", ":1:", "not beyond 180"},
      {"load:\n  assist: 1.2\n", ":2:", "between 0 and 1"},
      {"load:\n  profile: none.json\n", ":2:", "none.json"},
      {"load:\n  duration_s: soon\n", ":2:", "free or a number"},
      {"load:\n  duration_s: 0\n", ":2:", "above 0"},
      {"load:\n  rest: bed\n", ":2:", "anywhere, standing"},
      {"d_min_mm: 240\nactuator: L17\n", ":2:", "no actuator 'L17'"},
      {"d_min_mm: many\n", ":1:", "a finite number, not 'many'"},
      {"- 1\n- 2\n", ":1:", "a map"},
      {"d_min_mm: [\n", ".yaml", "not YAML"},
  };
  for (const auto& item : cases) {
    const std::string error = ErrorOf(item.text);
    EXPECT_THAT(error, ::testing::AllOf(::testing::HasSubstr(item.line), ::testing::HasSubstr(item.reason)))
        << item.text;
    EXPECT_THAT(error, ::testing::Not(::testing::HasSubstr("\n")));
  }
}

TEST(LoadProfile, PercentsAscend) {
  const auto refused = [](const std::vector<double>& percent) {
    EXPECT_THAT(
        [&] {
          problem::MakeLoadProfile(percent, {90, 50, 30, 5}, {40, 30, 20, 0}, 2);
        },
        ::testing::ThrowsMessage<Error>(::testing::HasSubstr("must ascend from 0 to 100")));
  };
  refused({0, 50, 50, 100});
  refused({0, 60, 40, 100});
  refused({0, NAN, 60, 100});
  refused({0, 30, 60, 90});
}

TEST_F(ProblemFile, WearableAsksForClearancesAndStrength) {
  const problem::SynthesisProblem read = problem::ReadProblem(SourceDir() / "calibration/problems/wearable.yaml");
  EXPECT_EQ(read.clearances.seat_mm, 5);
  EXPECT_FALSE(read.clearances.thigh_mm);
  EXPECT_EQ(read.clearances.body.leg->thigh_mm, 410);
  EXPECT_EQ(read.limits["safety_factor"], 1.5);
  EXPECT_EQ(read.limits["max_pin_force_n"], 4000);
  EXPECT_EQ(read.parts.material, "6061-T6");
}

TEST_F(ProblemFile, SaysWhereTheLinkageIsMounted) {
  const auto read = [&](const std::string& text) { return problem::ReadProblem(Write(text)); };
  EXPECT_EQ(read("d_min_mm: 242\n").mount, linkage::Mount::kBeside);
  const problem::SynthesisProblem behind = read("mount: behind\nclearances: {limb_mm: 5}\n");
  EXPECT_EQ(behind.mount, linkage::Mount::kBehind);
  EXPECT_NE(problem::ProblemJson(behind), problem::ProblemJson(read("clearances: {limb_mm: 5}\n")));
  EXPECT_THAT(ErrorOf("d_min_mm: 242\nmount: under\n"),
              ::testing::HasSubstr(":2: 'mount' must be one of beside, behind"));
}

TEST_F(ProblemFile, RefusesBodiesPartsAndTolerancesWithTheirLine) {
  EXPECT_THAT(ErrorOf("d_min_mm: 242\nclearances: {seat_mm: -5}\n"),
              ::testing::HasSubstr(":2: 'seat_mm' must be at least 0, not -5"));
  EXPECT_THAT(ErrorOf("clearances: {leg_mm: 5}\n"), ::testing::HasSubstr("unknown key 'leg_mm'"));
  EXPECT_THAT(ErrorOf("body: {thigh_mm: 410}\n"), ::testing::HasSubstr("give both or neither"));
  EXPECT_THAT(ErrorOf("parts: {plate: \"4mm,butter\"}\n"), ::testing::HasSubstr("butter"));
  EXPECT_THAT(ErrorOf("robust_mm: 6\n"), ::testing::HasSubstr("robust_mm"));
}

}  // namespace
}  // namespace lake
