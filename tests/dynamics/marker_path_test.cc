// Paths driven by white jerk against their closed forms, and against dense Gaussians that know no filter.
#include "lake/dynamics/marker_path.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace lake::dynamics {
namespace {

constexpr MotionPrior kPrior{800, 6000};

// A path of this density at irregular times, its states drawn exactly; measured with this error.
std::vector<PathSample> DrawPath(std::uint64_t seed, int samples, double step_s, double density, double sigma) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uneven(0.6, 1.4);
  PathState state = StartAt({}, kPrior);
  state.mean.row(1) << 100, -50;
  std::vector<PathSample> path;
  double time_s = 0;
  for (int i = 0; i < samples; ++i) {
    const Eigen::RowVector2d error(normal(random), normal(random));
    path.push_back({time_s, (state.mean.row(0) + sigma * error).transpose(), sigma});
    const double elapsed_s = step_s * uneven(random);
    PathState certain{state.mean, Eigen::Matrix3d::Zero()};
    state = Moved(certain, elapsed_s, density);
    const Eigen::Matrix3d root = state.covariance.llt().matrixL();
    for (int axis = 0; axis < 2; ++axis)
      state.mean.col(axis) += root * Eigen::Vector3d(normal(random), normal(random), normal(random));
    time_s += elapsed_s;
  }
  return path;
}

TEST(MarkerPath, GrowsUncertainOverAGapAsItsIntegralsDo) {
  const double density = 7, gap_s = 0.4;
  const PathState after = Moved({}, gap_s, density);
  EXPECT_NEAR(after.covariance(0, 0), density * std::pow(gap_s, 5) / 20, 1e-15);
  EXPECT_NEAR(after.covariance(1, 1), density * std::pow(gap_s, 3) / 3, 1e-15);
  EXPECT_NEAR(after.covariance(2, 2), density * gap_s, 1e-15);
  // In two steps as in one.
  const PathState steps = Moved(Moved({}, 0.15, density), gap_s - 0.15, density);
  EXPECT_TRUE(steps.covariance.isApprox(after.covariance, 1e-12));
}

TEST(MarkerPath, IsToldBackwardAsForward) {
  PathState state = StartAt({0, {3, -4}, 0.5}, kPrior);
  state.mean.row(1) << 20, 30;
  state.mean.row(2) << -200, 100;
  const PathState there = Moved(state, 0.2, 0), back = Moved(there, -0.2, 0);
  EXPECT_TRUE(back.mean.isApprox(state.mean, 1e-12));
  EXPECT_TRUE(back.covariance.isApprox(state.covariance, 1e-9));
  EXPECT_TRUE(Moved({}, -0.4, 7).covariance.diagonal().isApprox(Moved({}, 0.4, 7).covariance.diagonal(), 1e-12));
}

// The positions' joint covariance: the prior's, carried to each time, and the jerk's,
// ∫₀^min(s,t) q (s−u)²/2 (t−u)²/2 du, by Simpson's rule, which is exact for less than the fourth power in each of 200
// parts.
Eigen::MatrixXd DenseCovariance(const std::vector<PathSample>& path, double density) {
  const auto n = static_cast<Eigen::Index>(path.size());
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const double s = path[static_cast<std::size_t>(i)].time_s - path[0].time_s,
                   t = path[static_cast<std::size_t>(j)].time_s - path[0].time_s;
      const double sigma0 = path[0].sigma;
      double value = sigma0 * sigma0 + kPrior.speed * kPrior.speed * s * t +
                     kPrior.acceleration * kPrior.acceleration * s * s * t * t / 4;
      constexpr int kParts = 200;
      const double end = std::min(s, t);
      const auto integrand = [&](double u) { return density * (s - u) * (s - u) * (t - u) * (t - u) / 4; };
      for (int k = 0; k < kParts && end > 0; ++k) {
        const double a = end * k / kParts, b = end * (k + 1) / kParts;
        value += (b - a) / 6 * (integrand(a) + 4 * integrand(0.5 * (a + b)) + integrand(b));
      }
      covariance(i, j) = value + (i == j && i > 0 ? std::pow(path[static_cast<std::size_t>(i)].sigma, 2) : 0);
    }
  return covariance;
}

double DenseLogDensity(const std::vector<PathSample>& path, std::size_t count, double density) {
  const std::vector<PathSample> head(path.begin(), path.begin() + static_cast<std::ptrdiff_t>(count));
  // The first place is where the prior is; what is seen later is relative to it.
  const Eigen::LLT<Eigen::MatrixXd> covariance(
      DenseCovariance(head, density).bottomRightCorner(head.size() - 1, head.size() - 1));
  double log_density = 0;
  for (int axis = 0; axis < 2; ++axis) {
    Eigen::VectorXd off(static_cast<Eigen::Index>(head.size()) - 1);
    for (std::size_t i = 1; i < head.size(); ++i)
      off[static_cast<Eigen::Index>(i) - 1] = head[i].position[axis] - head[0].position[axis];
    const Eigen::VectorXd white = covariance.matrixL().solve(off);
    log_density -= 0.5 * white.squaredNorm() + covariance.matrixLLT().diagonal().array().log().sum() +
                   0.5 * static_cast<double>(off.size()) * std::log(2 * std::numbers::pi);
  }
  return log_density;
}

TEST(MarkerPath, HasTheLikelihoodOfADenseGaussian) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const double density = std::pow(10, 4 + static_cast<double>(seed));
    const std::vector<PathSample> path = DrawPath(seed, 12, 0.03, density, 0.3);
    const double filtered = EvidenceAt(path, path.back().time_s, density, kPrior).log_likelihood;
    const double dense = DenseLogDensity(path, path.size(), density) - DenseLogDensity(path, 3, density);
    EXPECT_NEAR(filtered, dense, 1e-6 * std::abs(dense)) << seed;
  }
}

// Two halves of one path are joined with squared distances that average to their six numbers; 400 paths leave the
// mean's standard deviation at sqrt(12 / 400) = 0.17.
TEST(MarkerPath, JoinsItsHalvesAsTheirCovariancesSay) {
  const double density = 1e7, sigma = 0.2;
  double squares = 0;
  constexpr int kPaths = 400;
  for (int i = 0; i < kPaths; ++i) {
    const std::vector<PathSample> path = DrawPath(100 + static_cast<std::uint64_t>(i), 24, 1.0 / 60, density, sigma);
    const std::vector<PathSample> first(path.begin(), path.begin() + 12);
    const std::vector<PathSample> second(path.rbegin(), path.rbegin() + 12);
    const MotionPrior vague{1e5, 1e6};
    const double gap_s = path[12].time_s - path[11].time_s;
    const PathState before = EvidenceAt(first, path[11].time_s, density, vague).state,
                    after = EvidenceAt(second, path[12].time_s, density, vague).state;
    PathState there = after;
    there.mean = Moved(before, gap_s, density).mean;
    squares += LogJoin(before, there, gap_s, density) - LogJoin(before, after, gap_s, density);
  }
  EXPECT_NEAR(2 * squares / kPaths, 6, 4 * 0.17);
}

// What a path tells well is left as it is; after a second without a measurement nothing of it is left but that it is a
// person's.
TEST(MarkerPath, StaysWithinReach) {
  const MotionPrior prior = PersonPrior(1);
  PathState start = StartAt({0, {100, 200}, 0.5}, prior);
  start.covariance = Eigen::Vector3d(0.5 * 0.5, 10 * 10, 100 * 100).asDiagonal();
  const PathState soon = WithinReach(Moved(start, 1e-3, 1e9), start.Position(), prior),
                  late = WithinReach(Moved(start, 1, 1e9), start.Position(), prior);
  EXPECT_NEAR(std::sqrt(soon.covariance(0, 0)), 0.5, 0.01);
  EXPECT_NEAR((late.Position() - start.Position()).norm(), 0, 1e-9);
  EXPECT_LE(std::sqrt(late.covariance(0, 0)), prior.reach);
  EXPECT_GE(std::sqrt(late.covariance(0, 0)), 0.9 * prior.reach);
  EXPECT_LE(std::sqrt(late.covariance(1, 1)), prior.speed);
}

TEST(LearnMotion, FindsTheDensityAndWhatTheSigmasLeaveOut) {
  for (const std::uint64_t seed : {11u, 12u, 13u, 14u}) {
    const double density = std::pow(10, 7 + 0.5 * static_cast<double>(seed - 11));
    std::vector<std::vector<PathSample>> paths;
    for (std::uint64_t m = 0; m < 4; ++m) {
      paths.push_back(DrawPath(10 * seed + m, 400, 1.0 / 60, density, 0.2));
      for (PathSample& sample : paths.back()) sample.sigma = 0.05;
    }
    const LearntMotion learnt = LearnMotion(paths, 1);
    // Nine in ten windows of 36 samples are below; one of them knows its density to half a decade.
    EXPECT_NEAR(std::log10(learnt.density), std::log10(density) + 0.5, 0.75) << seed;
    // 2900 residuals know a deviation to 1.3 %; a path of the largest density bends within two frames, and takes a
    // part.
    EXPECT_NEAR(learnt.extra_sigma, std::sqrt(0.2 * 0.2 - 0.05 * 0.05), seed < 13 ? 0.01 : 0.025) << seed;
  }
}

// The same recording in px and in mm.
TEST(LearnMotion, DoesNotDependOnTheUnit) {
  const double mm_per_px = 2.5;
  std::vector<std::vector<PathSample>> mm = {DrawPath(5, 300, 1.0 / 30, 1e8, 0.4)}, px = mm;
  for (PathSample& sample : px[0]) sample.position /= mm_per_px, sample.sigma /= mm_per_px;
  const LearntMotion by_mm = LearnMotion(mm, 1), by_px = LearnMotion(px, mm_per_px);
  EXPECT_NEAR(by_px.density * mm_per_px * mm_per_px / by_mm.density, 1, 1e-9);
  EXPECT_NEAR(by_px.extra_sigma * mm_per_px, by_mm.extra_sigma, 1e-12);
}

}  // namespace
}  // namespace lake::dynamics
