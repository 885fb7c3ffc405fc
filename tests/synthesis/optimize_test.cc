#include "lake/synthesis/optimize.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "central_differences.h"
#include "lake/certificate/certificate.h"
#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/synthesis/multi_start.h"
#include "paper.h"

namespace lake {
namespace {

TEST(Optimize, PapersStartAloneReachesTheSupremum) {
  const synthesis::LocalSolve solve =
      synthesis::SolveFrom(problem::SynthesisProblem{}, problem::SynthesisProblem{}.start);
  ASSERT_TRUE(solve.IsUsable()) << solve.solution.message;
  EXPECT_GE(solve.evaluation.range_deg, 170.52);
  EXPECT_LE(solve.evaluation.range_deg, 170.537678);
  EXPECT_LE(solve.evaluation.violation, 1e-6);
  EXPECT_LE(solve.solution.violation, 1e-6);
  EXPECT_LE(solve.solution.kkt_error, 1e-6);
  EXPECT_LE(solve.iterations, 60);  // 14..51 known
  // The face of change-point parallelograms: l1 = l3, l2 = l4 = 62.138, l5 = 50, l6 = 300.
  EXPECT_NEAR(solve.end.l1, solve.end.l3, 1e-5);
  EXPECT_NEAR(solve.end.l2, 62.138, 5e-4);
  EXPECT_NEAR(solve.end.l4, 62.138, 5e-4);
  EXPECT_NEAR(solve.end.l5, 50, 1e-6);
  EXPECT_NEAR(solve.end.l6, 300, 1e-6);
}

// A start in a hundred or two gets stuck in a corner of the bounds, where links are equal, and says so; none may end in
// another optimum.
TEST(Optimize, StartsAgree) {
  for (const double margin : {0.0, 1.0, 10.0})
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
      synthesis::OptimizeOptions options = Starts(20);
      options.seed = seed;
      const synthesis::SynthesisResult result = synthesis::Optimize(WithMargins(margin), options);
      const auto stuck = std::ranges::count(result.basin, -1);
      EXPECT_LE(stuck, 2) << "margin " << margin << ", seed " << seed;
      EXPECT_EQ(std::ranges::count(result.basin, 0), options.starts - stuck);
      EXPECT_EQ(result.best, 0);  // of equals the first
      EXPECT_FALSE(result.Best().history.empty());
      for (std::size_t i = 1; i < result.starts.size(); ++i) EXPECT_TRUE(result.starts[i].history.empty());
    }
}

TEST(Optimize, SeedDecidesTheStarts) {
  const auto first = synthesis::RandomStarts(problem::SynthesisProblem{}, 3, 7),
             again = synthesis::RandomStarts(problem::SynthesisProblem{}, 3, 7),
             other = synthesis::RandomStarts(problem::SynthesisProblem{}, 3, 8);
  EXPECT_EQ(first[2].Values(), again[2].Values());
  EXPECT_NE(first[2].Values(), other[2].Values());
}

TEST(Optimize, PublishedPointIsFeasibleButNotOptimal) {
  const problem::DesignEvaluation published = problem::Evaluate(kPublishedLinks, problem::SynthesisProblem{});
  EXPECT_TRUE(published.IsFeasible(0));
  EXPECT_NEAR(published.range_deg, 148.5715, 5e-5);
  for (const problem::RequirementCheck& check : published.checks) {
    if (check.requirement.name == "grashof") {
      EXPECT_NEAR(check.slack, 0.108, 5e-4);
    }
    if (check.requirement.name == "singularity") {
      EXPECT_NEAR(check.slack, 0.00224, 5e-6);
    }
  }
  linkage::Links better = kPublishedLinks;
  better.l4 -= 1;
  const problem::DesignEvaluation shorter = problem::Evaluate(better, problem::SynthesisProblem{});
  EXPECT_TRUE(shorter.IsFeasible(0));
  EXPECT_NEAR(shorter.range_deg, 149.51, 5e-3);
}

TEST(Optimize, InitialPointOfThePaperViolatesThreeConstraintsByFive) {
  const problem::DesignEvaluation initial =
      problem::Evaluate(problem::SynthesisProblem{}.start, problem::SynthesisProblem{});
  EXPECT_NEAR(initial.range_deg, 85.119, 5e-4);
  EXPECT_NEAR(initial.violation, 5, 1e-9);
  EXPECT_EQ(std::ranges::count_if(initial.checks, [](const auto& check) { return check.slack == -5; }), 3);
}

TEST(Optimize, NoRandomDesignIsBetter) {
  std::mt19937_64 random(20260404);
  for (const double margin : {1.0, 5.0, 20.0}) {
    const problem::SynthesisProblem problem = WithMargins(margin);
    const synthesis::LocalSolve best = synthesis::SolveFrom(problem, problem.start);
    for (int sample = 0; sample < 3000; ++sample) {
      const bool near = sample % 2;
      const linkage::Links links = RandomFeasible(problem, random, near ? &best.end : nullptr);
      ASSERT_LE(DegreesFromRadians(linkage::SolvePose(links, problem.d_min_mm)->theta_rad),
                best.evaluation.range_deg + 1e-6);
    }
  }
}

TEST(Optimize, PricesAreDerivativesOfTheRange) {
  const double step = 1e-3;
  const auto range = [](double grashof, double singularity, double lowest_l5) {
    problem::SynthesisProblem problem;
    problem.grashof_margin_mm = grashof, problem.singularity_margin_mm = singularity,
    problem.bounds[4].lower = lowest_l5;
    return synthesis::SolveFrom(problem, problem.start).evaluation.range_deg;
  };
  const synthesis::LocalSolve solve = synthesis::SolveFrom(WithMargins(2), problem::SynthesisProblem{}.start);
  const synthesis::ActiveSet active = synthesis::FindActiveSet(solve);
  ASSERT_TRUE(active.multipliers_unique);
  const auto multiplier = [&](const std::string& name) {
    for (const auto& entry : active.entries)
      if (entry.name == name) return entry.multiplier;
    ADD_FAILURE() << name << " is not active";
    return 0.0;
  };
  // Central differences: second-order error step^2 f''' / 6 below 1e-5 deg / mm.
  EXPECT_NEAR(multiplier("grashof ≥ 2 mm"), (range(2 + step, 2, 50) - range(2 - step, 2, 50)) / (2 * step), 1e-5);
  EXPECT_NEAR(multiplier("singularity ≥ 2 mm"), (range(2, 2 + step, 50) - range(2, 2 - step, 50)) / (2 * step), 1e-5);
  EXPECT_NEAR(multiplier("l5 ≥ 50 mm"), (range(2, 2, 50 + step) - range(2, 2, 50 - step)) / (2 * step), 1e-5);
}

TEST(Optimize, MultipliersAreNotUniqueAtZeroMargins) {
  EXPECT_FALSE(
      synthesis::FindActiveSet(synthesis::SolveFrom(problem::SynthesisProblem{}, problem::SynthesisProblem{}.start))
          .multipliers_unique);
}

problem::SynthesisProblem EverythingOn() {
  problem::SynthesisProblem problem = WithMargins(1);
  problem.standing_deg = 5;
  problem.limits["max_force_n"] = 1800;
  problem.limits["min_moment_arm_mm"] = 20;
  problem.limits["min_transmission_deg"] = 12;
  problem.limits["d_max_mm"] = 365;
  problem.limits["max_angle_deg"] = 140;
  return problem;
}

TEST(SynthesisProgram, HasExactDerivatives) {
  for (const problem::SynthesisProblem& problem : {problem::SynthesisProblem{}, WithMargins(2), EverythingOn()})
    for (const synthesis::Elasticity elasticity :
         {synthesis::Elasticity::kNone, synthesis::Elasticity::kRequirements, synthesis::Elasticity::kEverything})
      for (const linkage::Links& start :
           {linkage::Links{60, 70, 55, 75, 90, 260}, linkage::Links{66, 72, 61, 80, 70, 280}}) {
        const synthesis::SynthesisProgram program = synthesis::BuildProgram(problem, start, {0.3, 0.7}, elasticity);
        EXPECT_EQ(WrongDerivatives(program.program), "");
      }
}

// Each limit is told from all others by its id, and the program keeps it where its name says.
TEST(SynthesisProgram, LimitsAreFoundByWhatTheyAreOn) {
  const synthesis::SynthesisProgram program =
      synthesis::BuildProgram(EverythingOn(), {60, 70, 55, 75, 90, 260}, {0.3, 0.7});
  for (const synthesis::Limit& limit : program.limits) EXPECT_EQ(program.Find(limit.id), &limit);
  for (const problem::Requirement& requirement : problem::RequirementsOf(EverythingOn())) {
    const synthesis::Limit* limit = program.Find(synthesis::LimitId{requirement.name});
    ASSERT_TRUE(limit) << requirement.name;
    EXPECT_EQ(program.program.Rows()[limit->row].name, requirement.Text());
    EXPECT_EQ(limit->unit, requirement.unit);
  }
  for (int i = 0; i < 6; ++i) EXPECT_EQ(program.Find({synthesis::LimitId::kLink, i})->variable, program.links[i]);
  EXPECT_EQ(program.Find({"misalignment"}), nullptr);
}

TEST(SynthesisProgram, HoldsAtAnAssembledDesign) {
  const synthesis::SynthesisProgram program =
      synthesis::BuildProgram(EverythingOn(), {60, 70, 55, 75, 90, 260}, {0.3, 0.7});
  const std::vector<double> rows = program.program.RowValues(StartOf(program.program));
  int loops = 0;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (program.program.Rows()[i].name.find("loop") != std::string::npos) {
      EXPECT_NEAR(rows[i], 0, 1e-9) << program.program.Rows()[i].name;
      ++loops;
    }
  EXPECT_EQ(loops, 8);  // two loops at d_min, standing and two fractions
}

// Independent of Evaluate(): poses by stroke, not by angle.
void ExpectHoldsOnAFineGrid(const problem::SynthesisProblem& problem, const linkage::Links& links) {
  const linkage::UsedRange range =
      linkage::FindUsedRange(links, problem.d_min_mm, std::nullopt, RadiansFromDegrees(problem.standing_deg));
  ASSERT_NEAR(DegreesFromRadians(range.theta_at_upper_rad), problem.standing_deg, 1e-5);
  constexpr int kPoints = 5000;
  for (int i = 0; i <= kPoints; ++i) {
    const double stroke = std::lerp(range.stroke.lower_mm, range.stroke.upper_mm, i / double{kPoints});
    const auto pose = linkage::SolvePose(links, stroke);
    ASSERT_TRUE(pose) << stroke;
    const linkage::Transmission transmission = linkage::TransmissionOf(links, *pose);
    const double angle =
        DegreesFromRadians(std::min(transmission.transmission_rad, std::numbers::pi - transmission.transmission_rad));
    // Relative to the limit, as the solver's tolerance is; a limit that is off holds always.
    ASSERT_GE(angle, problem.limits["min_transmission_deg"].value_or(0) * (1 - 1e-6)) << stroke;
    ASSERT_GE(transmission.moment_arm_mm, problem.limits["min_moment_arm_mm"].value_or(0) * (1 - 1e-6)) << stroke;
    ASSERT_LE(std::abs(linkage::ActuatorForce(transmission, problem.knee_torque_nm)),
              problem.limits["max_force_n"].value_or(nlp::kUnbounded) * (1 + 1e-6))
        << stroke;
    ASSERT_LE(stroke, problem.limits["d_max_mm"].value_or(nlp::kUnbounded) + 1e-6);
  }
}

TEST(Optimize, FamiliesHoldEverywhereOnTheUsedRange) {
  problem::SynthesisProblem arm = WithMargins(0), force = WithMargins(1), transmission = WithMargins(1),
                            all = EverythingOn();
  arm.limits["min_moment_arm_mm"] = 10;
  force.limits["max_force_n"] = 2000;
  transmission.limits["min_transmission_deg"] = 45;
  transmission.standing_deg = 20;
  for (const problem::SynthesisProblem& problem : {arm, force, transmission, all}) {
    const synthesis::SynthesisResult result = synthesis::Optimize(problem, Starts(4));
    ASSERT_GE(result.best, 0);
    ExpectHoldsOnAFineGrid(problem, result.Best().end);
  }
}

// Hyperextended standing in wide bounds: the transmission angle passes 90 degrees there, and its supplement is worst
// between poses.
TEST(Optimize, ExchangeFindsTheWorstPoseBetweenCollocationPoints) {
  problem::SynthesisProblem problem = WithMargins(2);
  for (std::size_t i = 0; i < 4; ++i) problem.bounds[i] = {30, 200};
  problem.bounds[4] = {20, 150};
  problem.bounds[5] = {200, 400};
  problem.standing_deg = -8;
  problem.limits["min_transmission_deg"] = 30;
  const synthesis::LocalSolve solve = synthesis::SolveFrom(problem, problem.start);
  ASSERT_TRUE(solve.IsUsable()) << solve.solution.message;
  EXPECT_GT(solve.exchanges, 1);
  EXPECT_GT(solve.poses.fractions.size(), 3u);
  ExpectHoldsOnAFineGrid(problem, solve.end);
}

TEST(Optimize, CapIsAnUpperLimit) {
  problem::SynthesisProblem problem = WithMargins(1);
  problem.limits["max_angle_deg"] = 130;
  EXPECT_NEAR(synthesis::SolveFrom(problem, problem.start).evaluation.range_deg, 130, 1e-6);
}

TEST(Optimize, EachRequirementCostsRange) {
  const auto range = [](const problem::SynthesisProblem& problem) {
    return synthesis::SolveFrom(problem, problem.start).evaluation.range_deg;
  };
  double last = range(WithMargins(0));
  for (const double margin : {0.5, 1.0, 5.0, 20.0}) {
    const double next = range(WithMargins(margin));
    EXPECT_LT(next, last);
    last = next;
  }
  problem::SynthesisProblem problem = WithMargins(1);
  problem.limits["d_max_mm"] = 350;
  EXPECT_LT(range(problem), range(WithMargins(1)));
}

// The actuator's length at 90 degrees of flexion, as the closed form has it; the certificate knows the limit too.
TEST(Optimize, HoldsTheActuatorToALengthWhenSitting) {
  const auto length_of = [](const linkage::Links& links) {
    const linkage::UsedRange range = linkage::FindUsedRange(links, problem::SynthesisProblem().d_min_mm, {});
    return linkage::StrokeForAngle(links, range, RadiansFromDegrees(90)).value();
  };
  problem::SynthesisProblem problem = WithMargins(1);
  const synthesis::LocalSolve free = synthesis::SolveFrom(problem, problem.start);
  ASSERT_TRUE(free.IsUsable());
  const double limit_mm = length_of(free.end) - 3;
  problem.limits["max_seated_length_mm"] = limit_mm;
  const synthesis::LocalSolve held = synthesis::SolveFrom(problem, problem.start);
  ASSERT_TRUE(held.IsUsable());
  EXPECT_NEAR(length_of(held.end), limit_mm, 1e-5);
  EXPECT_LT(held.objective, free.objective);
  EXPECT_TRUE(synthesis::FindActiveSet(held).Find(synthesis::LimitId{"length when sitting"}));
  const double with_deg = certificate::CertifyRange(problem, held.objective).upper_bound_deg;
  EXPECT_GE(with_deg, held.objective);
  EXPECT_LT(with_deg, free.objective);
}

TEST(Optimize, RefusesSenselessOptions) {
  EXPECT_THROW(synthesis::Optimize(problem::SynthesisProblem{}, Starts(0)), Error);
  problem::SynthesisProblem problem;
  problem.bounds[2] = {60, 50};
  EXPECT_THROW(synthesis::Optimize(problem, {}), Error);
}

// Only what must hold at many poses has a worst one.
TEST(UsedPoses, EachKindIsEvaluatedAsItself) {
  problem::SynthesisProblem problem = Buildable();
  problem.limits["d_max_mm"] = 380;
  problem.limits["max_angle_deg"] = 150;
  problem.limits["safety_factor"] = 1.5;
  problem.limits["max_pin_force_n"] = problem.limits["max_mount_force_n"] = 9000;
  problem.limits["min_moment_arm_mm"] = 1;
  problem.clearances.seat_mm = problem.clearances.thigh_mm = problem.clearances.shank_mm = 0;
  problem::UsedPoses poses({60, 70, 55, 75, 90, 260}, problem);
  ASSERT_TRUE(poses.Range());
  for (const problem::Requirement& requirement : problem::RequirementsOf(problem))
    if (requirement.IsFamily())
      EXPECT_FALSE(poses.WorstPoints(requirement).empty()) << requirement.Text();
    else
      EXPECT_THROW(poses.WorstPoints(requirement), std::logic_error) << requirement.Text();
}

struct PlannedEnd {
  double objective;
  bool is_usable = true;
  bool IsUsable() const { return is_usable; }
};

// Starts that lead to these ends in turn, until the best is confirmed.
synthesis::MultiStart<PlannedEnd> UntilConfirmed(const std::vector<PlannedEnd>& ends) {
  std::size_t next = 0;
  return synthesis::SolveFromEach(
      std::vector<linkage::Links>(ends.size()), [&](const linkage::Links&) { return ends[next++]; },
      synthesis::Until::kConfirmed);
}

TEST(MultiStart, EndsWhereASecondStartCameToTheBest) {
  EXPECT_EQ(UntilConfirmed({{150}, {150 + 1e-7}, {160}, {160}}).starts.size(), 2);
  const auto risen = UntilConfirmed({{140}, {150}, {150}, {160}});
  EXPECT_EQ(risen.starts.size(), 3);
  EXPECT_EQ(risen.Best().objective, 150);
}

TEST(MultiStart, GoesOnWhereTheBestStandsAlone) {
  EXPECT_EQ(UntilConfirmed({{150}, {140}, {140}, {140}}).starts.size(), 4);
  EXPECT_EQ(UntilConfirmed({{150, false}, {150}, {150, false}, {150}}).starts.size(), 4);
  const auto none = UntilConfirmed({{150, false}, {150, false}});
  EXPECT_EQ(none.starts.size(), 2);
  EXPECT_FALSE(none.IsSolved());
}

}  // namespace
}  // namespace lake
