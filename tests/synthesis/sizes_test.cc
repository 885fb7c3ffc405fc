// Several sizes for many people: who wears which, and the rule for the next person.
#include "lake/redesign/sizes.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "compare/closed_form.h"
#include "lake/core/error.h"
#include "lake/core/threads.h"
#include "synthesis/paper.h"

namespace lake {
namespace {

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
