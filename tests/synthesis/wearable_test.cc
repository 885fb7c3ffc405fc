// Designs that stay clear of the person, bear what they are loaded with, and keep both when they are built inexactly:
// each held against the room that has the closed form, not against the program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "central_differences.h"
#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/linkage/wear.h"
#include "lake/parts/strength.h"
#include "lake/synthesis/actuator_front.h"
#include "lake/synthesis/infeasibility.h"
#include "load_profile.h"
#include "paper.h"

namespace lake {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

// On the leg of the sample study.
problem::SynthesisProblem OnALeg(problem::SynthesisProblem problem) {
  problem.clearances.body.leg = {410, 400};
  problem.clearances.body.mass_kg = 70;
  return problem;
}

linkage::WearCheck WearOf(const linkage::Links& links, const problem::SynthesisProblem& problem) {
  return linkage::CheckWear(
      links, linkage::FindUsedRange(links, problem.d_min_mm, {}, RadiansFromDegrees(problem.standing_deg)),
      person::BodyOf(problem.clearances.body), problem.Wear());
}

synthesis::LocalSolve SolveAtSeat(double seat_mm) {
  problem::SynthesisProblem problem = OnALeg(Buildable());
  problem.clearances.seat_mm = seat_mm;
  return synthesis::SolveFrom(problem, problem.start);
}

TEST(Clearance, OfTheSeatIsThatOfTheClosedFormAndHasItsPrice) {
  const problem::SynthesisProblem problem = OnALeg(Buildable());
  constexpr double kSeat_mm = 5, kStep_mm = 0.05;
  const synthesis::LocalSolve without = synthesis::SolveFrom(problem, problem.start), solve = SolveAtSeat(kSeat_mm);
  ASSERT_TRUE(solve.IsUsable()) << solve.solution.message;
  EXPECT_LT(WearOf(without.end, problem).seat_clearance_mm, kSeat_mm);
  EXPECT_NEAR(WearOf(solve.end, problem).seat_clearance_mm, kSeat_mm, 1e-5);
  EXPECT_LT(solve.evaluation.range_deg, without.evaluation.range_deg);
  const auto multiplier = solve.MultiplierOf(synthesis::LimitId{"seat clearance"});
  ASSERT_TRUE(multiplier);
  const double more = SolveAtSeat(kSeat_mm + kStep_mm).evaluation.range_deg,
               less = SolveAtSeat(kSeat_mm - kStep_mm).evaluation.range_deg;
  EXPECT_NEAR(*multiplier, (more - less) / (2 * kStep_mm), 0.01 * std::abs(*multiplier));
  EXPECT_TRUE(synthesis::FindActiveSet(solve).Find(synthesis::LimitId{"seat clearance"}));
}

// A joint that sits higher on the shank lifts the seated linkage off the seat.
TEST(Clearance, IsTakenWhereTheJointSits) {
  problem::SynthesisProblem problem = OnALeg(Buildable());
  problem.clearances.seat_mm = 5;
  const double on_the_knee = synthesis::SolveFrom(problem, problem.start).evaluation.range_deg;
  problem.clearances.placement_mm = {0, 3};
  EXPECT_NEAR(synthesis::SolveFrom(problem, problem.start).evaluation.range_deg, SolveAtSeat(2).evaluation.range_deg,
              1e-4);
  problem.clearances.placement_mm = {0, 0};
  problem.clearances.placement_reach_mm = 3;
  const synthesis::LocalSolve free = synthesis::SolveFrom(problem, problem.start);
  EXPECT_GT(free.evaluation.range_deg, on_the_knee + 0.1);
  EXPECT_NEAR(free.evaluation.CheckOf("seat clearance").value, 5, 1e-5);
}

// The paper's links are too short to bring the bar's tip, which passes the knee, out of the leg.
TEST(Clearance, OfTheLimbThatCannotBeHadSaysByHowMuch) {
  problem::SynthesisProblem problem = OnALeg(Buildable());
  problem.clearances.thigh_mm = problem.clearances.shank_mm = 10;
  const synthesis::InfeasibilityReport report = synthesis::AnalyseInfeasibility(problem);
  ASSERT_TRUE(report.solved);
  EXPECT_THAT(report.sentence, HasSubstr("relax thigh clearance ≥ 10 mm by "));
  // What it takes is what the closed form says of the nearest design.
  const linkage::WearCheck nearest = WearOf(report.links, problem);
  for (const auto& [name, clearance_mm] :
       {std::pair{"thigh", nearest.thigh_clearance_mm}, {"shank", nearest.shank_clearance_mm}}) {
    const auto found = std::ranges::find_if(report.relaxations, [name = name](const synthesis::Relaxation& relaxation) {
      return relaxation.text.starts_with(name);
    });
    ASSERT_NE(found, report.relaxations.end());
    EXPECT_NEAR(found->relaxed, clearance_mm, 0.05);  // CheckWear looks at 101 poses
  }
}

TEST(Clearance, OfTheLimbIsHeldWhereLinksMayBeLonger) {
  problem::SynthesisProblem problem = OnALeg(WithMargins(2));
  problem.bounds = {{{50, 250}, {50, 250}, {50, 250}, {50, 250}, {50, 250}, {200, 350}}};
  problem.standing_deg = 10;
  problem.clearances.thigh_mm = 10;
  const synthesis::SynthesisResult result = synthesis::Optimize(problem, Starts(8));
  ASSERT_GE(result.best, 0);
  const synthesis::LocalSolve& best = result.Best();
  EXPECT_GE(WearOf(best.end, problem).thigh_clearance_mm, 10 - 1e-4);
  problem.clearances.thigh_mm.reset();
  EXPECT_LT(WearOf(synthesis::SolveFrom(problem, problem.start).end, problem).thigh_clearance_mm, 0);
}

std::vector<parts::LoadedPose> LoadedPoses(const linkage::Links& links, const problem::SynthesisProblem& problem) {
  const linkage::UsedRange range =
      linkage::FindUsedRange(links, problem.d_min_mm, {}, RadiansFromDegrees(problem.standing_deg));
  std::vector<parts::LoadedPose> poses;
  constexpr int kPoses = 2000;
  for (int i = 0; i <= kPoses; ++i) {
    const linkage::Pose pose = linkage::RequirePose(links, range.stroke.lower_mm + range.stroke.Travel() * i / kPoses);
    poses.push_back({pose, problem.knee_torque_nm, linkage::MemberForcesOf(pose, problem.knee_torque_nm)});
  }
  return poses;
}

double LeastSafety(const linkage::Links& links, const problem::SynthesisProblem& problem) {
  const auto range = linkage::FindUsedRange(links, problem.d_min_mm, {}, RadiansFromDegrees(problem.standing_deg));
  double least = HUGE_VAL;
  for (const parts::StrengthCheck& check :
       parts::CheckStrength(parts::MakeMechanism(links, range, problem.parts), LoadedPoses(links, problem)))
    least = std::min(least, check.Safety());
  return least;
}

// Wide links, so that it is not their bending, which has nothing to do with the links' lengths.
TEST(Strength, SafetyFactorIsThatOfTheTable) {
  problem::SynthesisProblem problem = Buildable();
  problem.limits["max_force_n"].reset();
  problem.limits["min_transmission_deg"].reset();
  problem.parts.bar_width_mm = 40;
  const double asked = 1.3 * LeastSafety(synthesis::SolveFrom(problem, problem.start).end, problem);
  problem.limits["safety_factor"] = asked;
  const synthesis::LocalSolve solve = synthesis::SolveFrom(problem, problem.start);
  ASSERT_TRUE(solve.IsUsable()) << solve.solution.message;
  // The worst pose lies between two of the 2001.
  EXPECT_NEAR(LeastSafety(solve.end, problem), asked, 1e-3);
  EXPECT_NEAR(solve.evaluation.CheckOf("safety factor").value, asked, 1e-5);
  ASSERT_NE(synthesis::FindActiveSet(solve).Find(synthesis::LimitId{"safety factor"}), nullptr);
}

// A thin rod buckles before any plate gives way, and bending of the shank link has nothing to do with the links.
TEST(Strength, RodAndBendingAreHeldToo) {
  problem::SynthesisProblem problem = Buildable();
  problem.limits["max_force_n"].reset();
  problem.limits["safety_factor"] = 2;
  problem.parts.rod_diameter_mm = 6;
  const synthesis::LocalSolve solve = synthesis::SolveFrom(problem, problem.start);
  ASSERT_TRUE(solve.IsUsable()) << solve.solution.message;
  EXPECT_NEAR(LeastSafety(solve.end, problem), 2, 1e-3);
  problem.parts.material = "PLA";
  problem.parts.rod_diameter_mm = 10;
  const double bending = parts::CapacityOf(problem.parts).knee_torque_nm / problem.knee_torque_nm;
  problem.limits["safety_factor"] = 2 * bending;
  const synthesis::InfeasibilityReport report = synthesis::AnalyseInfeasibility(problem);
  EXPECT_THAT(report.sentence, HasSubstr("relax safety factor"));
  EXPECT_THAT(report.sentence, ::testing::ContainsRegex("by [0-9.]+ to [0-9.]+"));  // a pure number has no unit
}

TEST(Strength, PinAndMountForcesAreThoseOfStatics) {
  problem::SynthesisProblem problem = Buildable();
  problem.limits["max_force_n"].reset();
  const auto largest = [&](const linkage::Links& links, double (linkage::MemberForces::*force)() const) {
    double most = 0;
    for (const parts::LoadedPose& at : LoadedPoses(links, problem)) most = std::max(most, (at.forces.*force)());
    return most;
  };
  problem.limits["max_pin_force_n"] = 2500;
  const synthesis::LocalSolve pins = synthesis::SolveFrom(problem, problem.start);
  ASSERT_TRUE(pins.IsUsable()) << pins.solution.message;
  EXPECT_NEAR(largest(pins.end, &linkage::MemberForces::TipPin), 2500, 2.5);
  problem.limits["max_pin_force_n"].reset();
  problem.limits["max_mount_force_n"] = 1200;
  const synthesis::LocalSolve mount = synthesis::SolveFrom(problem, problem.start);
  ASSERT_TRUE(mount.IsUsable()) << mount.solution.message;
  EXPECT_NEAR(largest(mount.end, &linkage::MemberForces::Mount), 1200, 1.2);
  // The mount bears the actuator's force.
  problem.limits["max_mount_force_n"].reset();
  problem.limits["max_force_n"] = 1200;
  EXPECT_NEAR(synthesis::SolveFrom(problem, problem.start).evaluation.range_deg, mount.evaluation.range_deg, 1e-4);
}

TEST(Strength, AlongAProfileOfConstantMomentIsThatOfTheTorque) {
  problem::SynthesisProblem constant = Buildable();
  constant.limits["max_force_n"].reset();
  constant.limits["max_pin_force_n"] = 2500;
  const synthesis::LocalSolve expected = synthesis::SolveFrom(constant, constant.start);
  ASSERT_TRUE(expected.IsUsable());
  problem::SynthesisProblem profile = constant;
  profile.profile = ConstantProfile(expected.evaluation.range_deg - 1e-6, 5, constant.knee_torque_nm, 301);
  const auto check = problem::Evaluate(expected.end, profile).CheckOf("pin force");
  EXPECT_TRUE(check.requirement.along_profile);
  EXPECT_NEAR(check.value, 2500, 25);  // of 301 angles, near the worst
}

// Gradients against differences of values, with every kind of row: seat, limbs, strength, builds.
TEST(Program, DerivativesOfClearancesStrengthAndBuilds) {
  problem::SynthesisProblem problem = OnALeg(Buildable());
  problem.clearances.seat_mm = 5;
  problem.clearances.thigh_mm = 10;
  problem.clearances.shank_mm = 10;
  problem.clearances.placement_mm = {13, 2};
  problem.clearances.placement_reach_mm = 40;
  problem.limits["safety_factor"] = 1.2;
  problem.limits["max_pin_force_n"] = 4000;
  problem.limits["max_mount_force_n"] = 2000;
  problem.robust_mm = 0.1;
  synthesis::Collocation poses{0.5};
  poses.builds = {problem::Corners(0.1)[37]};
  const synthesis::SynthesisProgram program = synthesis::BuildProgram(problem, kPublishedLinks, poses);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<double> x = StartOf(program.program);
  for (double& value : x) value += 0.05 * unit(random);
  // Of a central difference: its truncation, and the rounding of values up to a few hundred.
  for (const nlp::NlpTerm& term : program.program.Terms()) EXPECT_EQ(WrongDerivatives(*term.term, x, 1e-5), "");
}

// The rows of a design that clears hold, and those of one that does not fail, by the same number.
TEST(Program, ClearanceRowsMeanWhatTheClosedFormSays) {
  problem::SynthesisProblem problem = OnALeg(Buildable());
  problem.clearances.placement_mm = {13, 2};
  problem.clearances.seat_mm = problem.clearances.thigh_mm = problem.clearances.shank_mm = 0;
  const problem::DesignEvaluation evaluation = problem::Evaluate(kPublishedLinks, problem);
  for (const double off_mm : {-0.01, 0.01}) {
    problem::SynthesisProblem asked = problem;
    asked.clearances.seat_mm = evaluation.CheckOf("seat clearance").value + off_mm;
    asked.clearances.thigh_mm = evaluation.CheckOf("thigh clearance").value + off_mm;
    asked.clearances.shank_mm = evaluation.CheckOf("shank clearance").value + off_mm;
    const synthesis::Collocation poses{evaluation.CheckOf("thigh clearance").fraction,
                                       evaluation.CheckOf("shank clearance").fraction};
    const synthesis::SynthesisProgram program = synthesis::BuildProgram(asked, kPublishedLinks, poses);
    const std::vector<double> x = StartOf(program.program);
    const std::vector<double> values = program.program.RowValues(x);
    for (const char* name : {"seat clearance", "thigh clearance", "shank clearance"}) {
      double least = HUGE_VAL;
      for (std::size_t i = 0; i < values.size(); ++i) {
        const nlp::NlpRow& row = program.program.Rows()[i];
        if (row.name.starts_with(name) && row.lower == 0 && row.upper > 1) least = std::min(least, values[i]);
      }
      EXPECT_NEAR(least, -off_mm / 100, 1e-9) << name;  // rows are in 100 mm
    }
  }
}

// Every build of 20 000 within the tolerance can be assembled, meets the limits and has at least the range promised.
TEST(Robust, WorstBuildHoldsForRandomOnes) {
  problem::SynthesisProblem problem = WithMargins(0);
  problem.robust_mm = 0.2;
  const synthesis::LocalSolve solve = synthesis::SolveFrom(problem, problem.start);
  ASSERT_TRUE(solve.IsUsable()) << solve.solution.message;
  const double promised_deg = solve.evaluation.worst_range_deg;
  EXPECT_LT(promised_deg, solve.evaluation.range_deg);
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> within(-0.2, 0.2);
  double least_deg = HUGE_VAL;
  for (int i = 0; i < 20000; ++i) {
    problem::BuildError error;
    for (double& off : error) off = within(random);
    const problem::DesignEvaluation build =
        problem::Evaluate(problem::LinksOf(error, solve.end), problem::ProblemOf(error, problem));
    ASSERT_TRUE(build.IsFeasible()) << i;
    least_deg = std::min(least_deg, build.range_deg);
  }
  EXPECT_GE(least_deg, promised_deg - 1e-9);
  // Random builds come near the corner: it is no empty promise.
  EXPECT_LT(least_deg, 0.5 * (promised_deg + solve.evaluation.range_deg));
  // No design near it has a better worst case, nor has the optimum of links that are exact.
  for (int i = 0; i < 300; ++i) {
    auto values = solve.end.Values();
    for (double& value : values) value += 10 * within(random);
    const problem::DesignEvaluation other = problem::Evaluate(linkage::Links::FromValues(values), problem);
    if (other.IsFeasible()) {
      EXPECT_LE(other.worst_range_deg, promised_deg + 1e-6);
    }
  }
}

TEST(Robust, LimitsOverTheRangeHoldForBuildsToo) {
  problem::SynthesisProblem problem = WithMargins(0);
  problem.robust_mm = 0.2;
  problem.limits["max_force_n"] = 2000;
  problem.standing_deg = 5;
  const synthesis::LocalSolve solve = synthesis::SolveFrom(problem, problem.start);
  ASSERT_TRUE(solve.IsUsable()) << solve.solution.message;
  std::mt19937_64 random(12);
  std::uniform_real_distribution<double> within(-0.2, 0.2);
  for (int i = 0; i < 200; ++i) {
    problem::BuildError error;
    for (double& off : error) off = within(random);
    const problem::DesignEvaluation build =
        problem::Evaluate(problem::LinksOf(error, solve.end), problem::ProblemOf(error, problem));
    ASSERT_TRUE(build.IsFeasible()) << i;
    EXPECT_GE(build.range_deg, solve.evaluation.worst_range_deg - 1e-6);
  }
  // What is asked for with exact links does not hold for all builds.
  problem.robust_mm.reset();
  const linkage::Links exact = synthesis::SolveFrom(problem, problem.start).end;
  problem.robust_mm = 0.2;
  EXPECT_FALSE(problem::Evaluate(exact, problem).IsFeasible());
}

TEST(Wearable, RefusesWhatCannotBe) {
  const auto refuses = [](const auto& change, const std::string& text) {
    problem::SynthesisProblem problem;
    change(problem);
    try {
      problem.Check();
      ADD_FAILURE() << text;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr(text));
    }
  };
  refuses([](auto& p) { p.clearances.seat_mm = -1; }, "seat_mm = -1");
  refuses([](auto& p) { p.clearances.thigh_mm = NAN; }, "limb_mm = nan");
  refuses([](auto& p) { p.clearances.seat_mm = 5, p.clearances.body.mass_kg = 0; }, "a body of 0 kg");
  refuses([](auto& p) { p.clearances.seat_mm = 5, p.clearances.body.leg = {410, 0}; }, "a shank of 0 mm");
  refuses([](auto& p) { p.robust_mm = 0; }, "robust_mm");
  refuses([](auto& p) { p.limits["safety_factor"] = -2; }, "safety_factor = -2");
  refuses([](auto& p) { p.start = {0.059, 0.069, 0.056, 0.072, 0.119, 0.287}; }, "write lengths in mm, not in m");
}

// The second cannot be built in at all: its shortest length is beyond the longest stroke that the problem allows.
TEST(ActuatorFront, AnActuatorThatContradictsTheProblemStopsNoOther) {
  problem::SynthesisProblem problem = Buildable();
  problem.profile = MadeUpProfile();
  problem.limits["d_max_mm"] = 390;
  problem::LinearActuator strong;
  strong.name = "strong";
  strong.closed_mm = 242;
  strong.travel_mm = 200;
  strong.max_force_n = 5000;
  problem::LinearActuator longer = strong;
  longer.name = "longer";
  longer.closed_mm = 400;
  const auto curves = synthesis::FindActuatorFront(problem, {longer, strong}, {0.1}, Starts(2));
  ASSERT_EQ(curves.size(), 2u);
  EXPECT_EQ(curves[0].Actuator().name, "longer");
  EXPECT_EQ(curves[0].Last(), nullptr);
  EXPECT_THAT(curves[0].failing, HasSubstr("d_max_mm = 390 must exceed d_min_mm = 400"));
  EXPECT_THAT(curves[0].limits, Contains(HasSubstr("d_max_mm = 390")));
  EXPECT_NE(curves[1].Last(), nullptr);
}

}  // namespace
}  // namespace lake
