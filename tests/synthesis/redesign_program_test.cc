// The program that a redesign builds: its derivatives, and that its rows mean what the closed form says.
#include "lake/redesign/redesign_program.h"

#include <gmock/gmock.h>

#include <random>

#include "central_differences.h"
#include "compare/closed_form.h"
#include "synthesis/paper.h"

namespace lake {
namespace {

using Goal = redesign::RedesignProblem::Goal;
using Kind = linkage::StrokeProgram::Kind;

redesign::RedesignProblem Problem(Kind kind, Goal goal) {
  redesign::RedesignProblem problem;
  problem.design = WithMargins(1);
  problem.human = redesign::MakeHumanMotion(MakeCurve({}));
  problem.program.kind = kind;
  problem.goal = goal;
  problem.max_misalignment_percent = 5;
  problem.penalty_deg_per_mm = 0.3;
  problem.fit_placement = true;
  return problem;
}

// The same with what a person limits: the knee angle, and balance.
redesign::RedesignProblem Balanced(Kind kind, Goal goal) {
  redesign::RedesignProblem problem = Problem(kind, goal);
  problem.max_angle_mismatch_deg = 20;
  loads::BodyPath body;
  body.body.foot = {1.0, 0.06, 0.12};
  body.body.shank = {3.3, 0.18, 0.13};
  body.body.thigh = {7.0, 0.17, 0.13};
  body.body.trunk = {23.7, 0.32, 0.25};
  body.body.sole = {0.066, 0.2};
  body.body.ankle_height_m = 0.07;
  body.feet_from_percent = 40;
  for (int i = 0; i < compare::kPercentSamples; ++i) body.trunk.push_back({0.5 - 0.005 * i, {0.1, 0.3}});
  problem.body = std::make_shared<const loads::BodyPath>(body);
  problem.balance_mm = 20;
  return problem;
}

nlp::NonlinearProgram Build(const redesign::RedesignProblem& problem, const redesign::RedesignPoint& point) {
  return redesign::RedesignBuilder(problem, point, redesign::ConstantStart::kAtHumanAngle).Build({}).program;
}

// Gradients against differences of values, Hessians against differences of gradients, term by term.
TEST(RedesignProgram, DerivativesAreThoseOfTheValues) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<redesign::RedesignProblem> problems;
  for (const Kind kind : {Kind::kConstant, Kind::kFree})
    for (const Goal goal : {Goal::kRange, Goal::kMisalignment, Goal::kDuration})
      problems.push_back(Problem(kind, goal));
  for (const Goal goal : {Goal::kRange, Goal::kBalance, Goal::kAngle}) problems.push_back(Balanced(Kind::kFree, goal));
  problems.push_back(Balanced(Kind::kConstant, Goal::kRange));
  problems.back().misalignment_of = redesign::MisalignmentOf::kJoint;
  for (const Goal goal : {Goal::kRange, Goal::kCuffForce}) {
    problems.push_back(Problem(Kind::kFree, goal));
    problems.back().max_cuff_force_n = 12;
    problems.back().cuff_penalty_deg_per_n = 0.2;
    problems.back().cuffs.shank.push_back({90, 40});
    problems.back().human.back().slip_mm = {7, -4};
  }
  for (const redesign::RedesignProblem& problem : problems) {
    const nlp::NonlinearProgram program = Build(problem, redesign::StartPoint(problem, kPublishedLinks));
    std::vector<double> x = StartOf(program);
    for (double& value : x) value += 0.05 * unit(random);
    // Of a central difference: its truncation and the rounding of values up to a few hundred.
    for (const nlp::NlpTerm& term : program.Terms()) EXPECT_EQ(WrongDerivatives(*term.term, x, 1e-5), "");
  }
}

// At a point where the linkage follows its program the loops close and the cost is the printed one.
TEST(RedesignProgram, RowsAndCostAgreeWithTheClosedForm) {
  for (const Kind kind : {Kind::kConstant, Kind::kFree}) {
    redesign::RedesignProblem problem = Problem(kind, Goal::kRange);
    problem.program.duration_s = 30;
    redesign::RedesignPoint point = redesign::StartPoint(problem, kPublishedLinks);
    point.placement_mm = {9, -4};
    const nlp::NonlinearProgram nlp = Build(problem, point);
    const std::vector<double> x = StartOf(nlp);
    const std::vector<double> rows = nlp.RowValues(x);
    const auto prediction = redesign::PredictPoint(problem, point);
    ASSERT_TRUE(prediction);
    int loops = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const std::string& name = nlp.Rows()[i].name;
      if (name.find("loop") != std::string::npos) {
        EXPECT_NEAR(rows[i], 0, 1e-9) << name;
        ++loops;
      } else if (name.starts_with("misalignment")) {
        EXPECT_NEAR(std::sqrt(rows[i]), 100 * prediction->path.relative, 1e-9);
      }
    }
    EXPECT_EQ(loops, 2 * (compare::kPercentSamples + 1));
    const double range_deg = DegreesFromRadians(linkage::SolvePose(kPublishedLinks, 242)->theta_rad);
    // The small costs: 1e-5 of some tens of percent^2, 1e-6 of seconds.
    EXPECT_NEAR(nlp.Cost(x), -range_deg + 0.3 * prediction->path.mm, 2e-3);
  }
}

TEST(RedesignProgram, PointsSurviveTheProgram) {
  const redesign::RedesignProblem problem = Problem(Kind::kFree, Goal::kRange);
  const redesign::RedesignPoint point = redesign::StartPoint(problem, kPublishedLinks);
  redesign::RedesignBuilder builder(problem, point, redesign::ConstantStart::kAtHumanAngle);
  const nlp::NonlinearProgram program = builder.Build({}).program;
  builder.MoveTo(StartOf(program));
  const redesign::RedesignPoint again = builder.Point();
  EXPECT_EQ(again.links.Values(), point.links.Values());
  EXPECT_EQ(again.knots_mm, point.knots_mm);
  EXPECT_EQ(again.duration_s, point.duration_s);
}

TEST(RedesignProgram, KnotsSpanTheMotion) {
  EXPECT_EQ(redesign::SpanOf(21, 0).from, 0u);
  EXPECT_EQ(redesign::SpanOf(21, 0).weight, 0);
  EXPECT_EQ(redesign::SpanOf(21, 100).from, 19u);
  EXPECT_NEAR(redesign::SpanOf(21, 100).weight, 1, 1e-12);
  EXPECT_EQ(redesign::SpanOf(2, 30).from, 0u);
  EXPECT_NEAR(redesign::SpanOf(2, 30).weight, 0.3, 1e-12);
}

}  // namespace
}  // namespace lake
