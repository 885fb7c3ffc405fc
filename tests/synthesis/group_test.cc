// One design for many people against designs for each, other choices of whom to leave out, and its own limits.
#include "lake/redesign/group.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "central_differences.h"
#include "compare/closed_form.h"
#include "lake/core/error.h"
#include "lake/core/threads.h"
#include "lake/redesign/redesign_program.h"
#include "lake/redesign/sizes.h"
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

// Several sizes for many people: who wears which, and the rule for the next person.

using redesign::BodyQuantity;
using testing::ElementsAre;

// Losses of people who each lose nothing in their own size and 1 degree in any other.
std::vector<std::vector<double>> LossesFor(const std::vector<std::size_t>& own, std::size_t sizes) {
  std::vector<std::vector<double>> losses;
  for (const std::size_t size : own) {
    losses.emplace_back(sizes, 1.0);
    losses.back()[size] = 0;
  }
  return losses;
}

TEST(SizeRule, CutsWhereTheLossIsLeast) {
  const std::vector<BodyQuantity> quantities = {{"height_mm", {1500, 1900, 1600, 1700, 1800, 1650}},
                                                {"leg_mm", {800, 801, 802, 803, 804, 805}}};
  // By height: sizes 1 1 1 0 0 2, if it were not for one person in the middle.
  const auto losses = LossesFor({1, 2, 1, 0, 0, 1}, 3);
  const redesign::SizeRule rule = redesign::FindRule(quantities, losses, {0, 1, 2, 3, 4, 5});
  EXPECT_EQ(rule.quantity, "height_mm");
  EXPECT_EQ(rule.loss_deg, 0);
  ASSERT_EQ(rule.ranges.size(), 3u);
  EXPECT_EQ(rule.ranges[0].to_mm, 1675);
  EXPECT_EQ(rule.ranges[1].from_mm, 1675);
  EXPECT_EQ(rule.ranges[1].to_mm, 1850);
  EXPECT_EQ(rule.SizeFor(1400), 1u);
  EXPECT_EQ(rule.SizeFor(1675), 1u);
  EXPECT_EQ(rule.SizeFor(1676), 0u);
  EXPECT_EQ(rule.SizeFor(2300), 2u);
}

// Against all rules of two sizes: every cut, either order, and no cut at all.
TEST(SizeRule, IsTheBestOfAllRules) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int sample = 0; sample < 50; ++sample) {
    BodyQuantity quantity{"leg_mm", {}};
    std::vector<std::vector<double>> losses;
    std::vector<std::size_t> people;
    for (std::size_t i = 0; i < 7; ++i) {
      quantity.mm.push_back(std::floor(5 * unit(random)));  // with ties, which no rule can tell apart
      losses.push_back({unit(random), unit(random)});
      people.push_back(i);
    }
    double best = std::numeric_limits<double>::infinity();
    for (double cut = -0.5; cut <= 5; ++cut)
      for (const std::size_t low : {0u, 1u}) {
        double loss = 0;
        for (const std::size_t i : people) loss += losses[i][quantity.mm[i] < cut ? low : 1 - low];
        best = std::min(best, loss / 7);
      }
    const redesign::SizeRule rule = redesign::FindRule({quantity}, losses, people);
    EXPECT_NEAR(rule.loss_deg, best, 1e-12);
    double said = 0;
    for (const std::size_t i : people) said += losses[i][rule.SizeFor(quantity.mm[i])];
    EXPECT_NEAR(said / 7, best, 1e-12);
  }
}

redesign::RedesignProblem WithoutMargins() {
  redesign::RedesignProblem problem;
  problem.program.kind = linkage::StrokeProgram::Kind::kFree;
  problem.program.duration_s = 25;
  problem.fit_placement = true;
  problem.max_misalignment_percent = 2;
  return problem;
}

// The largest range is where a triangle is flat, which a solve finds to some 1e-9 mm: who can wear that linkage is told
// so however far they bend.
TEST(Fit, OfALinkageThatIsFlatAtItsEndIsFound) {
  redesign::RedesignProblem problem = WithoutMargins();
  const linkage::Links widest = synthesis::SolveFrom(problem.design, problem.design.start).end;
  double before_percent = 0;
  for (const double seated_deg : {88.0, 92.0, 96.0, 100.0}) {
    ClosedFormLeg leg;
    leg.seated_knee_deg = seated_deg;
    problem.human = redesign::Thinned(redesign::MakeHumanMotion(MakeCurve(leg)), 5);
    const redesign::Fit fit = redesign::FitOf(problem, widest, {});
    EXPECT_LT(fit.percent, 3) << seated_deg;  // 25 s are enough to follow nearly all of the motion
    EXPECT_GT(fit.percent, before_percent) << seated_deg;
    EXPECT_EQ(fit.holds, fit.percent <= 2) << seated_deg;
    before_percent = fit.percent;
  }
}

// Without margins multipliers are not unique, and of noisy motions most solves stall at 1e-8 deg where all starts meet.
TEST(Fit, DesignsWithoutMarginsAreFoundWhereAllStartsMeet) {
  redesign::RedesignProblem problem = WithoutMargins();
  const linkage::Links widest = synthesis::SolveFrom(problem.design, problem.design.start).end;
  ClosedFormLeg leg;
  leg.seated_knee_deg = 100;
  leg.shank_mm = 400;
  int stalled = 0;
  for (const unsigned seed : {1u, 2u, 3u}) {
    compare::StsCurve curve = MakeCurve(leg);
    std::mt19937 random(seed);
    AddNoise(curve, 0.5 * seed, random);
    problem.human = redesign::Thinned(redesign::MakeHumanMotion(curve), 2);
    std::vector<double> ranges_deg;
    for (const linkage::Links& start : {widest, problem.design.start}) {
      const redesign::RedesignSolve solve = SolveFrom(problem, StartPoint(problem, start));
      if (!solve.IsUsable()) {
        ++stalled;
        continue;
      }
      EXPECT_LE(solve.local.solution.violation, 1e-7);
      ranges_deg.push_back(solve.Range_deg());
    }
    // Two starts tell an optimum from where a solve stalled; the gradient does not, as Ipopt's tolerance on it grows
    // with the multipliers. The ranges were within 2e-6 deg.
    if (ranges_deg.size() == 2) {
      EXPECT_NEAR(ranges_deg[0], ranges_deg[1], 1e-5);
    }
  }
  EXPECT_LE(stalled, 1) << "of six; none with Ipopt 3.14.11, one with 3.14.17";
}

// No other size is better for a person than theirs, but for what a solve is within.
void ExpectWearsTheBest(redesign::GroupProblem problem, const std::vector<redesign::PersonMeasured>& people,
                        const redesign::SizesOutcome& outcome, std::size_t person,
                        const synthesis::OptimizeOptions& options) {
  const redesign::RedesignProblem own = redesign::PutMotionInto(problem.shared, people[person].motion).problem;
  std::vector<double> values;
  for (const redesign::GroupOutcome& size : outcome.sizes)
    values.push_back(redesign::FitOf(own, size.nearest.Links(), options).value);
  EXPECT_GE(values[outcome.size_of[person]], *std::ranges::max_element(values) - 0.02);
}

redesign::SizesOutcome WithThreads(int threads, const redesign::GroupProblem& problem,
                                   const std::vector<redesign::PersonMeasured>& people,
                                   const synthesis::OptimizeOptions& options) {
  const int before = Threads();
  SetThreads(threads);
  redesign::SizesOutcome outcome = redesign::RunSizes(problem, people, 2, {}, options);
  SetThreads(before);
  return outcome;
}

// Short people who bend far, and tall ones who do not: the sizes are theirs, better than one for all, and whoever is
// left out gets their own by the length of the leg.
TEST(Sizes, FindTwoKindsOfPeopleAndTheRuleBetweenThem) {
  redesign::GroupProblem problem;
  problem.shared.design = WithMargins(2);
  problem.shared.program.kind = linkage::StrokeProgram::Kind::kFree;
  problem.shared.program.duration_s = 22;
  problem.shared.fit_placement = true;
  problem.shared.max_misalignment_percent = 2.5;
  const synthesis::OptimizeOptions options = Starts(1);
  std::vector<redesign::PersonMeasured> people;
  for (const auto& [shank_mm, seated_deg] : {std::pair{390.0, 98.0}, {450.0, 86.0}, {395.0, 97.0}, {455.0, 85.0}}) {
    ClosedFormLeg leg;
    leg.shank_mm = shank_mm;
    leg.thigh_mm = 0.95 * shank_mm;
    leg.seated_knee_deg = seated_deg;
    people.push_back({fmt::format("sub-{}", people.size() + 1), {MakeCurve(leg)}});
  }
  const redesign::SizesOutcome outcome = WithThreads(2, problem, people, options);
  ASSERT_TRUE(outcome.IsSolved()) << outcome.Reason();
  EXPECT_THAT(outcome.size_of, ElementsAre(0, 1, 0, 1));
  EXPECT_TRUE(outcome.is_settled);
  for (std::size_t i = 0; i < 4; ++i) ExpectWearsTheBest(problem, people, outcome, i, options);
  EXPECT_GT(outcome.sizes[1].evaluation.range_deg, outcome.sizes[0].evaluation.range_deg + 0.5);
  for (const redesign::GroupOutcome& size : outcome.sizes) EXPECT_LE(size.Misalignment_percent(), 2.5 * (1 + 1e-4));
  EXPECT_EQ(outcome.rule.quantity, "leg_mm");
  ASSERT_EQ(outcome.left_out.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(outcome.left_out[i].size, outcome.size_of[i]);
  // Who is left out and bends the farthest may be a little beyond what the others' size allows; the others hold.
  EXPECT_TRUE(outcome.left_out[2].fit.holds);
  EXPECT_TRUE(outcome.left_out[3].fit.holds);

  const redesign::SizesOutcome one_thread = WithThreads(1, problem, people, options);
  EXPECT_EQ(one_thread.size_of, outcome.size_of);
  for (std::size_t k = 0; k < 2; ++k)
    EXPECT_EQ(one_thread.sizes[k].nearest.Links().Values(), outcome.sizes[k].nearest.Links().Values());
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(one_thread.left_out[i].fit.percent, outcome.left_out[i].fit.percent);
}

}  // namespace
}  // namespace lake
