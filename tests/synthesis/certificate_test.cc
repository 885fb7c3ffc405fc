#include "lake/synthesis/certificate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/synthesis/optimize.h"
#include "paper.h"

namespace lake {
namespace {

constexpr double kSupremum_deg = 170.53767779197486;  // 180 - atan(50 / 300)

TEST(Certificate, ProvesThePapersProblem) {
  const double range = SolveFrom(SynthesisProblem{}, SynthesisProblem{}.start).evaluation.range_deg;
  const Certificate certificate = CertifyRange(SynthesisProblem{}, range);
  EXPECT_TRUE(certificate.reached);
  EXPECT_LE(certificate.upper_bound_deg - range, 0.1);
  EXPECT_GE(certificate.upper_bound_deg, kSupremum_deg - 1e-9);
  EXPECT_NEAR(180 - DegreesFromRadians(std::atan(50.0 / 300.0)), kSupremum_deg, 1e-12);
  EXPECT_LT(certificate.seconds, 60);
}

TEST(Certificate, ProvesTheOptimaWithMargins) {
  for (const double margin : {1.0, 2.0, 5.0, 10.0, 15.0, 20.0}) {
    const SynthesisProblem problem = WithMargins(margin);
    const LocalSolve best = SolveFrom(problem, problem.start);
    ASSERT_TRUE(best.IsUsable()) << margin;
    const Certificate certificate = CertifyRange(problem, best.evaluation.range_deg);
    EXPECT_TRUE(certificate.reached) << margin;
    EXPECT_LE(certificate.gap_deg, 0.1) << margin;
    EXPECT_GE(certificate.gap_deg, -1e-9) << margin;
  }
}

TEST(Certificate, SmallerGapsAreReachedToo) {
  const SynthesisProblem problem = WithMargins(2);
  const double range = SolveFrom(problem, problem.start).evaluation.range_deg;
  CertificateOptions options;
  options.gap_deg = 1e-4;
  const Certificate certificate = CertifyRange(problem, range, options);
  EXPECT_TRUE(certificate.reached) << certificate.boxes;
  EXPECT_LE(certificate.gap_deg, 1e-4);
}

SynthesisProblem RandomProblem(std::mt19937_64& random) {
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  SynthesisProblem problem;
  for (std::size_t i = 0; i < 4; ++i) {
    problem.bounds[i].lower = uniform(30, 75);
    problem.bounds[i].upper = problem.bounds[i].lower + uniform(0, 40);
  }
  problem.bounds[4].lower = uniform(20, 100);
  problem.bounds[4].upper = problem.bounds[4].lower + uniform(0, 60);
  problem.bounds[5].lower = uniform(150, 280);
  problem.bounds[5].upper = problem.bounds[5].lower + uniform(0, 80);
  problem.grashof_margin_mm = uniform(0, 5) * (random() % 2);
  problem.singularity_margin_mm = uniform(0, 5) * (random() % 2);
  problem.d_min_mm = uniform(200, 270);
  return problem;
}

// The bound of a box without any branching must hold for every feasible design in it, whatever the bounds and margins.
TEST(Certificate, NoFeasibleDesignOfRandomProblemsExceedsTheBound) {
  std::mt19937_64 random(20260101);
  int problems = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    const SynthesisProblem problem = RandomProblem(random);
    const Certificate root = CertifyRange(problem, 180);  // nothing exceeds it, so nothing is split
    const auto requirements = RequirementsOf(problem);
    bool any = false;
    for (int sample = 0; sample < 200; ++sample) {
      std::array<double, 6> values{};
      for (std::size_t i = 0; i < 6; ++i)
        values[i] = std::uniform_real_distribution(problem.bounds[i].lower, problem.bounds[i].upper)(random);
      const Links links = Links::FromValues(values);
      if (!MeetsLinkRequirements(links, problem, requirements)) continue;
      any = true;
      ASSERT_LE(DegreesFromRadians(SolvePose(links, problem.d_min_mm)->theta_rad), root.upper_bound_deg + 1e-9)
          << "trial " << trial;
    }
    problems += any;
  }
  EXPECT_GT(problems, 200);  // the test has seen enough feasible designs to mean something
}

// Refined bounds of problems unlike the paper's must meet the optimum that Ipopt finds: never below it, and not far
// above where l1 can follow l3 down, as in the paper's bounds (elsewhere branching is slow, and a short time limit is
// not enough).
TEST(Certificate, MeetsTheOptimumOfRandomProblems) {
  std::mt19937_64 random(20260202);
  int reached = 0, solved = 0;
  for (int trial = 0; trial < 60; ++trial) {
    SynthesisProblem problem = RandomProblem(random);
    const bool like_paper = trial % 3 > 0;
    if (like_paper) problem.bounds[0] = {problem.bounds[2].lower, problem.bounds[2].lower + 40};
    OptimizeOptions options;
    options.starts = 3;
    const SynthesisResult result = Optimize(problem, options);
    if (result.best < 0) continue;
    solved += like_paper;
    CertificateOptions certificate_options;
    certificate_options.max_seconds = 0.3;
    const Certificate certificate = CertifyRange(problem, result.Best().evaluation.range_deg, certificate_options);
    EXPECT_GE(certificate.gap_deg, -1e-6) << "trial " << trial;
    reached += like_paper && certificate.reached;
  }
  EXPECT_GT(solved, 15);
  EXPECT_EQ(reached, solved);
}

TEST(Certificate, SaysWhenNothingIsFeasible) {
  SynthesisProblem problem;
  problem.bounds[0] = {90, 100};
  problem.bounds[3] = {50, 60};  // l1 <= l4 is impossible
  EXPECT_TRUE(CertifyRange(problem, 100).feasible_set_empty);
}

TEST(Certificate, RefusesSenselessOptions) {
  CertificateOptions options;
  options.gap_deg = 0;
  EXPECT_THROW(CertifyRange(SynthesisProblem{}, 170, options), Error);
  options = {};
  options.threads = 0;
  EXPECT_THROW(CertifyRange(SynthesisProblem{}, 170, options), Error);
}

}  // namespace
}  // namespace lake
