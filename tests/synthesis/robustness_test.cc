#include "lake/problem/robustness.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/threads.h"
#include "lake/synthesis/infeasibility.h"
#include "lake/synthesis/optimize.h"
#include "load_profile.h"
#include "paper.h"

namespace lake {
namespace {

TEST(Yield, HalfOfThePublishedDesignsBuildsCannotBeAssembled) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    problem::YieldOptions options;
    options.seed = seed;
    const problem::Yield yield = problem::EstimateYield(kPublishedLinks, problem::SynthesisProblem{}, options);
    EXPECT_NEAR(yield.assembled.value, 0.510, 0.02);
    EXPECT_NEAR(yield.all.value, 0.457, 0.025) << "what can be assembled, and keeps Grashof's law";
    EXPECT_LT(yield.assembled.lower, yield.assembled.value);
    EXPECT_NEAR(yield.assembled.upper - yield.assembled.lower, 2 * 1.96 * std::sqrt(0.25 / options.samples), 2e-4);
  }
}

TEST(Yield, MarginsMakeARobustDesign) {
  const problem::SynthesisProblem problem = WithMargins(0.5);
  const synthesis::LocalSolve solve = synthesis::SolveFrom(problem, problem.start);
  const problem::Yield yield = problem::EstimateYield(solve.end, problem);
  // Margins beyond what the tolerance can use up leave no doubt about what they are margins of …
  EXPECT_LT(yield.safe_singularity_margin_mm, 0.5);
  EXPECT_LT(yield.safe_grashof_margin_mm, 0.5);
  EXPECT_EQ(yield.assembled.value, 1);
  problem::SynthesisProblem plain;
  EXPECT_EQ(problem::EstimateYield(solve.end, plain).Find("grashof")->kept.value, 1);
  // … but the design stands on them.
  EXPECT_NEAR(yield.Find("grashof")->kept.value, 0.5, 0.03);
  EXPECT_NEAR(yield.Find("singularity")->kept.value, 0.5, 0.03);
}

// calibration/problems/buildable.yaml, whose optimum stands on force, Grashof, singularity and l2 ≤ l4, against builds
// of our own: the closed form over 51 strokes of each.
TEST(Yield, IsOfEveryLimitOfTheProblem) {
  const problem::SynthesisProblem problem = Buildable();
  const linkage::Links links = synthesis::SolveFrom(problem, problem.start).end;
  for (const double tolerance_mm : {0.2, 0.1}) {
    problem::YieldOptions options;
    options.tolerance_mm = tolerance_mm;
    const problem::Yield yield = problem::EstimateYield(links, problem, options);
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> off(-tolerance_mm, tolerance_mm);
    constexpr int kBuilds = 20000, kStrokes = 50;
    std::array<int, 5> kept{};  // force, singularity, Grashof, the three, with l2 <= l4 too
    std::vector<double> forces;
    for (int n = 0; n < kBuilds; ++n) {
      auto l = links.Values();
      for (double& length : l) length += off(random);
      const linkage::Links build = linkage::Links::FromValues(l);
      const double d_min_mm = problem.d_min_mm + off(random);
      double force_n = HUGE_VAL;
      if (linkage::SolvePose(build, d_min_mm)) {
        const linkage::UsedRange range =
            linkage::FindUsedRange(build, d_min_mm, {}, RadiansFromDegrees(problem.standing_deg));
        force_n = 0;
        for (int i = 0; i <= kStrokes; ++i) {
          const double stroke_mm = range.stroke.lower_mm + range.stroke.Travel() * i / kStrokes;
          force_n = std::max(
              force_n,
              40e3 * std::abs(linkage::TransmissionOf(build, linkage::RequirePose(build, stroke_mm)).radians_per_mm));
        }
      }
      forces.push_back(force_n);
      const bool force = force_n <= 2000, singularity = std::hypot(l[4], l[5]) <= l[1] + d_min_mm - 2,
                 grashof = l[2] + l[3] <= l[0] + l[1] - 2, three = force && singularity && grashof;
      const std::array<bool, 5> holds{force, singularity, grashof, three, three && l[1] <= l[3]};
      for (std::size_t i = 0; i < holds.size(); ++i) kept[i] += holds[i];
    }
    const auto share = [&](std::size_t i) { return kept[i] / double{kBuilds}; };
    constexpr double kScatter = 0.022;  // three standard errors
    EXPECT_NEAR(yield.Find("force")->kept.value, share(0), kScatter);
    EXPECT_NEAR(yield.Find("singularity")->kept.value, share(1), kScatter);
    EXPECT_NEAR(yield.Find("grashof")->kept.value, share(2), kScatter);
    EXPECT_NEAR(yield.all.value, share(4), 0.01);
    EXPECT_NEAR(share(3), 0.29, kScatter);
    EXPECT_NEAR(yield.all.value, 0.05, 0.01);
    std::ranges::sort(forces);
    EXPECT_NEAR(yield.Find("force")->kept_by_95, forces[kBuilds * 95 / 100], 8);
    if (tolerance_mm == 0.2) {
      EXPECT_NEAR(yield.Find("force")->kept_by_95, 2077, 12);
    }
    EXPECT_LT(yield.Find("grashof")->kept_by_95, 2);
    for (const problem::LimitYield& limit : yield.limits) EXPECT_GE(limit.kept.value, yield.all.value);
    // The play of pins of 0.1 mm changes little.
    options.pin_clearance_mm = 0.1;
    EXPECT_NEAR(problem::EstimateYield(links, problem, options).all.value, yield.all.value, 0.02);
  }
}

TEST(Yield, DoesNotDependOnTheThreads) {
  const int threads = Threads();
  const auto in_threads = [&](int count) {
    SetThreads(count);
    problem::YieldOptions options;
    options.samples = 200;
    return problem::EstimateYield(kPublishedLinks, WithMargins(0), options);
  };
  const problem::Yield one = in_threads(1), three = in_threads(3);
  SetThreads(threads);
  ASSERT_EQ(one.limits.size(), problem::RequirementsOf(WithMargins(0)).size());
  for (std::size_t i = 0; i < one.limits.size(); ++i) {
    EXPECT_EQ(one.limits[i].kept.value, three.limits[i].kept.value);
    EXPECT_EQ(one.limits[i].kept_by_95, three.limits[i].kept_by_95) << one.limits[i].requirement.name;
  }
}

TEST(Yield, SafeMarginsAreJustEnough) {
  problem::YieldOptions options;
  options.tolerance_mm = 0.2;
  const problem::Yield probe = problem::EstimateYield(kPublishedLinks, problem::SynthesisProblem{}, options);
  problem::SynthesisProblem problem;
  problem.grashof_margin_mm = probe.safe_grashof_margin_mm;
  problem.singularity_margin_mm = 0.5 * probe.safe_singularity_margin_mm;
  const synthesis::LocalSolve half = synthesis::SolveFrom(problem, problem.start);
  EXPECT_LT(problem::EstimateYield(half.end, problem, options).assembled.value, 1);
  problem.singularity_margin_mm = 1.01 * probe.safe_singularity_margin_mm;  // l5, l6 differ a little from the probe's
  const synthesis::LocalSolve full = synthesis::SolveFrom(problem, problem.start);
  const problem::Yield yield = problem::EstimateYield(full.end, problem::SynthesisProblem{}, options);
  EXPECT_EQ(yield.assembled.value, 1);
  EXPECT_EQ(yield.Find("grashof")->kept.value, 1);
}

// A margin of 0.33 mm holds links that are off by 0.1 mm each (0.1 (1 + (l5 + l6) / l7) = 0.216 mm), with an actuator
// that is too (0.316), but not the play of bar and actuator on top of that (4 x 0.05).
TEST(Yield, CountsTheActuatorsLengthAndThePlayOfThePins) {
  const problem::SynthesisProblem problem = WithMargins(0.33);
  const synthesis::LocalSolve solve = synthesis::SolveFrom(problem, problem.start);
  problem::YieldOptions options;
  const problem::Yield exact_pins = problem::EstimateYield(solve.end, problem, options);
  EXPECT_NEAR(exact_pins.safe_singularity_margin_mm, 0.316, 0.002);
  EXPECT_EQ(exact_pins.assembled.value, 1);
  options.pin_clearance_mm = 0.1;
  const problem::Yield with_play = problem::EstimateYield(solve.end, problem, options);
  EXPECT_NEAR(with_play.safe_singularity_margin_mm, exact_pins.safe_singularity_margin_mm + 0.2, 1e-12);
  options.pin_clearance_mm = 0.4;
  EXPECT_LT(problem::EstimateYield(solve.end, problem, options).assembled.value, 1);
  // An actuator too short by the margin leaves about half of the builds.
  problem::SynthesisProblem shorter = problem;
  shorter.d_min_mm -= 0.33;
  EXPECT_NEAR(problem::EstimateYield(solve.end, shorter).assembled.value, 0.5, 0.05);
  EXPECT_THAT(problem::kYieldScope, ::testing::HasSubstr("actuator's shortest length"));
}

TEST(Yield, RefusesSenselessTolerances) {
  problem::YieldOptions options;
  options.tolerance_mm = NAN;
  EXPECT_THROW(problem::EstimateYield(kPublishedLinks, problem::SynthesisProblem{}, options), Error);
}

TEST(Sensitivity, IsTwoSidedAndMarksWhatCannotBeAssembled) {
  const auto points = problem::Sensitivity(kPublishedLinks, problem::SynthesisProblem{}, 2, 50);
  ASSERT_EQ(points.size(), 7u * 101u);
  int unassembled = 0;
  for (const problem::SensitivityPoint& point : points) {
    auto values = kPublishedLinks.Values();
    double d_min_mm = 242;
    (point.link < 6 ? values[point.link] : d_min_mm) += point.delta_mm;
    const auto pose = linkage::SolvePose(linkage::Links::FromValues(values), d_min_mm);
    EXPECT_EQ(pose.has_value(), !std::isnan(point.range_deg));
    unassembled += !pose;
    EXPECT_FALSE(std::isnan(point.range_deg) && point.feasible);
    if (point.delta_mm == 0) {
      EXPECT_NEAR(point.range_deg, 148.5715, 5e-5);
    }
  }
  EXPECT_GT(unassembled, 100);  // l2 shorter, l5 or l6 longer: the actuator triangle does not close
  // The published point is no local optimum: l4 - 1 mm is feasible and better.
  const auto& shorter = points[3 * 101 + 25];
  EXPECT_EQ(shorter.delta_mm, -1);
  EXPECT_TRUE(shorter.feasible);
  EXPECT_NEAR(shorter.range_deg, 149.51, 5e-3);
}

// At an optimum no single length can be changed for a larger range: what seems to do so breaks a limit, be it one over
// the used range.
TEST(Sensitivity, CallsNothingFeasibleThatBreaksALimitOverTheUsedRange) {
  problem::SynthesisProblem problem = WithMargins(2);
  problem.limits["max_force_n"] = 2000;
  problem.clearances.seat_mm = 5;
  const synthesis::LocalSolve solve = synthesis::SolveFrom(problem, problem.start);
  const double optimum_deg = problem::Evaluate(solve.end, problem).range_deg;
  const int steps = 5;
  int feasible = 0, tempting = 0;
  for (const problem::SensitivityPoint& point : problem::Sensitivity(solve.end, problem, 5, steps)) {
    feasible += point.feasible;
    tempting += point.range_deg > optimum_deg + 0.1;
    if (point.link < 6 && point.feasible) {
      EXPECT_LE(point.range_deg, optimum_deg + 1e-6) << problem::LengthName(point.link) << " " << point.delta_mm;
    }
  }
  EXPECT_GT(feasible, 7);  // more than the optimum itself, once for each length
  EXPECT_GT(tempting, 2 * steps);
}

// The quick look gives the same answers as the whole evaluation, of every build, whatever the number of threads.
TEST(Sensitivity, OfATolerancesBuildsIsThatOfTheWorst) {
  problem::SynthesisProblem problem = WithMargins(0);
  problem.limits["max_force_n"] = 2000;
  problem.standing_deg = 5;
  problem.robust_mm = 0.2;
  const linkage::Links links = synthesis::SolveFrom(problem, problem.start).end;
  const int threads = Threads(), steps = 1;
  int called = 0;
  const auto in_threads = [&](int count) {
    SetThreads(count);
    return problem::Sensitivity(links, problem, 1, steps, [&] { ++called; });
  };
  const auto one = in_threads(1), three = in_threads(3);
  SetThreads(threads);
  ASSERT_EQ(one.size(), static_cast<std::size_t>(problem::PointsOfSensitivity(steps)));
  ASSERT_EQ(three.size(), one.size());
  EXPECT_EQ(called, 2 * problem::PointsOfSensitivity(steps));
  int feasible = 0;
  for (std::size_t i = 0; i < one.size(); ++i) {
    const problem::SensitivityPoint& point = one[i];
    auto values = links.Values();
    problem::SynthesisProblem changed = problem;
    (point.link < 6 ? values[static_cast<std::size_t>(point.link)] : changed.d_min_mm) += point.delta_mm;
    EXPECT_EQ(point.feasible, problem::Evaluate(linkage::Links::FromValues(values), changed).IsFeasible())
        << problem::LengthName(point.link) << " " << point.delta_mm;
    EXPECT_EQ(point.feasible, three[i].feasible);
    EXPECT_EQ(point.delta_mm, three[i].delta_mm);
    EXPECT_EQ(point.link, three[i].link);
    feasible += point.feasible;
  }
  EXPECT_GT(feasible, 7);  // more than the optimum itself, once for each length
  EXPECT_LT(feasible, problem::PointsOfSensitivity(steps) - 7);
}

TEST(RoundLinks, GivesTheBestFeasibleGridPoint) {
  const problem::SynthesisProblem problem = WithMargins(2);
  const synthesis::LocalSolve solve = synthesis::SolveFrom(problem, problem.start);
  for (const double step : {0.1, 0.5, 1.0}) {
    const auto rounded = problem::RoundLinks(solve.end, problem, step);
    ASSERT_TRUE(rounded);
    for (const double value : rounded->links.Values()) EXPECT_NEAR(value / step, std::round(value / step), 1e-9);
    EXPECT_TRUE(rounded->evaluation.IsFeasible());
    EXPECT_LE(rounded->evaluation.range_deg, solve.evaluation.range_deg + 1e-6);
    EXPECT_GT(rounded->evaluation.range_deg, solve.evaluation.range_deg - 4 * step);
  }
}

TEST(RoundLinks, ReEvaluatesTheUsedRange) {
  problem::SynthesisProblem problem = WithMargins(1);
  problem.limits["max_force_n"] = 2000;
  const synthesis::LocalSolve solve = synthesis::SolveFrom(problem, problem.start);
  const auto rounded = problem::RoundLinks(solve.end, problem, 0.5);
  ASSERT_TRUE(rounded);
  for (const problem::RequirementCheck& check : rounded->evaluation.checks)
    if (check.requirement.name == "force") {
      EXPECT_LE(check.value, 2000);
      EXPECT_GT(check.value, 1000);
    }
}

// No neighbour of the rounded design on the grid is better in what is sought, be it the duration or the range of the
// worst build.
TEST(RoundLinks, RoundsForTheGoal) {
  problem::SynthesisProblem duration = Buildable();
  duration.profile = MadeUpProfile();
  duration.assist = 0.4;
  duration.actuator = problem::FindActuator("LA31-1000");
  duration.goal = problem::SynthesisProblem::Goal::kDuration;
  problem::SynthesisProblem robust = WithMargins(0);
  robust.robust_mm = 0.2;
  for (const problem::SynthesisProblem& problem : {problem::WithActuator(duration), robust}) {
    const synthesis::LocalSolve solve = synthesis::SolveFrom(problem, problem.start);
    ASSERT_TRUE(solve.IsUsable());
    const auto rounded = problem::RoundLinks(solve.end, problem, 1);
    ASSERT_TRUE(rounded);
    const double goal = problem::GoalOf(problem, rounded->evaluation);
    EXPECT_GT(goal, solve.objective - 0.1 * std::abs(solve.objective));
    EXPECT_LE(goal, solve.objective + 1e-5);
    const std::vector<problem::Requirement> requirements = problem::RequirementsOf(problem);
    int compared = 0;
    for (int n = 0; n < 729; ++n) {
      auto values = solve.end.Values();
      for (int i = 0, rest = n; i < 6; ++i, rest /= 3) values[i] = std::round(values[i]) + rest % 3 - 1;
      const linkage::Links links = linkage::Links::FromValues(values);
      if (!problem::MeetsLinkRequirements(links, problem, requirements, 1e-9)) continue;
      const problem::DesignEvaluation evaluation = problem::Evaluate(links, problem);
      if (!evaluation.IsFeasible()) continue;
      ++compared;
      EXPECT_LE(problem::GoalOf(problem, evaluation), goal + 1e-9) << fmt::format("{}", fmt::join(values, ", "));
    }
    EXPECT_GT(compared, 5);
  }
}

TEST(RoundLinks, RefusesStepsThatMissTheBounds) {
  EXPECT_THROW(problem::RoundLinks(kPublishedLinks, problem::SynthesisProblem{}, 110), Error);
  EXPECT_THROW(problem::RoundLinks(kPublishedLinks, problem::SynthesisProblem{}, 0), Error);
}

TEST(Infeasibility, NamesTheFightersAndTheSmallestRelaxation) {
  problem::SynthesisProblem problem;
  problem.bounds[0] = {90, 100};
  problem.bounds[3] = {50, 60};
  const synthesis::InfeasibilityReport report = synthesis::AnalyseInfeasibility(problem);
  ASSERT_TRUE(report.solved) << report.sentence;
  // l1 >= 90 and l4 <= 60 against l1 <= l4: nothing less than 30 mm will do.
  ASSERT_EQ(report.relaxations.size(), 1u) << report.sentence;
  EXPECT_EQ(report.relaxations[0].text, "l1 ≤ l4");
  EXPECT_NEAR(report.relaxations[0].relaxed, -30, 1e-4);
  EXPECT_THAT(report.fighting, ::testing::IsSupersetOf({"l1 ≤ l4", "l1 ≥ 90 mm", "l4 ≤ 60 mm"}));
  EXPECT_THAT(report.sentence, ::testing::HasSubstr("cannot hold together"));
  EXPECT_THAT(report.sentence, ::testing::HasSubstr(": allow l1 ≤ l4 + 30"));
}

TEST(Infeasibility, ForceAndMomentArmAgreeOnTheLimit) {
  problem::SynthesisProblem arm, force;
  arm.limits["min_moment_arm_mm"] = 60;
  force.limits["max_force_n"] = 700;
  const synthesis::InfeasibilityReport of_arm = synthesis::AnalyseInfeasibility(arm),
                                       of_force = synthesis::AnalyseInfeasibility(force);
  ASSERT_EQ(of_arm.relaxations.size(), 1u) << of_arm.sentence;
  ASSERT_EQ(of_force.relaxations.size(), 1u) << of_force.sentence;
  // 40 N m over the largest least moment arm is the smallest largest force.
  EXPECT_NEAR(of_force.relaxations[0].relaxed, 40000 / of_arm.relaxations[0].relaxed, 0.1);
  // The relaxed problem has a solution, a slightly harder one has none.
  arm.limits["min_moment_arm_mm"] = of_arm.relaxations[0].relaxed - 0.01;
  EXPECT_TRUE(synthesis::SolveFrom(arm, of_arm.links).IsUsable());
  arm.limits["min_moment_arm_mm"] = of_arm.relaxations[0].relaxed + 0.01;
  EXPECT_FALSE(synthesis::SolveFrom(arm, of_arm.links).IsUsable());
}

TEST(Infeasibility, MovesDMinWhenRequirementsAreNotEnough) {
  problem::SynthesisProblem problem;
  problem.bounds[5] = {400, 450};
  const synthesis::InfeasibilityReport report = synthesis::AnalyseInfeasibility(problem);
  ASSERT_EQ(report.relaxations.size(), 1u) << report.sentence;
  // The mount is at least hypot(50, 400) away, the bar at most 100 mm long.
  EXPECT_NEAR(report.relaxations[0].relaxed, std::hypot(50, 400) - 100, 1e-3);
}

TEST(Infeasibility, FeasibleProblemNeedsNoRelaxation) {
  EXPECT_TRUE(synthesis::AnalyseInfeasibility(WithMargins(1)).relaxations.empty());
}

}  // namespace
}  // namespace lake
