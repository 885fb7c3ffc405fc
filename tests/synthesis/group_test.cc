// One design for many people against designs for each, other choices of whom to leave out, and its own limits.
#include "lake/redesign/group.h"

#include <gmock/gmock.h>

#include <map>
#include <set>

#include "central_differences.h"
#include "compare/closed_form.h"
#include "lake/core/error.h"
#include "lake/core/threads.h"
#include "lake/redesign/redesign_program.h"
#include "synthesis/paper.h"

namespace lake {
namespace {

using Kind = linkage::StrokeProgram::Kind;
using redesign::Across;
using testing::HasSubstr;

// A program of two thirds of the time that following the knee exactly takes, so that the limit costs range, differently
// for each.
redesign::GroupProblem SharedProblem(double limit_percent = 3) {
  redesign::GroupProblem problem;
  problem.shared.design = WithMargins(2);
  problem.shared.program.kind = Kind::kFree;
  problem.shared.program.duration_s = 22;
  problem.shared.fit_placement = true;
  problem.shared.max_misalignment_percent = limit_percent;
  return problem;
}

ClosedFormLeg Leg(double shank_mm, double seated_knee_deg) {
  ClosedFormLeg leg;
  leg.shank_mm = shank_mm;
  leg.thigh_mm = 0.95 * shank_mm;
  leg.seated_knee_deg = seated_knee_deg;
  return leg;
}

std::vector<redesign::PersonMeasured> People(const std::vector<ClosedFormLeg>& legs) {
  std::vector<redesign::PersonMeasured> people;
  for (const ClosedFormLeg& leg : legs) people.push_back({fmt::format("sub-{}", people.size() + 1), {MakeCurve(leg)}});
  return people;
}

const std::vector<ClosedFormLeg> kThree = {Leg(400, 88), Leg(420, 98), Leg(440, 92)};

redesign::GroupProblem WithPeople(redesign::GroupProblem problem, const std::vector<ClosedFormLeg>& legs) {
  for (const redesign::PersonMeasured& person : People(legs))
    problem.people.push_back({person.name, redesign::MakeHumanMotion(person.motion.human)});
  return problem;
}

redesign::RedesignBuilder BuilderOf(const redesign::GroupProblem& problem) {
  std::vector<redesign::RedesignPoint> points;
  for (std::size_t i = 0; i < problem.people.size(); ++i)
    points.push_back(redesign::StartPoint(problem.Of(i), kPublishedLinks));
  return {problem, points, std::vector(problem.people.size(), redesign::ConstantStart::kAtHumanAngle)};
}

// No term couples two people, so the blocks of the Jacobian and the Hessian are theirs, and each person adds as many
// variables, rows and terms as the one before: that is what makes the cost of a solve linear in people.
TEST(GroupProgram, PeopleShareNothingButTheLinks) {
  for (const Across across : {Across::kWorst, Across::kMean}) {
    std::vector<std::array<std::size_t, 3>> sizes;
    for (int count = 2; count <= 4; ++count) {
      redesign::GroupProblem problem = WithPeople(SharedProblem(), std::vector(count, kThree[0]));
      problem.across = across;
      problem.shared.penalty_deg_per_mm = 0.5;
      redesign::RedesignBuilder builder = BuilderOf(problem);
      const nlp::NonlinearProgram program = builder.Build({}).program;
      std::map<int, std::size_t> owner;
      for (std::size_t i = 0; i < builder.Variables().size(); ++i) {
        const redesign::RedesignVariables& variables = builder.Variables()[i];
        for (const int knot : variables.knots) owner[knot] = i;
        for (const int theta : variables.theta) owner[theta] = i;
        for (const int axis : variables.placement) owner[axis] = i;
        owner[variables.duration] = i;
      }
      for (const nlp::NlpTerm& term : program.Terms()) {
        std::set<std::size_t> owners;
        for (const int variable : term.term->Variables())
          if (owner.contains(variable)) owners.insert(owner[variable]);
        EXPECT_LE(owners.size(), 1u);
      }
      sizes.push_back({program.Variables().size(), program.Rows().size(), program.Terms().size()});
    }
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(sizes[2][k] - sizes[1][k], sizes[1][k] - sizes[0][k]);
  }
}

// Whatever names a row or a variable, such as a message, means one.
TEST(GroupProgram, NamesAreUnique) {
  redesign::GroupProblem problem = WithPeople(SharedProblem(), kThree);
  problem.shared.penalty_deg_per_mm = 0.5;
  for (const Across across : {Across::kWorst, Across::kMean}) {
    problem.across = across;
    redesign::RedesignBuilder builder = BuilderOf(problem);
    const nlp::NonlinearProgram program = builder.Build({}).program;
    std::set<std::string> rows, variables;
    for (const nlp::NlpRow& row : program.Rows()) EXPECT_TRUE(rows.insert(row.name).second) << row.name;
    for (const nlp::NlpVariable& variable : program.Variables())
      EXPECT_TRUE(variables.insert(variable.name).second) << variable.name;
  }
}

// The rows of a group mean what the closed form says of each person.
TEST(GroupProgram, RowsAgreeWithTheClosedForm) {
  redesign::GroupProblem problem = WithPeople(SharedProblem(), kThree);
  for (const Across across : {Across::kWorst, Across::kMean}) {
    problem.across = across;
    redesign::RedesignBuilder builder = BuilderOf(problem);
    const nlp::NonlinearProgram program = builder.Build({}).program;
    const std::vector<double> rows = program.RowValues(StartOf(program));
    double mean = 0;
    for (std::size_t i = 0; i < kThree.size(); ++i) {
      const double percent = 100 * redesign::PredictPoint(problem.Of(i), builder.Points()[i])->path.relative;
      mean += percent / static_cast<double>(kThree.size());
      const int row = builder.Variables()[i].misalignment_row;
      ASSERT_GE(row, 0);
      EXPECT_THAT(program.Rows()[row].name, HasSubstr(fmt::format("sub-{}: ", i + 1)));
      // m of the worst; m - r^2 of the mean, where r starts at its root.
      EXPECT_NEAR(rows[row], across == Across::kWorst ? percent * percent : 0, 1e-9);
    }
    for (std::size_t i = 0; i < rows.size(); ++i)
      if (program.Rows()[i].name.starts_with("mean misalignment")) {
        EXPECT_NEAR(rows[i], mean, 1e-9);
      }
  }
}

redesign::RedesignEnd DesignOf(const redesign::GroupProblem& problem, const synthesis::OptimizeOptions& options) {
  return redesign::DesignGroups({{.problem = problem, .links = {problem.shared.design.start}}}, options)
      .front()
      .nearest;
}

// Two who move alike need no compromise: the design is the one of either alone.
TEST(Group, ThatIsAllAlikeGetsTheDesignOfOne) {
  redesign::RedesignProblem alone = SharedProblem().shared;
  alone.human = redesign::MakeHumanMotion(MakeCurve(kThree[1]));
  const auto one = redesign::FindOptimum(alone, {alone.design.start}, Starts(2));
  ASSERT_TRUE(one);
  for (const Across across : {Across::kWorst, Across::kMean}) {
    redesign::GroupProblem problem = WithPeople(SharedProblem(), {kThree[1], kThree[1]});
    problem.across = across;
    const redesign::RedesignEnd design = DesignOf(problem, Starts(2));
    ASSERT_TRUE(design.is_usable);
    // Small costs are counted once for each person; they move a range by less than this.
    EXPECT_NEAR(design.objective, one->objective, 2e-3);
  }
}

// Once the starts of each were as many as those of the group that has the fewest.
TEST(Group, IsDesignedTheSameBesideAnother) {
  std::vector<ClosedFormLeg> legs;
  for (int i = 0; i < 20; ++i) legs.push_back(Leg(400 + 2 * i, 88 + i % 7));  // many enough to be thinned first
  redesign::DesignTask task{WithPeople(SharedProblem(), legs)};
  task.problem.shared.program.kind = Kind::kConstant;
  task.problem.shared.fit_placement = false;
  task.problem.shared.max_misalignment_percent.reset();
  task.problem.shared.program.duration_s.reset();
  for (const ClosedFormLeg& leg : legs) task.human.push_back(MakeCurve(leg));
  const linkage::Links& start = task.problem.shared.design.start;
  redesign::DesignTask other = task;
  task.links = {start, kPublishedLinks};
  other.links = {start};
  const redesign::GroupOutcome alone = redesign::DesignGroups({task}, Starts(4)).front();
  const redesign::GroupOutcome beside = redesign::DesignGroups({task, other}, Starts(4)).front();
  EXPECT_EQ(alone.starts, 2);
  EXPECT_EQ(beside.starts, alone.starts);
  EXPECT_EQ(beside.nearest.Links().Values(), alone.nearest.Links().Values());
}

class GroupOfThree : public testing::Test {
 protected:
  static redesign::GroupOutcome Solve(Across across, double quantile = 1, double limit_percent = 3) {
    redesign::GroupProblem problem = SharedProblem(limit_percent);
    problem.across = across;
    problem.quantile = quantile;
    return redesign::RunGroup(problem, People(kThree), Starts(2));
  }

  // With three threads.
  static const redesign::GroupOutcome& Worst() {
    static const redesign::GroupOutcome outcome = [] {
      const int threads = Threads();
      SetThreads(3);
      redesign::GroupOutcome worst = Solve(Across::kWorst);
      SetThreads(threads);
      return worst;
    }();
    return outcome;
  }
};

// The limit holds for each by the comparison's own code, and someone is at it; nobody's own design is worse for them.
TEST_F(GroupOfThree, HoldsTheLimitForEachAndCostsEachSomething) {
  const redesign::GroupOutcome& outcome = Worst();
  ASSERT_TRUE(outcome.IsSolved()) << outcome.reason;
  EXPECT_TRUE(outcome.evaluation.IsFeasible());
  double largest = 0, largest_cost = 0;
  for (const redesign::PersonOutcome& person : outcome.people) {
    ASSERT_TRUE(person.with_group.misalignment);
    EXPECT_EQ(person.with_group.design.links.Values(), outcome.people[0].with_group.design.links.Values());
    largest = std::max(largest, 100 * person.with_group.misalignment->metrics.relative_rms);
    EXPECT_LE(person.with_group.duration_s, 22 * (1 + 1e-6));
    ASSERT_TRUE(person.cost_deg);
    EXPECT_GE(*person.cost_deg, -2e-3);  // small costs, see above
    largest_cost = std::max(largest_cost, *person.cost_deg);
  }
  EXPECT_NEAR(largest, 3, 3e-4);
  EXPECT_GT(largest_cost, 0.1);
}

// Who has no pull may go, and the links stay where they are; who has one may not.
TEST_F(GroupOfThree, WithoutWhoeverHasNoPullTheLinksAreTheSame) {
  redesign::GroupProblem problem = WithPeople(SharedProblem(), {kThree[1], Leg(420, 80)});
  const std::vector<redesign::RedesignPoint> start = DesignOf(problem, Starts(1)).points;
  const redesign::RedesignSolve both = redesign::SolveFrom(problem, start, {}, true);
  ASSERT_TRUE(both.IsUsable());
  EXPECT_GT(both.pulls[0], 0.1);
  EXPECT_LT(both.pulls[1], 1e-3);
  problem.people.pop_back();
  const redesign::RedesignSolve alone = redesign::SolveFrom(problem, {both.points[0]}, {}, true);
  ASSERT_TRUE(alone.IsUsable());
  // Small costs are each person's too.
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_NEAR(alone.points[0].links.Values()[i], both.points[0].links.Values()[i], 0.05);
  EXPECT_NEAR(alone.Range_deg(), both.Range_deg(), 2e-3);
}

// The mean is at its limit, and someone above it.
TEST_F(GroupOfThree, TheMeanIsHeldWhereOneIsAsked) {
  const redesign::GroupOutcome outcome = Solve(Across::kMean, 1, 2);
  ASSERT_TRUE(outcome.IsSolved()) << outcome.reason;
  double sum = 0, largest = 0;
  for (const redesign::PersonOutcome& person : outcome.people) {
    const double percent = 100 * person.with_group.misalignment->metrics.relative_rms;
    sum += percent / 3;
    largest = std::max(largest, percent);
  }
  EXPECT_NEAR(sum, 2, 2e-4);
  EXPECT_GT(largest, 2.1);
  EXPECT_NEAR(outcome.Misalignment_percent(), sum, 1e-9);
}

// Of three one may be left out: the best choice among all is found.
TEST_F(GroupOfThree, TheQuantileLeavesOutWhoCostsMost) {
  const redesign::GroupOutcome outcome = Solve(Across::kQuantile, 0.66);
  ASSERT_TRUE(outcome.IsSolved());
  double best = 0;
  std::size_t left_out = 0;
  for (std::size_t i = 0; i < kThree.size(); ++i) {
    redesign::GroupProblem problem = WithPeople(SharedProblem(), kThree);
    problem.people[i].counts = false;
    const redesign::RedesignEnd design = DesignOf(problem, Starts(2));
    if (design.is_usable && design.objective > best) best = design.objective, left_out = i;
  }
  EXPECT_NEAR(outcome.nearest.objective, best, 2e-3);
  for (std::size_t i = 0; i < kThree.size(); ++i) EXPECT_EQ(outcome.people[i].counts, i != left_out);
}

TEST_F(GroupOfThree, WhatCannotBeHeldIsSaidWithTheNames) {
  const redesign::GroupOutcome outcome = Solve(Across::kWorst, 1, 0.02);
  ASSERT_FALSE(outcome.IsSolved());
  EXPECT_THAT(outcome.reason, HasSubstr("no design for 3 people keeps the worst misalignment within 0.02 %"));
  EXPECT_THAT(outcome.reason, HasSubstr("sub-"));
  EXPECT_GT(outcome.Misalignment_percent(), 0.02);
}

TEST_F(GroupOfThree, IsTheSameForAnyNumberOfThreads) {
  const int threads = Threads();
  SetThreads(1);
  const redesign::GroupOutcome one = Solve(Across::kWorst);
  SetThreads(threads);
  EXPECT_EQ(one.nearest.Links().Values(), Worst().nearest.Links().Values());
  for (std::size_t i = 0; i < kThree.size(); ++i) {
    ASSERT_TRUE(one.people[i].own && Worst().people[i].own);
    EXPECT_EQ(one.people[i].own->design.links.Values(), Worst().people[i].own->design.links.Values());
  }
}

TEST(GroupOptions, ClearancesAreOnePersons) {
  redesign::GroupProblem problem = WithPeople(SharedProblem(), {kThree[0], kThree[1]});
  problem.shared.design.clearances.seat_mm = 5;
  EXPECT_THAT([&] { problem.Check(); },
              testing::ThrowsMessage<Error>(testing::HasSubstr("omit them in a design for 2")));
}

TEST(GroupOptions, AQuantileIsAPart) {
  redesign::GroupProblem problem = WithPeople(SharedProblem(), std::vector(10, kThree[0]));
  problem.across = Across::kQuantile;
  problem.quantile = 0.9;
  EXPECT_EQ(problem.Counting(), 9u);
  problem.quantile = 0;
  EXPECT_THROW(problem.CheckOptions(), UsageError);
}

}  // namespace
}  // namespace lake
