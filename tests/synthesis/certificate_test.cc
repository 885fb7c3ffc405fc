#include "lake/certificate/certificate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "lake/certificate/interval.h"
#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/problem/problem_file.h"
#include "lake/synthesis/optimize.h"
#include "paper.h"
#include "places.h"
#include "random_problem.h"
#include "relaxation.h"

namespace lake {
namespace {

constexpr double kSupremum_deg = 170.53767779197486;  // 180 - atan(50 / 300)

TEST(Certificate, ProvesThePapersProblem) {
  const double range =
      synthesis::SolveFrom(problem::SynthesisProblem{}, problem::SynthesisProblem{}.start).evaluation.range_deg;
  const certificate::Certificate certificate = certificate::CertifyRange(problem::SynthesisProblem{}, range);
  EXPECT_TRUE(certificate.reached);
  EXPECT_LE(certificate.upper_bound_deg - range, 0.1);
  EXPECT_GE(certificate.upper_bound_deg, kSupremum_deg - 1e-9);
  EXPECT_NEAR(180 - DegreesFromRadians(std::atan(50.0 / 300.0)), kSupremum_deg, 1e-12);
  EXPECT_EQ(certificate.boxes, 1);  // nothing needs to be split: README
}

TEST(Certificate, ProvesTheOptimaWithMargins) {
  for (const double margin : {1.0, 2.0, 5.0, 10.0, 15.0, 20.0}) {
    const problem::SynthesisProblem problem = WithMargins(margin);
    const synthesis::LocalSolve best = synthesis::SolveFrom(problem, problem.start);
    ASSERT_TRUE(best.IsUsable()) << margin;
    const certificate::Certificate certificate = certificate::CertifyRange(problem, best.evaluation.range_deg);
    EXPECT_TRUE(certificate.reached) << margin;
    EXPECT_LE(certificate.gap_deg, 0.1) << margin;
    EXPECT_GE(certificate.gap_deg, -1e-9) << margin;
  }
}

TEST(Certificate, SmallerGapsAreReachedToo) {
  const problem::SynthesisProblem problem = WithMargins(2);
  const double range = synthesis::SolveFrom(problem, problem.start).evaluation.range_deg;
  certificate::CertificateOptions options;
  options.gap_deg = 1e-4;
  const certificate::Certificate certificate = certificate::CertifyRange(problem, range, options);
  EXPECT_TRUE(certificate.reached) << certificate.boxes;
  EXPECT_LE(certificate.gap_deg, 1e-4);
}

// A design within the bounds; most are not feasible.
linkage::Links RandomWithin(const std::array<certificate::Interval, 6>& bounds, std::mt19937_64& random) {
  std::array<double, 6> values{};
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] =
        bounds[i].lower + (bounds[i].upper - bounds[i].lower) * std::uniform_real_distribution(0.0, 1.0)(random);
  return linkage::Links::FromValues(values);
}

std::array<certificate::Interval, 6> BoundsOf(const problem::SynthesisProblem& problem) {
  std::array<certificate::Interval, 6> bounds;
  for (std::size_t i = 0; i < bounds.size(); ++i) bounds[i] = {problem.bounds[i].lower, problem.bounds[i].upper};
  return bounds;
}

double RangeOf(const linkage::Links& links, const problem::SynthesisProblem& problem) {
  return DegreesFromRadians(linkage::SolvePose(links, problem.d_min_mm)->theta_rad);
}

// Feasible designs of a problem, of `samples` drawn.
std::vector<linkage::Links> FeasibleSamples(const problem::SynthesisProblem& problem, int samples,
                                            std::mt19937_64& random) {
  const auto requirements = problem::RequirementsOf(problem);
  std::vector<linkage::Links> feasible;
  for (int sample = 0; sample < samples; ++sample) {
    const linkage::Links links = RandomWithin(BoundsOf(problem), random);
    if (problem::MeetsLinkRequirements(links, problem, requirements)) feasible.push_back(links);
  }
  return feasible;
}

// Rounding of the closed form that the samples are evaluated with, which is not verified arithmetic.
constexpr double kRounding_deg = 1e-9;

// The bound of a box without any branching must hold for every feasible design in it, whatever the bounds and margins.
TEST(Certificate, NoFeasibleDesignOfRandomProblemsExceedsTheBound) {
  std::mt19937_64 random(20260101);
  certificate::CertificateOptions unbranched;
  unbranched.max_boxes = 1;
  int problems = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    const problem::SynthesisProblem problem = RandomProblem(random);
    const certificate::Certificate root = certificate::CertifyRange(problem, std::nullopt, unbranched);
    ASSERT_EQ(root.boxes, 1);
    const std::vector<linkage::Links> feasible = FeasibleSamples(problem, 200, random);
    for (const linkage::Links& links : feasible)
      ASSERT_LE(RangeOf(links, problem), root.upper_bound_deg + kRounding_deg) << "trial " << trial;
    problems += !feasible.empty();
  }
  EXPECT_GT(problems, 200);  // the test has seen enough feasible designs to mean something
}

// Contraction removes no feasible design, and the bound of what it leaves holds: on boxes of every size, down to single
// designs, around feasible ones.
TEST(Certificate, ContractionLosesNoFeasibleDesign) {
  std::mt19937_64 random(20260303);
  int contracted = 0, kept = 0;
  for (int trial = 0; trial < 1500; ++trial) {
    const problem::SynthesisProblem problem = RandomProblem(random);
    const auto requirements = problem::RequirementsOf(problem);
    const certificate::RangeBound range(problem);
    for (const linkage::Links& centre : FeasibleSamples(problem, 50, random)) {
      const double size = std::pow(10.0, std::uniform_real_distribution(-6.0, 1.5)(random)) * (random() % 8 > 0);
      certificate::LinkBox box;
      for (std::size_t i = 0; i < box.size(); ++i) {
        const double fixed = random() % 4 > 0, share = std::uniform_real_distribution(0.0, 1.0)(random);
        const double at = centre.Values()[i];
        box[i] = {std::max(problem.bounds[i].lower, at - fixed * size * share),
                  std::min(problem.bounds[i].upper, at + fixed * size * (1 - share))};
      }
      certificate::LinkBox left = box;
      ASSERT_TRUE(range.Contract(left)) << "trial " << trial;
      const double bound_deg = DegreesFromRadians(range.UpperBound(left));
      for (int sample = 0; sample < 20; ++sample) {
        const linkage::Links links = sample == 0 ? centre : RandomWithin(box, random);
        if (!problem::MeetsLinkRequirements(links, problem, requirements)) continue;
        for (std::size_t i = 0; i < left.size(); ++i)
          ASSERT_TRUE(left[i].Contains(links.Values()[i])) << problem::LinkName(i) << ", trial " << trial;
        ASSERT_LE(RangeOf(links, problem), bound_deg + kRounding_deg) << "trial " << trial;
        ++kept;
      }
      for (std::size_t i = 0; i < left.size(); ++i) contracted += left[i].Width() < 0.99 * box[i].Width();
    }
  }
  EXPECT_GT(kept, 10000);
  EXPECT_GT(contracted, 100);
}

// What the relaxation removes of a box has less than the floor or violates a requirement, and its bound holds for what
// it leaves: on boxes of every size around designs that satisfy problems with limits over the used range, on the seat
// and on strength, which are loose enough for random designs to hold them.
problem::SynthesisProblem RandomUsedProblem(std::mt19937_64& random) {
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  const auto sometimes = [&](double low, double high) {
    return random() % 2 ? std::optional(uniform(low, high)) : std::nullopt;
  };
  problem::SynthesisProblem problem;
  problem.grashof_margin_mm = sometimes(0.2, 5).value_or(0);
  problem.singularity_margin_mm = sometimes(0.2, 5).value_or(0);
  problem.standing_deg = uniform(2, 20);
  problem.limits["max_force_n"] = sometimes(1500, 6000);
  problem.limits["min_moment_arm_mm"] = sometimes(1, 15);
  problem.limits["min_transmission_deg"] = sometimes(3, 15);
  problem.limits["d_max_mm"] = sometimes(340, 400);
  problem.limits["max_pin_force_n"] = sometimes(3000, 9000);
  problem.limits["max_mount_force_n"] = sometimes(1500, 6000);
  problem.limits["safety_factor"] = sometimes(0.3, 1.5);
  problem.clearances.seat_mm = sometimes(0, 5);
  problem.clearances.placement_mm = {uniform(-10, 10), uniform(-10, 10)};
  return problem;
}

// Designs that satisfy the problem: random ones, and such between them and its optimum, where cuts are deepest.
std::vector<linkage::Links> DesignsUpToTheOptimum(const problem::SynthesisProblem& problem, std::mt19937_64& random) {
  std::vector<linkage::Links> designs;
  const std::vector<linkage::Links> samples = FeasibleSamples(problem, 60, random);
  if (samples.empty()) return designs;
  const synthesis::LocalSolve best = synthesis::SolveFrom(problem, problem.start);
  for (const linkage::Links& sample : samples) {
    const double share = best.IsUsable() ? std::pow(10.0, std::uniform_real_distribution(-6.0, 0.0)(random)) : 1;
    std::array<double, 6> values{};
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = std::lerp(best.end.Values()[i], sample.Values()[i], share);
    const linkage::Links links = share < 1 ? linkage::Links::FromValues(values) : sample;
    if (problem::IsFeasible(links, problem, 0)) designs.push_back(links);
  }
  return designs;
}

TEST(Certificate, TheRelaxationLosesNoDesignThatIsBetter) {
  std::mt19937_64 random(20260707);
  int kept = 0, contracted = 0, lowered = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const problem::SynthesisProblem problem = trial % 4 == 0 ? RandomProblem(random) : RandomUsedProblem(random);
    const certificate::RangeBound range(problem);
    for (const linkage::Links& centre : DesignsUpToTheOptimum(problem, random)) {
      const double centre_rad = RadiansFromDegrees(RangeOf(centre, problem));
      // The floor is now far below, now so near that only a sliver is left, now absent.
      const double below_rad = std::pow(10.0, std::uniform_real_distribution(-5.0, 0.0)(random));
      const double floor_rad = random() % 6 ? centre_rad - below_rad : -kInfinity;
      const certificate::Relaxation relaxation(problem, range, floor_rad);
      const double size = std::pow(10.0, std::uniform_real_distribution(-5.0, 1.5)(random));
      certificate::LinkBox box;
      for (std::size_t i = 0; i < box.size(); ++i) {
        const double share = std::uniform_real_distribution(0.0, 1.0)(random), at = centre.Values()[i];
        box[i] = {std::max(problem.bounds[i].lower, at - size * share),
                  std::min(problem.bounds[i].upper, at + size * (1 - share))};
      }
      const auto result = relaxation.Examine(box);
      ASSERT_TRUE(result) << "trial " << trial;
      const double bound_deg = DegreesFromRadians(result->bound_rad);
      lowered += result->bound_rad < range.UpperBound(box) - 1e-9;
      for (std::size_t i = 0; i < box.size(); ++i) contracted += result->box[i].Width() < 0.99 * box[i].Width();
      for (int sample = 0; sample < 20; ++sample) {
        const linkage::Links links = sample == 0 ? centre : RandomWithin(box, random);
        if (sample > 0 && !problem::IsFeasible(links, problem, 0)) continue;
        if (RadiansFromDegrees(RangeOf(links, problem)) < floor_rad) continue;
        for (std::size_t i = 0; i < box.size(); ++i)
          ASSERT_TRUE(result->box[i].Contains(links.Values()[i])) << problem::LinkName(i) << ", trial " << trial;
        ASSERT_LE(RangeOf(links, problem), bound_deg + kRounding_deg) << "trial " << trial;
        ++kept;
      }
    }
  }
  EXPECT_GT(kept, 1000);
  EXPECT_GT(contracted, 200);
  EXPECT_GT(lowered, 100);
}

// Splitting: as no range is known, boxes are split to the end of the budget. The bound falls with the budget, never
// below a feasible design.
TEST(Certificate, NoFeasibleDesignExceedsTheBoundHoweverFarBoxesAreSplit) {
  std::mt19937_64 random(20260404);
  int problems = 0, fell = 0;
  for (int trial = 0; trial < 150; ++trial) {
    const problem::SynthesisProblem problem = RandomProblem(random);
    const std::vector<linkage::Links> feasible = FeasibleSamples(problem, 500, random);
    if (feasible.empty()) continue;
    ++problems;
    double last = 180 + kRounding_deg;
    for (const std::int64_t boxes : {1, 30, 300}) {
      certificate::CertificateOptions options;
      options.max_boxes = boxes;
      const certificate::Certificate certificate = certificate::CertifyRange(problem, std::nullopt, options);
      EXPECT_LE(certificate.boxes, boxes);
      EXPECT_FALSE(certificate.reached);
      EXPECT_TRUE(std::isnan(certificate.gap_deg));
      fell += certificate.upper_bound_deg < last && boxes > 1;
      EXPECT_LE(certificate.upper_bound_deg, last);
      last = certificate.upper_bound_deg;
      for (const linkage::Links& links : feasible)
        ASSERT_LE(RangeOf(links, problem), certificate.upper_bound_deg + kRounding_deg) << "trial " << trial;
    }
  }
  EXPECT_GT(problems, 10);
  EXPECT_GT(fell, problems);
}

// A range far below the optimum only makes the search longer: the bound comes down to the optimum and stays above it.
TEST(Certificate, AnUnderstatedRangeLeavesTheBoundValid) {
  const problem::SynthesisProblem problem = WithMargins(2);
  const double optimum = synthesis::SolveFrom(problem, problem.start).evaluation.range_deg;
  certificate::CertificateOptions options;
  options.max_boxes = 3000;
  for (const double below : {0.05, 1.0, 20.0, 100.0}) {
    const certificate::Certificate certificate = certificate::CertifyRange(problem, optimum - below, options);
    EXPECT_GE(certificate.upper_bound_deg, optimum - kRounding_deg);
    EXPECT_LE(certificate.upper_bound_deg, optimum + 0.1) << below;
    EXPECT_EQ(certificate.reached, certificate.upper_bound_deg <= optimum - below + options.gap_deg) << below;
    EXPECT_FALSE(certificate.feasible_set_empty);
  }
}

problem::SynthesisProblem Fixed(problem::SynthesisProblem problem, const linkage::Links& links,
                                const std::vector<std::size_t>& which) {
  for (const std::size_t i : which) problem.bounds[i] = {links.Values()[i], links.Values()[i]};
  return problem;
}

// Where nothing can be split, the design's own range is the bound, whatever is known.
TEST(Certificate, FixedLinksHaveTheirOwnRangeAsBound) {
  std::mt19937_64 random(20260505);
  for (int trial = 0; trial < 50; ++trial) {
    const problem::SynthesisProblem open = WithMargins(trial % 3);
    const linkage::Links links = trial == 0 ? kPublishedLinks : RandomFeasible(open, random);
    const problem::SynthesisProblem problem = Fixed(open, links, {0, 1, 2, 3, 4, 5});
    const double range = RangeOf(links, problem);
    for (const std::optional<double> known :
         {std::optional<double>(), std::optional(range), std::optional(range - 1)}) {
      const certificate::Certificate certificate = certificate::CertifyRange(problem, known);
      EXPECT_FALSE(certificate.feasible_set_empty);
      EXPECT_NEAR(certificate.upper_bound_deg, range, 1e-6) << "trial " << trial;
      EXPECT_GE(certificate.upper_bound_deg, range - kRounding_deg);
      EXPECT_EQ(certificate.reached, known == range);
      EXPECT_LE(certificate.boxes, 2);
    }
  }
}

TEST(Certificate, SomeLinksMayBeFixed) {
  std::mt19937_64 random(20260606);
  for (int trial = 0; trial < 60; ++trial) {
    const problem::SynthesisProblem open = WithMargins(trial % 2);
    const linkage::Links links = RandomFeasible(open, random);
    std::vector<std::size_t> which;
    for (std::size_t i = 0; i < 6; ++i)
      if (random() % 2) which.push_back(i);
    const problem::SynthesisProblem problem = Fixed(open, links, which);
    certificate::CertificateOptions options;
    options.max_boxes = 300;
    const certificate::Certificate certificate = certificate::CertifyRange(problem, RangeOf(links, problem), options);
    for (const linkage::Links& sample : FeasibleSamples(problem, 300, random))
      ASSERT_LE(RangeOf(sample, problem), certificate.upper_bound_deg + kRounding_deg) << "trial " << trial;
  }
}

TEST(Certificate, ABoundBelowAKnownRangeIsAnError) {
  EXPECT_THAT([] { certificate::CertifyRange(problem::SynthesisProblem{}, kSupremum_deg + 0.01); },
              ::testing::ThrowsMessage<Error>(::testing::HasSubstr("170.547678 deg is known")));
  problem::SynthesisProblem empty;
  empty.bounds[0] = {90, 100};
  empty.bounds[3] = {50, 60};  // l1 <= l4 is impossible
  EXPECT_THROW(certificate::CertifyRange(empty, 100), Error);
  const problem::SynthesisProblem fixed = Fixed(problem::SynthesisProblem{}, kPublishedLinks, {0, 1, 2, 3, 4, 5});
  EXPECT_THROW(certificate::CertifyRange(fixed, RangeOf(kPublishedLinks, fixed) + 0.01), Error);
}

TEST(Certificate, IsTheSameForAnyNumberOfThreads) {
  for (const bool has_limits : {false, true}) {
    const problem::SynthesisProblem problem = has_limits ? Buildable() : WithMargins(1);
    const std::optional<double> known = has_limits ? std::optional(148.5) : std::nullopt;  // buildable.yaml: README
    certificate::CertificateOptions options;
    options.max_boxes = 1500;
    options.threads = 1;
    const certificate::Certificate alone = certificate::CertifyRange(problem, known, options);
    EXPECT_EQ(alone.boxes, options.max_boxes);
    for (const int threads : {2, 3, 5}) {
      options.threads = threads;
      const certificate::Certificate together = certificate::CertifyRange(problem, known, options);
      EXPECT_EQ(together.upper_bound_deg, alone.upper_bound_deg) << threads;
      EXPECT_EQ(together.boxes, alone.boxes) << threads;
    }
  }
}

// Refined bounds of problems unlike the paper's must meet the optimum that Ipopt finds: never below it, and not far
// above.
TEST(Certificate, MeetsTheOptimumOfRandomProblems) {
  std::mt19937_64 random(20260202);
  int solved = 0, like_the_papers = 0;
  for (int trial = 0; trial < 60; ++trial) {
    problem::SynthesisProblem problem = RandomProblem(random);
    const bool like_paper = trial % 3 > 0;  // l1 may follow Grashof's law
    if (like_paper) problem.bounds[0] = {problem.bounds[2].lower, problem.bounds[2].lower + 40};
    const synthesis::SynthesisResult result = synthesis::Optimize(problem, Starts(3));
    if (result.best < 0) continue;
    ++solved;
    like_the_papers += like_paper;
    certificate::CertificateOptions certificate_options;
    certificate_options.max_boxes = like_paper ? 5000 : 20000;
    const certificate::Certificate certificate =
        certificate::CertifyRange(problem, result.Best().evaluation.range_deg, certificate_options);
    EXPECT_GE(certificate.gap_deg, -1e-6) << "trial " << trial;
    EXPECT_TRUE(certificate.reached) << "trial " << trial << " gap " << certificate.gap_deg;
  }
  EXPECT_GT(solved, 15);
  EXPECT_GT(like_the_papers, 15);
}

// Fifteen problems unlike the paper's, as they come.
TEST(Certificate, ClosesFifteenRandomProblems) {
  for (const SolvedProblem& solved : RandomSolvedProblems(15)) {
    const certificate::Certificate certificate = certificate::CertifyRange(solved.problem, solved.range_deg);
    EXPECT_TRUE(certificate.reached) << certificate.gap_deg;
    EXPECT_GE(certificate.gap_deg, -1e-6);
    EXPECT_LE(certificate.boxes, 5000);
  }
}

// Limits over the used range, on the seat and on strength.
TEST(Certificate, ClosesProblemsWithLimitsOverTheUsedRange) {
  for (const char* name : {"buildable.yaml", "wearable.yaml"}) {
    const problem::SynthesisProblem problem = problem::ReadProblem(SourceDir() / "calibration/problems" / name);
    const synthesis::SynthesisResult result = synthesis::Optimize(problem, Starts(3));
    ASSERT_TRUE(result.IsSolved()) << name;
    const certificate::Certificate certificate =
        certificate::CertifyRange(problem, result.Best().evaluation.range_deg, {.gap_deg = 1});
    EXPECT_TRUE(certificate.reached) << name << ": " << certificate.gap_deg;
    EXPECT_GE(certificate.gap_deg, -1e-6) << name;
  }
}

TEST(Certificate, SaysWhatEndedItAndWhatItDoesWithout) {
  using End = certificate::Certificate::End;
  problem::SynthesisProblem problem = Buildable();
  const double range = synthesis::SolveFrom(problem, problem.start).evaluation.range_deg;
  EXPECT_EQ(certificate::CertifyRange(problem, range, {.gap_deg = 30}).end, End::kGap);
  EXPECT_EQ(certificate::CertifyRange(problem, range, {.max_boxes = 10}).end, End::kBoxes);
  const certificate::Certificate ended = certificate::CertifyRange(problem, range, {.time_s = 1e-9});
  EXPECT_EQ(ended.end, End::kTime);
  EXPECT_FALSE(ended.reached);
  EXPECT_GT(ended.gap_deg, 0.1);
  EXPECT_TRUE(certificate::NotInBound(problem).empty());
  problem.robust_mm = 0.1;
  problem.clearances.thigh_mm = 5;
  EXPECT_THAT(certificate::NotInBound(problem), ::testing::ElementsAre("thigh clearance", "tolerance"));
}

TEST(Certificate, SaysWhenNothingIsFeasible) {
  problem::SynthesisProblem problem;
  problem.bounds[0] = {90, 100};
  problem.bounds[3] = {50, 60};  // l1 <= l4 is impossible
  const certificate::Certificate certificate = certificate::CertifyRange(problem, std::nullopt);
  EXPECT_TRUE(certificate.feasible_set_empty);
  EXPECT_EQ(certificate.end, certificate::Certificate::End::kNothingToSplit);
  EXPECT_EQ(certificate.upper_bound_deg, -std::numeric_limits<double>::infinity());
  EXPECT_FALSE(certificate.reached);
}

// The seat counts for every design that satisfies the problem, also where the knee bends no further than sitting.
TEST(Certificate, TheSeatIsInTheBoundWhereTheKneeBendsNoFurtherThanSitting) {
  problem::SynthesisProblem problem = WithMargins(2);
  problem.limits["max_angle_deg"] = 85;
  problem.standing_deg = 5;
  problem.clearances.seat_mm = 1000;  // more than any linkage within the bounds
  EXPECT_THAT(certificate::NotInBound(problem), ::testing::IsEmpty());
  for (const double known : {60.0, 85.0}) EXPECT_THROW(certificate::CertifyRange(problem, known), Error) << known;

  // And cuts off none that sits at its shortest stroke.
  problem.clearances.seat_mm = 5;
  const synthesis::SynthesisResult result = synthesis::Optimize(problem, Starts(3));
  ASSERT_TRUE(result.IsSolved());
  EXPECT_NEAR(result.Best().evaluation.range_deg, 85, 1e-4);
  const certificate::Certificate certificate = certificate::CertifyRange(problem, result.Best().evaluation.range_deg);
  EXPECT_TRUE(certificate.reached) << certificate.gap_deg;
  certificate::LinkBox box;
  for (std::size_t i = 0; i < box.size(); ++i) box[i] = result.Best().end.Values()[i];
  EXPECT_TRUE(certificate::Relaxation(problem, certificate::RangeBound(problem), -kInfinity).Examine(box));
}

TEST(Certificate, RefusesSenselessOptions) {
  for (const certificate::CertificateOptions& options :
       {certificate::CertificateOptions{.gap_deg = 0}, {.max_boxes = 0}, {.time_s = 0}, {.threads = 0}})
    EXPECT_THROW(certificate::CertifyRange(problem::SynthesisProblem{}, 170, options), Error);
  EXPECT_THROW(certificate::CertifyRange(problem::SynthesisProblem{}, NAN), Error);
}

// Draws intervals and points in them; what long double (64 bits of mantissa) finds at the points must be enclosed.
class IntervalTest : public ::testing::Test {
 protected:
  certificate::Interval Draw(double low, double high) {
    std::uniform_real_distribution<double> uniform(low, high);
    const double a = uniform(random_), b = uniform(random_);
    const double narrow = std::uniform_real_distribution<double>(0, 1)(random_) < 0.3 ? 1e-12 : 1;
    return {std::min(a, a + (b - a) * narrow), std::max(a, a + (b - a) * narrow)};
  }
  double PointIn(const certificate::Interval& a) {
    return std::clamp(std::uniform_real_distribution<double>(a.lower, a.upper)(random_), a.lower, a.upper);
  }
  static void ExpectEncloses(const certificate::Interval& a, long double exact) {
    EXPECT_LE(static_cast<long double>(a.lower), exact);
    EXPECT_GE(static_cast<long double>(a.upper), exact);
  }
  std::mt19937_64 random_{4711};
};

TEST_F(IntervalTest, ArithmeticEncloses) {
  for (int i = 0; i < 20000; ++i) {
    const certificate::Interval a = Draw(-300, 300), b = Draw(-300, 300);
    const long double x = PointIn(a), y = PointIn(b);
    ExpectEncloses(a + b, x + y);
    ExpectEncloses(a - b, x - y);
    ExpectEncloses(a * b, x * y);
    if (!b.Contains(0)) ExpectEncloses(a / b, x / y);
    ExpectEncloses(certificate::Square(a), x * x);
    ExpectEncloses(certificate::Max(a, b), std::max(x, y));
    if (a.lower > 0) ExpectEncloses(certificate::Sqrt(a), std::sqrt(x));
  }
}

TEST_F(IntervalTest, UnboundedOperandsGiveNumbers) {
  using certificate::Interval;
  constexpr double kInf = std::numeric_limits<double>::infinity();
  // But for the least number, by which a product is widened.
  constexpr double kLeast = std::numeric_limits<double>::denorm_min();
  const Interval all{-kInf, kInf};
  for (const Interval& nothing : {all * Interval(0, 0), Interval(0, 0) * all}) {
    EXPECT_GE(nothing.lower, -kLeast);
    EXPECT_LE(nothing.upper, kLeast);
    EXPECT_TRUE(nothing.Contains(0));
  }
  const Interval half = all * Interval(0, 2);
  EXPECT_EQ(half.lower, -kInf);
  EXPECT_EQ(half.upper, kInf);
  const Interval quotient = Interval(1, kInf) / Interval(2, kInf);
  EXPECT_LE(quotient.lower, 0);
  EXPECT_EQ(quotient.upper, kInf);
}

TEST_F(IntervalTest, FunctionsEnclose) {
  for (int i = 0; i < 20000; ++i) {
    const certificate::Interval angle = Draw(-7, 7), cosine = Draw(-1, 1);
    ExpectEncloses(certificate::Sin(angle), std::sin(static_cast<long double>(PointIn(angle))));
    ExpectEncloses(certificate::Cos(angle), std::cos(static_cast<long double>(PointIn(angle))));
    ExpectEncloses(certificate::ArcCos(cosine), std::acos(static_cast<long double>(PointIn(cosine))));
    const certificate::Interval x = Draw(0, 100), y = Draw(-100, 100);
    ExpectEncloses(certificate::AngleFromY(x, y),
                   std::atan2(static_cast<long double>(PointIn(x)), static_cast<long double>(PointIn(y))));
  }
}

TEST_F(IntervalTest, EnclosesAreTight) {
  for (int i = 0; i < 2000; ++i) {
    const double x = PointIn({0.1, 3});
    // A few ulps of the result: 4 of the library's, 1 of arithmetic, and those of the shift by pi / 2.
    EXPECT_LT(certificate::Sin(x).Width(), 1e-14);
    EXPECT_LT(certificate::Cos(x).Width(), 1e-14);
    EXPECT_LT(certificate::Sqrt(x).Width(), 1e-15);
    EXPECT_LT((certificate::Interval(x) * 3.0).Width(), 4e-15);
  }
}

TEST_F(IntervalTest, ExtremaInsideAreSeen) {
  EXPECT_EQ(certificate::Cos({-0.5, 0.5}).upper, 1);
  EXPECT_EQ(certificate::Cos({3, 3.3}).lower, -1);
  EXPECT_EQ(certificate::Sin({1, 2}).upper, 1);
  EXPECT_EQ(certificate::Square({-2, 1}).lower, 0);
}

TEST_F(IntervalTest, UndefinedOperandsAreEmptyOrTheWholeLine) {
  EXPECT_TRUE(certificate::Sqrt({-2, -1}).IsEmpty());
  EXPECT_TRUE(certificate::ArcCos({1.5, 2}).IsEmpty());
  EXPECT_EQ(certificate::ArcCos({0.5, 2}).lower, 0);
  EXPECT_TRUE(std::isinf((certificate::Interval(1) / certificate::Interval(-1, 1)).upper));
  EXPECT_LT(certificate::kPiInterval.lower, 3.14159265358979323846L);
  EXPECT_GT(certificate::kPiInterval.upper, 3.14159265358979323846L);
}

}  // namespace
}  // namespace lake
