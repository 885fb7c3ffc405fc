// A program along which a person keeps the balance: the body's dynamics against Newton's, the requirement in the
// optimum, and the limits on knee angle and joint beside it.
#include "lake/redesign/balance.h"

#include <gmock/gmock.h>

#include <span>

#include "compare/closed_form.h"
#include "draws.h"
#include "lake/redesign/redesign_outcome.h"
#include "synthesis/paper.h"

namespace lake {
namespace {

using Goal = redesign::RedesignProblem::Goal;
using Kind = linkage::StrokeProgram::Kind;
using redesign::MisalignmentOf;
using testing::HasSubstr;

constexpr std::size_t kSamples = compare::kPercentSamples;

// A man of 70 kg and 1.75 m: Winter's segments; the trunk leans by 12 deg when the seat is left, then upright. So his
// centre of mass is behind the heel there.
std::shared_ptr<const loads::BodyPath> Body() {
  loads::BodyPath path;
  path.body.foot = {1.0, 0.06, 0.12};
  path.body.shank = {3.3, 0.182, 0.127};
  path.body.thigh = {7.0, 0.173, 0.129};
  path.body.trunk = {23.7, 0.32, 0.25};
  path.body.sole = {0.066, 0.2};
  path.body.ankle_height_m = 0.068;
  path.feet_from_percent = 40;
  for (std::size_t i = 0; i < kSamples; ++i) {
    const double u = static_cast<double>(i) / 100;
    const double tilt = RadiansFromDegrees(12) * (SmoothStep(u / 0.4) - SmoothStep((u - 0.4) / 0.6));
    path.trunk.push_back({tilt, 0.32 * Eigen::Vector2d(std::sin(tilt), std::cos(tilt))});
  }
  return std::make_shared<const loads::BodyPath>(path);
}

redesign::RedesignProblem BalancedProblem(double duration_s = 30) {
  redesign::RedesignProblem problem;
  problem.design = WithMargins(2);
  problem.human = redesign::MakeHumanMotion(MakeCurve({}));
  problem.program.kind = Kind::kFree;
  problem.program.duration_s = duration_s;
  problem.max_misalignment_percent = 2;
  problem.body = Body();
  return problem;
}

std::optional<redesign::RedesignSolve> Optimum(const redesign::RedesignProblem& problem) {
  return redesign::FindOptimum(problem, {problem.design.start, kPublishedLinks}, Starts(2));
}

std::vector<double> HumanAngles(const redesign::HumanMotion& human) {
  std::vector<double> angles;
  for (const redesign::HumanSample& sample : human) angles.push_back(sample.knee_rad);
  return angles;
}

// Newton–Euler on the same bodies (loads/inverse_dynamics.h), their motion given in closed form with its derivatives.
TEST(BalanceOfABody, SupportIsThatOfNewtonAndEuler) {
  const std::shared_ptr<const loads::BodyPath> path = Body();
  const loads::LegBody& body = path->body;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int draw = 0; draw < 20; ++draw) {
    constexpr double kStep_s = 1e-3;
    std::array<loads::BodyPose<double>, 3> poses;
    std::vector<loads::Body> bodies;
    const loads::SegmentInertia* inertias[] = {&body.shank, &body.thigh, &body.trunk};
    for (std::size_t i = 0; i < 3; ++i) {
      const std::array amplitude{unit(random), unit(random), unit(random)};
      const std::array rate{2 + unit(random), 2 + unit(random), 2 + unit(random)};
      const auto at = [&](std::size_t k, double t) { return amplitude[k] * std::sin(rate[k] * (t + 0.4)); };
      const auto second = [&](std::size_t k) { return -rate[k] * rate[k] * at(k, 0); };
      for (std::size_t p = 0; p < 3; ++p) {
        const double t = kStep_s * (static_cast<double>(p) - 1);
        poses[p][i] = {at(0, t), at(1, t), at(2, t)};
      }
      const double inertia = inertias[i]->mass_kg * inertias[i]->gyration_m * inertias[i]->gyration_m;
      bodies.push_back({inertias[i]->mass_kg, inertia, {at(0, 0), at(1, 0)}, {second(0), second(1)}, -second(2)});
    }
    const Eigen::Vector2d about(0.1, -0.3);
    const loads::Wrench wrench = loads::RequiredWrench(bodies, about);
    const loads::Support<double> support = loads::FindSupport(poses, kStep_s, *path, 0, about.x(), about.y());
    // Central differences at 1 ms of motions of up to 3 rad/s: 1e-6 of the accelerations, and their rounding.
    EXPECT_NEAR(support.force_n, wrench.force_n.y(), 1e-2);
    EXPECT_NEAR(support.moment_nm, wrench.moment_nm, 1e-2);
  }
}

TEST(BalanceOfABody, AsSlowlyAsMayBeThePressureIsUnderTheCentreOfMass) {
  const redesign::RedesignProblem problem = BalancedProblem();
  const loads::BodyPath& body = *problem.body;
  const compare::StsCurve curve = MakeCurve({});
  const redesign::BalanceCourse course =
      redesign::FindBalance(problem.human, body, HumanAngles(problem.human), {}, 1e4);
  ASSERT_EQ(course.samples.size(), 61u);
  for (const redesign::BalanceSample& sample : course.samples) {
    const auto i = static_cast<std::size_t>(sample.percent);
    const redesign::HumanSample& human = problem.human[i];
    const Eigen::Vector2d ankle = curve.ankle[i] / 1000, knee = curve.knee[i] / 1000, hip = curve.hip[i] / 1000;
    const auto [foot, shank, thigh, trunk] =
        std::tie(body.body.foot, body.body.shank, body.body.thigh, body.body.trunk);
    const double moment = foot.mass_kg * foot.centre_m +
                          shank.mass_kg * std::lerp(knee.x(), ankle.x(), shank.centre_m / (human.shank_mm / 1000)) +
                          thigh.mass_kg * std::lerp(hip.x(), knee.x(), thigh.centre_m / (human.thigh_mm / 1000)) +
                          trunk.mass_kg * (hip.x() + body.trunk[i].centre_m.x());
    const double mass = foot.mass_kg + shank.mass_kg + thigh.mass_kg + trunk.mass_kg;
    EXPECT_NEAR(sample.pressure_mm, 1000 * moment / mass, 1e-3) << sample.percent;
  }
}

// A held trunk weighs less on the foot by that force, where the trunk's centre is; the exoskeleton's halves weigh where
// the centres of shank and thigh are.
TEST(BalanceOfABody, WhatHoldsAndWhatIsWornCount) {
  const redesign::RedesignProblem problem = BalancedProblem();
  const compare::StsCurve curve = MakeCurve({});
  const auto course_of = [&](const loads::Aids& aids) {
    loads::BodyPath body = *problem.body;
    body.aids = aids;
    return redesign::FindBalance(problem.human, body, HumanAngles(problem.human), {}, 1e4);
  };
  const auto alone = course_of({}), held = course_of({.hold_n = 100}), worn = course_of({.device_kg = 4});
  const loads::LegBody& body = problem.body->body;
  const double weight_n = 9.80665 * (body.foot.mass_kg + body.shank.mass_kg + body.thigh.mass_kg + body.trunk.mass_kg);
  for (std::size_t k = 0; k < alone.samples.size(); ++k) {
    const auto i = static_cast<std::size_t>(alone.samples[k].percent);
    const Eigen::Vector2d ankle = curve.ankle[i], knee = curve.knee[i], hip = curve.hip[i];
    const double trunk_mm = hip.x() + 1000 * problem.body->trunk[i].centre_m.x(), half_n = 2 * 9.80665;
    const double shank_mm = std::lerp(knee.x(), ankle.x(), 1000 * body.shank.centre_m / (knee - ankle).norm()),
                 thigh_mm = std::lerp(hip.x(), knee.x(), 1000 * body.thigh.centre_m / (hip - knee).norm());
    const double moment = weight_n * alone.samples[k].pressure_mm;
    EXPECT_NEAR(held.samples[k].pressure_mm, (moment - 100 * trunk_mm) / (weight_n - 100), 0.01) << i;
    EXPECT_NEAR(worn.samples[k].pressure_mm, (moment + half_n * (shank_mm + thigh_mm)) / (weight_n + 2 * half_n), 0.01)
        << i;
    EXPECT_NEAR(held.samples[k].knee_nm - alone.samples[k].knee_nm, 100 * (trunk_mm - knee.x()) / 1000, 0.01) << i;
  }
  EXPECT_GT(held.margin_mm, alone.margin_mm + 5);  // a rise of momentum, held by a helper
}

TEST(BalancedProgram, IsHeldAtEveryInstantAndItsCostIsTold) {
  redesign::RedesignProblem problem = BalancedProblem();
  const auto free = Optimum(problem);
  ASSERT_TRUE(free);
  EXPECT_LT(free->Predicted()->balance->margin_mm, 0);  // this rise is one of momentum
  problem.balance_mm = 20;
  const auto balanced = Optimum(problem);
  ASSERT_TRUE(balanced);
  const redesign::Prediction& prediction = *balanced->Predicted();
  EXPECT_GE(prediction.balance->margin_mm, 20 - 0.01);
  EXPECT_LE(balanced->Misalignment_percent(), 2 * (1 + 1e-5));
  EXPECT_LE(balanced->Range_deg(), free->Range_deg() + 1e-3);
  EXPECT_LE(prediction.balance->duration_s, 30 * (1 + 1e-5));
  for (std::size_t i = 0; i < kSamples; ++i) {
    EXPECT_LE(std::abs(balanced->Point().lean.trunk_rad[i]), RadiansFromDegrees(30) + 1e-9);
    EXPECT_LE(std::abs(balanced->Point().lean.leg_rad[i]), RadiansFromDegrees(10) + 1e-9);
    if (i >= 40) continue;
    EXPECT_NEAR(redesign::HipHeight(problem.human[i], prediction.theta_rad[i], balanced->Point().lean.leg_rad[i]),
                redesign::HipHeight(problem.human[i], problem.human[i].knee_rad, 0.0), 20 + 1e-3);
  }
}

TEST(BalancedProgram, WhatCannotBeHadIsToldWithTheMostThatCan) {
  redesign::RedesignProblem problem = BalancedProblem();
  problem.max_angle_mismatch_deg = 5;  // a knee that bends at will brings the hip over the foot
  problem.balance_mm = 90;
  problem.lean_limits = {.trunk_deg = 5, .leg_deg = 2};
  const auto report = redesign::ExplainInfeasible(problem, {problem.design.start, kPublishedLinks}, Starts(1));
  EXPECT_THAT(report.sentence, HasSubstr("(--balance)"));
  ASSERT_EQ(report.quantity, &redesign::kBalanceMargin);
  EXPECT_LT(*report.best, 90);
  problem.balance_mm = *report.best - 0.5;
  problem.max_misalignment_percent = 20;
  EXPECT_TRUE(Optimum(problem));
}

// The moments of the person's own rise in so many seconds.
problem::LoadProfile OwnMoments(const redesign::RedesignProblem& problem, double duration_s) {
  const std::vector<double> angles = HumanAngles(problem.human);
  const redesign::BalanceCourse course = redesign::FindBalance(problem.human, *problem.body, angles, {}, duration_s);
  std::vector<double> percent, knee_deg, knee_nm(kSamples, NAN);
  for (std::size_t i = 0; i < kSamples; ++i) {
    percent.push_back(static_cast<double>(i));
    knee_deg.push_back(DegreesFromRadians(angles[i]));
  }
  for (const redesign::BalanceSample& sample : course.samples)
    knee_nm[static_cast<std::size_t>(sample.percent)] = sample.knee_nm;
  return problem::MakeLoadProfile(percent, knee_deg, knee_nm, duration_s);
}

// The actuator's force is limited by what the knee needs along the program that comes of it, not in the quick rise that
// was measured: program, lean, pace and moments agree in the end. At 1000 N the design is the one without that limit,
// which no other way of solving can better; under the quick rise's moments its range would be 7° less.
TEST(BalancedProgram, IsSoughtUnderItsOwnMoments) {
  redesign::RedesignProblem problem = BalancedProblem();
  problem.balance_mm = 20;
  const auto free = Optimum(problem);
  ASSERT_TRUE(free);
  const std::vector<linkage::Links> links = {problem.design.start, kPublishedLinks};
  const problem::LoadProfile quick = OwnMoments(problem, 1.5);
  constexpr double kForces_n[] = {1000, 850};
  for (const double force_n : std::span(kForces_n).first(Draws(1, 2))) {
    SCOPED_TRACE(force_n);
    problem.design.profile = quick;
    problem.design.limits["max_force_n"] = force_n;
    const redesign::MomentsOfProgram moments = redesign::FindMoments(problem, links, Starts(2));
    EXPECT_LE(moments.off_nm, 0.1);
    EXPECT_LE(moments.rounds, 6);
    const auto under_quick = Optimum(problem);
    problem.design.profile = moments.profile;
    const auto under_own = Optimum(problem);
    ASSERT_TRUE(under_quick && under_own);
    const auto off_nm = [&](const redesign::RedesignSolve& solve, const problem::LoadProfile& sought_under) {
      return redesign::LargestDifferenceNm(redesign::ProfileOf(problem, quick, solve.Point()), sought_under);
    };
    EXPECT_LE(off_nm(*under_own, moments.profile), 0.5);
    EXPECT_GE(off_nm(*under_quick, quick), 15);
    EXPECT_GT(under_own->Range_deg(), under_quick->Range_deg() + 5);
    EXPECT_LE(under_own->Range_deg(), free->Range_deg() + 1e-3);
    if (force_n == 1000) {
      EXPECT_GE(under_own->Range_deg(), free->Range_deg() - 1e-3);
    }
  }
}

TEST(BalancedProgram, OfAWholeRedesignSaysOfWhichRiseTheMomentsAre) {
  redesign::RedesignProblem problem = BalancedProblem();
  problem.balance_mm = 20;
  problem.design.profile = OwnMoments(problem, 1.5);
  problem.design.limits["max_force_n"] = 1000;
  redesign::RedesignOptions options;
  options.optimize = Starts(2);
  const redesign::RedesignOutcome outcome = redesign::RunRedesign(problem, {.human = MakeCurve({})}, options);
  ASSERT_TRUE(outcome.IsSolved() && outcome.moments);
  EXPECT_NEAR(outcome.moments->duration_s, outcome.after.duration_s, 0.1);
  EXPECT_LE(outcome.moments->off_nm, 0.5);
}

// What stands beside the design has moments of its own: those of the start's quick constant program, of the fronts'
// programs, and of the one whose person need not be in balance.
TEST(BalancedProgram, OfAWholeRedesignHasOtherMomentsThanWhatStandsBeside) {
  redesign::RedesignProblem problem = BalancedProblem();
  problem.balance_mm = 20;
  problem.design.profile = OwnMoments(problem, 1.5);
  problem.design.limits["max_force_n"] = 1000;
  problem.design.start = kPublishedLinks;
  redesign::RedesignOptions options;
  options.optimize = Starts(2);
  options.pareto_points = 2;
  const auto outcome = redesign::RunRedesign(problem, {.human = MakeCurve({})}, options);
  ASSERT_TRUE(outcome.IsSolved() && outcome.without_balance && outcome.before.prediction);

  for (const redesign::DesignInMotion* design : {&outcome.before, &*outcome.without_balance}) {
    const problem::LoadProfile along = redesign::ProfileAlong(outcome.problem.human, outcome.moments->measured,
                                                              design->prediction, design->duration_s);
    EXPECT_GT(redesign::LargestDifferenceNm(along, outcome.moments->profile), 1);
    problem::SynthesisProblem under = outcome.problem.design;
    under.profile = along;
    const char* force = "force";
    EXPECT_THAT(design->evaluation.CheckOf(force).value,
                testing::NanSensitiveDoubleEq(problem::Evaluate(design->design.links, under).CheckOf(force).value));
  }
  ASSERT_TRUE(outcome.moments_without_balance);
  EXPECT_NEAR(outcome.moments_without_balance->duration_s, outcome.without_balance->duration_s, 0.1);
  EXPECT_LE(outcome.moments_without_balance->off_nm, 0.5);
  ASSERT_EQ(outcome.fronts.size(), 3u);
  for (const redesign::NamedFront& front : outcome.fronts) {
    SCOPED_TRACE(front.name);
    ASSERT_TRUE(front.moments && !front.points.empty());
    redesign::RedesignProblem problem_of = outcome.problem;
    problem_of.program = front.program;
    double off_nm = 0;
    for (const redesign::ParetoPoint& point : front.points)
      off_nm = std::max(
          off_nm, redesign::LargestDifferenceNm(redesign::ProfileOf(problem_of, outcome.moments->measured, point.point),
                                                front.moments->profile));
    EXPECT_NEAR(front.moments->off_nm, off_nm, 1e-9);
  }
  EXPECT_LT(outcome.fronts[0].moments->duration_s, 20);  // constant
}

// A file may have any number of rows from three on, at any percents, and moments are compared at the same ones.
TEST(BalancedProgram, MomentsOfAFileWithOtherRowsAreComparedAtTheMotionsPercents) {
  redesign::RedesignProblem problem = BalancedProblem();
  problem.body = nullptr;
  const auto profile_of = [](const std::vector<double>& percent, const std::vector<double>& knee_nm) {
    return problem::MakeLoadProfile(percent, std::vector<double>(percent.size(), 30), knee_nm, 1.5);
  };
  const auto four = profile_of({0, 40, 60, 100}, {NAN, 60, 40, 0});
  const auto point = redesign::StartPoint(problem, kPublishedLinks);
  const problem::LoadProfile along = redesign::ProfileOf(problem, four, point);
  ASSERT_EQ(along.samples.size(), problem.human.size());
  EXPECT_TRUE(std::isnan(along.samples[39].knee_nm));
  EXPECT_EQ(along.samples[40].knee_nm, 60);
  EXPECT_NEAR(along.samples[50].knee_nm, 50, 1e-9);
  EXPECT_NEAR(along.samples[80].knee_nm, 20, 1e-9);
  const auto three = redesign::ProfileOf(problem, profile_of({0, 50, 100}, {50, 50, 50}), point);
  EXPECT_NEAR(redesign::LargestDifferenceNm(along, three), 50, 1e-9);  // standing
  EXPECT_THROW(redesign::LargestDifferenceNm(along, four), std::logic_error);
}

TEST(AngleMismatch, IsALimitOfItsOwnWithAPrice) {
  redesign::RedesignProblem problem = BalancedProblem();
  problem.program.duration_s = 26;  // too short to follow exactly
  const auto free = Optimum(problem);
  ASSERT_TRUE(free);
  problem.max_angle_mismatch_deg = 0.7 * free->Predicted()->angle_mismatch_deg;
  const auto limited = Optimum(problem);
  ASSERT_TRUE(limited);
  EXPECT_NEAR(limited->Predicted()->angle_mismatch_deg, *problem.max_angle_mismatch_deg, 1e-4);
  EXPECT_LT(limited->Range_deg(), free->Range_deg());
  const auto multiplier = limited->local.MultiplierOf(synthesis::LimitId{"angle mismatch"});
  ASSERT_TRUE(multiplier);
  constexpr double kStep_deg = 0.02;
  const auto range = [&](double step_deg) {
    redesign::RedesignProblem near = problem;
    *near.max_angle_mismatch_deg += step_deg;
    return redesign::SolveFrom(near, limited->Point()).Range_deg();
  };
  EXPECT_NEAR((range(kStep_deg) - range(-kStep_deg)) / (2 * kStep_deg), *multiplier, 0.05 * *multiplier + 1e-3);
}

TEST(JointMisalignment, IsLimitedByThePlacementAloneAndTheAngleByItsOwnLimit) {
  redesign::RedesignProblem problem = BalancedProblem();
  for (redesign::HumanSample& sample : problem.human) sample.slip_mm = {12, -5};
  problem.fit_placement = true;
  problem.misalignment_of = MisalignmentOf::kJoint;
  problem.max_angle_mismatch_deg = 5;
  problem.max_misalignment_percent = 0.5;
  const auto solve = Optimum(problem);
  ASSERT_TRUE(solve);
  const redesign::Prediction& prediction = *solve->Predicted();
  EXPECT_NEAR(prediction.joint.mm, (solve->Point().placement_mm + Eigen::Vector2d(12, -5)).norm(), 1e-9);
  EXPECT_LE(100 * prediction.joint.relative, 0.5 * (1 + 1e-5));
  EXPECT_EQ(solve->Misalignment_percent(), 100 * prediction.joint.relative);
  EXPECT_LE(prediction.angle_mismatch_deg, 5 + 1e-4);
  EXPECT_GT(prediction.path.relative, prediction.joint.relative);  // pace is in it
}

TEST(JointMisalignment, AConstantProgramCannotFollowAndThatIsTold) {
  redesign::RedesignProblem problem = BalancedProblem();
  problem.program = {};
  problem.misalignment_of = MisalignmentOf::kJoint;
  problem.max_angle_mismatch_deg = 5;
  const auto report = redesign::ExplainInfeasible(problem, {problem.design.start, kPublishedLinks}, Starts(1));
  ASSERT_EQ(report.quantity, &redesign::kAngleMismatch);
  EXPECT_GT(*report.best, 5);
  EXPECT_THAT(report.sentence, HasSubstr("--program free"));
}

}  // namespace
}  // namespace lake
