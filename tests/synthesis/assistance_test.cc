// Designs with loads: a profile instead of a constant torque, actuators, durations.
#include "lake/problem/assistance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "central_differences.h"
#include "differential_evolution.h"
#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/problem/evaluate.h"
#include "lake/synthesis/actuator_front.h"
#include "lake/synthesis/optimize.h"
#include "lake/synthesis/synthesis_outcome.h"
#include "load_profile.h"
#include "paper.h"

namespace lake {
namespace {

// calibration/problems/buildable.yaml
problem::LinearActuator Known(const std::string& name) {
  return problem::FindActuator(name);
}

problem::SynthesisProblem WithLoad(double assist, const std::string& actuator) {
  problem::SynthesisProblem problem = Buildable();
  problem.profile = MadeUpProfile();
  problem.assist = assist;
  problem.actuator = Known(actuator);
  return problem::WithActuator(problem);
}

TEST(LoadedDesign, AssistOfZeroLeavesTheProblemAsItIs) {
  problem::SynthesisProblem plain = Buildable(), loaded = plain;
  loaded.profile = MadeUpProfile();
  loaded.assist = 0;
  const auto before = problem::RequirementsOf(plain), after = problem::RequirementsOf(loaded);
  ASSERT_EQ(before.size(), after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_EQ(before[i].Text(), after[i].Text());
    EXPECT_EQ(before[i].along_profile, after[i].along_profile);
  }
  const synthesis::LocalSolve first = synthesis::SolveFrom(plain, plain.start),
                              second = synthesis::SolveFrom(loaded, loaded.start);
  ASSERT_TRUE(first.IsUsable());
  EXPECT_EQ(first.solution.x, second.solution.x);
}

TEST(LoadedDesign, ConstantProfileHasTheForceOfTheConstantTorque) {
  std::mt19937_64 random(5);
  problem::SynthesisProblem plain = Buildable();
  plain.knee_torque_nm = 37;
  int compared = 0;
  for (int i = 0; i < 20; ++i) {
    const linkage::Links links = RandomFeasible(plain, random);
    const problem::DesignEvaluation evaluation = problem::Evaluate(links, plain);
    if (!evaluation.stands_mm) continue;
    problem::SynthesisProblem loaded = plain;
    // Three quarters of a moment are the torque; the samples are those of the constant form's grid.
    loaded.profile = ConstantProfile(evaluation.range_deg, 5, 37 / 0.75, 721);
    loaded.assist = 0.75;
    const double constant = evaluation.CheckOf("force").value,
                 profile = problem::Evaluate(links, loaded).CheckOf("force").value;
    // Between two samples a smooth force is higher by its curvature, a pole by more.
    if (constant < 5000) {
      EXPECT_NEAR(profile, constant, 1e-3 * constant);
      ++compared;
    }
  }
  EXPECT_GE(compared, 10);
}

// Where the force is limited at standing, what lies beyond the profile's largest angle does not matter.
TEST(LoadedDesign, ConstantProfileHasTheOptimumOfTheConstantTorque) {
  problem::SynthesisProblem plain = WithMargins(10);
  plain.standing_deg = 5;
  plain.limits["max_force_n"] = 1200;
  const synthesis::LocalSolve constant = synthesis::SolveFrom(plain, plain.start);
  ASSERT_TRUE(constant.IsUsable());
  const problem::RequirementCheck& force = constant.evaluation.CheckOf("force");
  ASSERT_NEAR(force.slack, 0, 1e-3) << "the limit is to be active …";
  ASSERT_NEAR(force.fraction, 0, 1e-6) << "… at standing";
  problem::SynthesisProblem loaded = plain;
  loaded.profile = ConstantProfile(constant.evaluation.range_deg, 5, plain.knee_torque_nm, 201);
  const synthesis::LocalSolve profile = synthesis::SolveFrom(loaded, loaded.start);
  ASSERT_TRUE(profile.IsUsable());
  EXPECT_NEAR(profile.evaluation.range_deg, constant.evaluation.range_deg, 1e-3);
}

TEST(LoadedDesign, RowsAgreeWithFiniteDifferencesAndEnergy) {
  problem::SynthesisProblem problem = WithLoad(0.4, "LA31-1000");
  problem.duration_s = 12;
  const linkage::Links links{60, 70, 55, 75, 90, 260};
  const problem::Assistance assistance = problem::FindAssistance(links, problem);
  ASSERT_EQ(assistance.rows.size(), 101u);
  double work_j = 0, knee_work_j = 0;
  for (std::size_t i = 1; i + 1 < assistance.rows.size(); ++i) {
    const auto &before = assistance.rows[i - 1], &row = assistance.rows[i], &after = assistance.rows[i + 1];
    EXPECT_NEAR(row.time_s, 0.12 * i, 1e-12);
    // Of central differences over 1 %.
    EXPECT_NEAR(row.speed_mm_s, (after.stroke_mm - before.stroke_mm) / 0.24, 0.01) << i;
    if (std::isnan(row.knee_nm)) {
      EXPECT_TRUE(std::isnan(row.force_n));
      continue;
    }
    work_j += row.power_w * 0.12;
    knee_work_j += -0.4 * row.knee_nm * RadiansFromDegrees(after.knee_deg - before.knee_deg) / 2;
  }
  EXPECT_NEAR(work_j, knee_work_j, 1e-9 * work_j);  // virtual work, sample by sample
}

TEST(LoadedDesign, ShortestDurationIsTheOneThatTheForceSpeedLawJustAllows) {
  const problem::SynthesisProblem problem = WithLoad(0.06, "L16-140-150");
  const linkage::Links links{60, 60, 55, 60, 50, 215};
  problem::SynthesisProblem timed = problem;
  timed.duration_s = problem::FindAssistance(links, problem).shortest_s;
  ASSERT_TRUE(std::isfinite(*timed.duration_s));
  const auto excess = [&](double factor) {
    problem::SynthesisProblem other = timed;
    *other.duration_s *= factor;
    double worst = -1e9;
    for (const problem::AssistanceRow& row : problem::FindAssistance(links, other).rows) {
      const double force_n = std::isnan(row.force_n) ? 0 : std::abs(row.force_n);
      // The law by hand: 8 mm/s without load, 4 mm/s at 175 N.
      worst = std::max(worst, std::abs(row.speed_mm_s) - (8 - 4 * force_n / 175));
    }
    return worst;
  };
  EXPECT_NEAR(excess(1), 0, 1e-9);
  EXPECT_GT(excess(0.99), 0.01);
  EXPECT_LT(excess(1.01), -0.01);
  EXPECT_NEAR(problem::Evaluate(links, timed).CheckOf("duration").slack, 0, 1e-9);
}

// Whose moment grows as the rise gets slower: momentum helps the person.
problem::LoadProfile PacedProfile() {
  problem::LoadProfile profile = MadeUpProfile();
  for (problem::LoadSample& sample : profile.samples) sample.slow_nm = 1.25 * sample.knee_nm + 2;
  return profile;
}

// Whatever pace the profile is given at, a design's forces are those of the rise that it makes.
TEST(LoadedDesign, MomentsAreThoseOfItsOwnPace) {
  problem::SynthesisProblem problem = WithLoad(0.4, "LA31-1000");
  problem.profile = PacedProfile();
  const linkage::Links links{60, 70, 55, 75, 90, 260};
  const problem::Assistance assistance = problem::FindAssistance(links, problem);
  const double rise_s = assistance.shortest_s;
  ASSERT_GT(rise_s, 3) << "much slower than the person's own, so that it matters";
  EXPECT_EQ(assistance.moments_s, rise_s);
  EXPECT_EQ(assistance.duration_s, rise_s);
  double longest_s = 0;
  for (std::size_t i = 0; i < assistance.rows.size(); ++i) {
    const problem::AssistanceRow& row = assistance.rows[i];
    const problem::LoadSample& sample = problem.profile->samples[i];
    if (!std::isnan(row.least_duration_s)) longest_s = std::max(longest_s, row.least_duration_s);
    if (std::isnan(sample.knee_nm) || std::isnan(row.stroke_mm)) continue;
    const double knee_nm = sample.slow_nm + std::pow(1.6 / rise_s, 2) * (sample.knee_nm - sample.slow_nm);
    EXPECT_NEAR(row.knee_nm, knee_nm, 1e-9);
    EXPECT_NEAR(std::abs(row.force_n), 0.4 * 1000 * std::abs(knee_nm) / row.moment_arm_mm, 1e-6);
  }
  EXPECT_NEAR(longest_s, rise_s, 1e-9) << "it is as fast under these moments as it is said to be";
  problem::SynthesisProblem other = problem;
  other.profile = problem::AtPace(*problem.profile, 30);
  EXPECT_NEAR(problem::FindAssistance(links, other).shortest_s, rise_s, 1e-6);
  // In a time that is asked for the moments are those of that time.
  other.duration_s = 20;
  const problem::Assistance asked = problem::FindAssistance(links, other);
  EXPECT_EQ(asked.moments_s, 20);
  EXPECT_NEAR(asked.shortest_s, rise_s, 1e-6);
  EXPECT_GT(asked.Largest(&problem::AssistanceRow::force_n)->force_n,
            assistance.Largest(&problem::AssistanceRow::force_n)->force_n);
}

// Where the force is the limit at a quick pace, and nothing else.
TEST(LoadedDesign, ASlowRiseTakesLessForceWhereInertiaHurts) {
  problem::SynthesisProblem problem = WithLoad(1, "LA31-1000");
  problem.profile = MadeUpProfile();
  const linkage::Links links{60, 70, 55, 75, 90, 260};
  ASSERT_TRUE(std::isinf(problem::FindAssistance(links, problem).shortest_s)) << "more than it lifts at any pace";
  for (problem::LoadSample& sample : problem.profile->samples) sample.slow_nm = 0.2 * sample.knee_nm;
  problem.actuator->force_speed = {{1000, *problem.actuator->no_load_speed_mm_s * 10}};
  problem.actuator->no_load_speed_mm_s.reset();
  const problem::Assistance assistance = problem::FindAssistance(links, problem);
  ASSERT_TRUE(std::isfinite(assistance.shortest_s));
  EXPECT_TRUE(assistance.force_is_limit);
  EXPECT_NEAR(std::abs(assistance.Largest(&problem::AssistanceRow::force_n)->force_n), 1000, 0.02);
}

// One question has one answer: of the optimum, of the design that is simulated, of the curve over the share.
TEST(ActuatorOptimum, IsSoughtUnderTheMomentsOfItsOwnPace) {
  problem::SynthesisProblem measured = Buildable();
  measured.profile = PacedProfile();
  measured.assist = 0.4;
  problem::SynthesisProblem problem = measured;
  problem.actuator = Known("LA31-1000");
  problem.goal = problem::SynthesisProblem::Goal::kDuration;
  synthesis::SynthesisOptions options;
  options.optimize.starts = 4;
  const synthesis::SynthesisOutcome outcome = synthesis::RunSynthesis(problem::WithActuator(problem), options);
  ASSERT_TRUE(outcome.IsSolved());
  const problem::Assistance optimum = problem::FindAssistance(outcome.BestLinks(), outcome.problem),
                            simulated = problem::FindAssistance(outcome.BestLinks(), problem::WithActuator(problem));
  EXPECT_NEAR(outcome.problem.profile->moments_s / optimum.shortest_s, 1, 1e-3);
  EXPECT_NEAR(-outcome.result.Best().objective / optimum.shortest_s, 1, 1e-3);
  EXPECT_NEAR(simulated.shortest_s, optimum.shortest_s, 1e-6);
  const auto force = [](const problem::Assistance& assistance) {
    return std::abs(assistance.Largest(&problem::AssistanceRow::force_n)->force_n);
  };
  EXPECT_NEAR(force(simulated), force(optimum), 1e-3);
  const auto curves = synthesis::FindActuatorFront(measured, {Known("LA31-1000")}, {0.4}, options.optimize);
  ASSERT_TRUE(curves.front().points.front().solved);
  const problem::Assistance& front = curves.front().points.front().assistance;
  EXPECT_NEAR(front.shortest_s / optimum.shortest_s, 1, 1e-3);
  EXPECT_NEAR(force(front) / force(optimum), 1, 2e-3);
}

TEST(LoadedDesign, WhatIsNotThereIsSaid) {
  problem::SynthesisProblem problem = Buildable();
  problem.assist = 0.4;
  EXPECT_THROW(problem.CheckLoad(), UsageError);
  problem.profile = MadeUpProfile();
  EXPECT_NO_THROW(problem.CheckLoad());
  problem.duration_s = 5;
  EXPECT_THROW(problem.CheckLoad(), UsageError);
  problem.actuator = Known("LA23-2500");  // whose speed nobody says
  EXPECT_THROW(problem.CheckLoad(), UsageError);
  problem.actuator = Known("LA31-1000");
  EXPECT_NO_THROW(problem.CheckLoad());
  problem.assist = 0;
  EXPECT_THROW(problem.CheckLoad(), UsageError);
  problem.assist = 1.5;
  EXPECT_THROW(problem.Check(), Error);
  problem.assist = 1;
  problem.standing_deg = 89;
  problem.profile = MadeUpProfile(80);
  EXPECT_THROW(problem.Check(), Error);
}

TEST(LoadedDesign, ActuatorSetsLengthsAndForces) {
  const problem::SynthesisProblem problem = WithLoad(0.1, "L16-140-150");
  EXPECT_EQ(problem.d_min_mm, 208);
  EXPECT_EQ(problem.limits["d_max_mm"], 348);
  EXPECT_EQ(problem.limits["max_force_n"], 175);  // of 200, its speed is known up to 175
  problem::SynthesisProblem resting = problem;
  const linkage::Links links{60, 60, 55, 60, 50, 215};
  const double anywhere = problem::Evaluate(links, resting).CheckOf("holding force").value;
  resting.rests_anywhere = false;
  const problem::RequirementCheck standing = problem::Evaluate(links, resting).CheckOf("holding force");
  EXPECT_GT(anywhere, standing.value);
  EXPECT_EQ(standing.fraction, 1);
  const problem::Assistance assistance = problem::FindAssistance(links, problem);
  EXPECT_NEAR(anywhere, std::abs(assistance.Largest(&problem::AssistanceRow::force_n)->force_n), 1e-9);
  EXPECT_NEAR(standing.value, std::abs(assistance.rows.back().force_n), 1e-9);
  const problem::SynthesisProblem unknown = WithLoad(0.1, "LA31-3500");
  EXPECT_EQ(unknown.d_min_mm, 242);
  EXPECT_FALSE(unknown.limits["d_max_mm"]);
}

TEST(LoadedDesign, ProgramHasExactDerivatives) {
  problem::SynthesisProblem problem = WithLoad(0.3, "L16-140-150");
  problem.goal = problem::SynthesisProblem::Goal::kDuration;
  synthesis::Collocation poses{0.3, 0.7};
  poses.samples = {0, 30, 45, 80, 100};
  for (const auto elasticity : {synthesis::Elasticity::kNone, synthesis::Elasticity::kEverything}) {
    const synthesis::SynthesisProgram program =
        synthesis::BuildProgram(problem, {60, 60, 55, 60, 50, 215}, poses, elasticity);
    EXPECT_EQ(WrongDerivatives(program.program), "");
  }
}

// What of a design counts: the shortest duration, or how far it is from being one.
double DurationGoal(const problem::SynthesisProblem& problem, const std::vector<double>& x) {
  const linkage::Links links = linkage::Links::FromValues({x[0], x[1], x[2], x[3], x[4], x[5]});
  if (!linkage::SolvePose(links, problem.d_min_mm)) return -1e6;
  constexpr double kHeld = 1e-6;
  const problem::DesignEvaluation evaluation = problem::Evaluate(links, problem);
  double violation = 0;
  for (const problem::RequirementCheck& check : evaluation.checks)
    violation +=
        std::isfinite(check.slack) ? std::max(0.0, -check.slack / std::max(1.0, check.requirement.limit) - kHeld) : 100;
  return violation > 0 ? -1e4 * (1 + violation) : problem::GoalOf(problem, evaluation);
}

TEST(ActuatorOptimum, DifferentialEvolutionFindsNothingFaster) {
  const struct {
    const char* name;
    double assist;
  } rows[] = {{"LA31-1000", 0.8}, {"L16-140-150", 0.06}};
  for (const auto& [name, assist] : rows) {
    problem::SynthesisProblem problem = WithLoad(assist, name);
    problem.goal = problem::SynthesisProblem::Goal::kDuration;
    const synthesis::SynthesisResult result = synthesis::Optimize(problem, Starts(6));
    ASSERT_GE(result.best, 0) << name;
    const double optimum_s = -problem::GoalOf(problem, result.Best().evaluation);
    const Evolved evolved = Evolve(
        {problem.bounds.begin(), problem.bounds.end()},
        [&](const std::vector<double>& x) { return DurationGoal(problem, x); }, 40, 120, 1);
    RecordProperty(name, fmt::format("{:.5f} s, evolution {:.5f} s", optimum_s, -evolved.value));
    EXPECT_GE(-evolved.value, optimum_s * (1 - 1e-5)) << name;
    EXPECT_LE(-evolved.value, optimum_s * 1.01) << name << ": the evolution itself got nowhere";
    // No linkage is faster than the power that it has.
    EXPECT_GE(optimum_s, problem::FindAssistance(result.Best().end, problem).bound_s);
  }
}

TEST(ActuatorFront, CurvesEndWhereALimitFails) {
  problem::SynthesisProblem problem = Buildable();
  problem.profile = MadeUpProfile();
  const auto curves = synthesis::FindActuatorFront(
      problem, {Known("L16-50-35"), Known("L16-140-150"), Known("LA23-2500")}, {0.05, 0.5}, Starts(2));
  ASSERT_EQ(curves.size(), 3u);
  EXPECT_EQ(curves[0].Last(), nullptr);
  EXPECT_THAT(curves[0].limits, ::testing::Contains(::testing::HasSubstr("stroke when standing ≤ 168 mm")));
  ASSERT_NE(curves[1].Last(), nullptr);
  EXPECT_EQ(curves[1].Last()->assist, 0.05);
  EXPECT_TRUE(curves[1].points[0].is_on_front);
  EXPECT_THAT(curves[1].failing, ::testing::HasSubstr("force"));
  EXPECT_TRUE(curves[2].points[1].solved);
  EXPECT_TRUE(std::isnan(curves[2].points[1].assistance.shortest_s));
  EXPECT_FALSE(curves[2].points[1].is_on_front);
}

}  // namespace
}  // namespace lake
