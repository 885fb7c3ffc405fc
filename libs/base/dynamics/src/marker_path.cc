#include "lake/dynamics/marker_path.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "lake/core/statistics.h"
#include "white_jerk.h"

namespace lake::dynamics {
namespace {

const double kLogTwoPi = std::log(2 * std::numbers::pi);

}  // namespace

PathState StartAt(const PathSample& sample, const MotionPrior& prior) {
  PathState state;
  state.mean.row(0) = sample.position;
  state.covariance.diagonal() << sample.sigma * sample.sigma, prior.speed * prior.speed,
      prior.acceleration * prior.acceleration;
  return state;
}

PathState Moved(const PathState& state, double elapsed_s, double density) {
  const Eigen::Matrix3d by = JerkTransition(elapsed_s);
  const Eigen::Matrix3d noise = density * JerkCovariance(std::abs(elapsed_s));
  PathState moved;
  moved.mean = by * state.mean;
  moved.covariance = elapsed_s >= 0 ? Eigen::Matrix3d(by * state.covariance * by.transpose() + noise)
                                    : Eigen::Matrix3d(by * (state.covariance + noise) * by.transpose());
  return moved;
}

PathState WithinReach(const PathState& state, const Eigen::Vector2d& was_at, const MotionPrior& prior) {
  const Eigen::Vector3d variance =
      Eigen::Vector3d(prior.reach, prior.speed, prior.acceleration).array().square().matrix();
  Eigen::Matrix3d sum = state.covariance;
  sum.diagonal() += variance;
  const Eigen::Matrix3d gain = sum.llt().solve(state.covariance).transpose();
  Eigen::Matrix<double, 3, 2> usual = Eigen::Matrix<double, 3, 2>::Zero();
  usual.row(0) = was_at;
  PathState within;
  within.mean = state.mean + gain * (usual - state.mean);
  within.covariance = state.covariance - gain * state.covariance;
  return within;
}

double Observe(const PathSample& sample, PathState& state) {
  const double variance = state.covariance(0, 0) + sample.sigma * sample.sigma;
  const Eigen::RowVector2d innovation = sample.position.transpose() - state.mean.row(0);
  const Eigen::Vector3d gain = state.covariance.col(0) / variance;
  state.mean += gain * innovation;
  const Eigen::RowVector3d seen = state.covariance.row(0);
  state.covariance -= gain * seen;
  return -0.5 * innovation.squaredNorm() / variance - std::log(variance) - kLogTwoPi;
}

PathEvidence EvidenceAt(std::span<const PathSample> samples, double at_s, double density, const MotionPrior& prior) {
  constexpr std::size_t kSettingOut = 3;
  PathEvidence evidence{StartAt(samples.front(), prior)};
  for (std::size_t i = 1; i < samples.size(); ++i) {
    evidence.state = Moved(evidence.state, samples[i].time_s - samples[i - 1].time_s, density);
    const double log_density = Observe(samples[i], evidence.state);
    if (i >= kSettingOut) evidence.log_likelihood += log_density;
  }
  evidence.state = Moved(evidence.state, at_s - samples.back().time_s, density);
  return evidence;
}

double LogJoin(const PathState& before, const PathState& after, double elapsed_s, double density) {
  const PathState predicted = Moved(before, elapsed_s, density);
  const Eigen::LLT<Eigen::Matrix3d> covariance(predicted.covariance + after.covariance);
  const Eigen::Matrix<double, 3, 2> white = covariance.matrixL().solve(after.mean - predicted.mean);
  const double log_root = covariance.matrixLLT().diagonal().array().log().sum();
  return -0.5 * white.squaredNorm() - 2 * log_root - 3 * kLogTwoPi;
}

MotionPrior PersonPrior(double unit_mm) {
  constexpr double kSpeed_mm_s = 1000, kAcceleration_mm_s2 = 10000, kReach_mm = 500;
  return {kSpeed_mm_s / unit_mm, kAcceleration_mm_s2 / unit_mm, kReach_mm / unit_mm};
}

namespace {

// Densities from that of a person at rest, mm²/s⁵, to that of a heel that is set down; extra errors in units of the
// paths' typical sigma, first a factor of two apart, then between.
constexpr double kLeastLogDensity = 2, kLogStep = 0.5;
constexpr std::size_t kDensities = 17;
constexpr std::array<double, 7> kExtraSigmas = {0, 0.5, 1, 2, 4, 8, 16};
constexpr int kHalvings = 5;  // of the logarithm of that factor

struct Window {
  std::vector<PathSample> samples;
  double sigma = 0;  // median
};

// How many samples a window has. By the mean rate, so that other times of the same samples give the same windows and
// their likelihoods compare.
std::size_t WindowSize(std::span<const std::vector<PathSample>> paths) {
  constexpr double kLength_s = 0.6;
  constexpr std::size_t kFewest = 14;
  double samples = 0, duration_s = 0;
  for (const std::vector<PathSample>& path : paths) {
    if (path.empty()) continue;
    samples += static_cast<double>(path.size() - 1);
    duration_s += path.back().time_s - path.front().time_s;
  }
  return std::max(kFewest,
                  static_cast<std::size_t>(duration_s > 0 ? std::lround(kLength_s * samples / duration_s) : 0));
}

std::vector<Window> SpreadWindows(std::span<const std::vector<PathSample>> paths) {
  constexpr double kLongestGap_s = 0.5;
  constexpr std::size_t kFewest = 10, kMost = 150;
  const std::size_t size = WindowSize(paths);
  std::vector<Window> windows;
  for (const std::vector<PathSample>& path : paths)
    for (std::size_t begin = 0, end = 0; begin < path.size(); begin = end) {
      for (end = begin + 1; end < path.size() && end < begin + size; ++end)
        if (path[end].time_s > path[end - 1].time_s + kLongestGap_s) break;
      if (end - begin < kFewest) continue;
      windows.push_back(
          {{path.begin() + static_cast<std::ptrdiff_t>(begin), path.begin() + static_cast<std::ptrdiff_t>(end)}, 0});
      std::vector<double> sigmas;
      for (const PathSample& sample : windows.back().samples) sigmas.push_back(sample.sigma);
      windows.back().sigma = Median(std::move(sigmas));
    }
  std::vector<Window> spread;
  const double step = std::max(1.0, static_cast<double>(windows.size()) / static_cast<double>(kMost));
  for (double at = 0; at < static_cast<double>(windows.size()); at += step)
    spread.push_back(std::move(windows[static_cast<std::size_t>(at)]));
  return spread;
}

double DensityAt(std::size_t step, double unit_mm) {
  return std::pow(10, kLeastLogDensity + kLogStep * static_cast<double>(step)) / (unit_mm * unit_mm);
}

using ByDensity = std::array<double, kDensities>;

// How likely all windows are where measurements err by more than stated, and how often each density occurs in them:
// each window has one, drawn from a distribution that all have in common (a mixture, by expectation maximisation).
struct Explanation {
  double log_likelihood = 0;
  ByDensity share;
};

Explanation Explain(const std::vector<Window>& windows, double extra_sigma, double unit_mm) {
  constexpr int kRounds = 20;
  std::vector<ByDensity> logs;
  for (const Window& window : windows) {
    std::vector<PathSample> samples = window.samples;
    for (PathSample& sample : samples) sample.sigma = std::hypot(sample.sigma, extra_sigma);
    ByDensity& log = logs.emplace_back();
    for (std::size_t k = 0; k < kDensities; ++k)
      log[k] = EvidenceAt(samples, samples.back().time_s, DensityAt(k, unit_mm), PersonPrior(unit_mm)).log_likelihood;
  }
  Explanation explained;
  explained.share.fill(1.0 / kDensities);
  for (int round = 0; round < kRounds; ++round) {
    ByDensity sums = {};
    explained.log_likelihood = 0;
    for (const ByDensity& log : logs) {
      const double most = *std::ranges::max_element(log);
      ByDensity own;
      double sum = 0;
      for (std::size_t k = 0; k < kDensities; ++k) sum += own[k] = explained.share[k] * std::exp(log[k] - most);
      for (std::size_t k = 0; k < kDensities; ++k) sums[k] += own[k] / sum;
      explained.log_likelihood += most + std::log(sum);
    }
    for (std::size_t k = 0; k < kDensities; ++k) explained.share[k] = sums[k] / static_cast<double>(logs.size());
  }
  return explained;
}

// The density below which are nine in ten of those windows in which something moves.
double QuickDensity(const ByDensity& share, double unit_mm) {
  constexpr double kQuickShare = 0.9, kRest = 1e4;  // mm²/s⁵: slower ones are at rest
  constexpr double kUnknown = 1e9;                  // mm²/s⁵, a quick rise's, where nothing is seen to move
  double moving = 0, below = 0;
  for (std::size_t k = 0; k < kDensities; ++k)
    if (DensityAt(k, 1) >= kRest) moving += share[k];
  if (moving < 1e-3) return kUnknown / (unit_mm * unit_mm);
  for (std::size_t k = 0; k < kDensities; ++k) {
    if (DensityAt(k, 1) < kRest) continue;
    below += share[k];
    if (below >= kQuickShare * moving) return DensityAt(k, unit_mm);
  }
  return DensityAt(kDensities - 1, unit_mm);
}

}  // namespace

LearntMotion LearnMotion(std::span<const std::vector<PathSample>> paths, double unit_mm) {
  const std::vector<Window> windows = SpreadWindows(paths);
  LearntMotion learnt{QuickDensity({}, unit_mm)};
  if (windows.empty()) return learnt;
  std::vector<double> sigmas;
  for (const Window& window : windows) sigmas.push_back(window.sigma);
  const double sigma = Median(std::move(sigmas));
  learnt.log_likelihood = -INFINITY;
  const auto try_extra = [&](double extra_sigma) {
    const Explanation explained = Explain(windows, extra_sigma, unit_mm);
    if (explained.log_likelihood <= learnt.log_likelihood) return;
    learnt.density = QuickDensity(explained.share, unit_mm);
    learnt.extra_sigma = extra_sigma;
    learnt.log_likelihood = explained.log_likelihood;
  };
  for (const double times : kExtraSigmas) try_extra(times * sigma);
  double factor = 2;
  for (int halving = 0; halving < kHalvings && learnt.extra_sigma > 0; ++halving) {
    factor = std::sqrt(factor);
    const double middle = learnt.extra_sigma;
    for (const double extra_sigma : {middle / factor, middle * factor}) try_extra(extra_sigma);
  }
  return learnt;
}

}  // namespace lake::dynamics
