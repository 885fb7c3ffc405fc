#include "lake/tracking/noise_estimate.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace lake::tracking {

namespace {

constexpr int kStep = 3;      // a ninth of the pixels is plenty
constexpr int kLowest = 200;  // grey level, of saturation

}  // namespace

bool NoiseEstimator::Add(const cv::Mat& grey) {
  constexpr std::int64_t kInterval = 12;  // frames
  const std::int64_t frame = frames_++;
  const bool is_early = frame < kFirst, ends_pair = frame >= kFirst && frame % kInterval == 1;
  if (!is_early && !ends_pair && frame % kInterval != 0) return false;
  if (ends_pair)
    for (auto& counts : differences_)
      for (std::int64_t& count : counts) count /= 2;
  if (is_early || ends_pair) CountLevels(grey);
  const bool has_pair = ends_pair || (is_early && frame > 0);
  if (has_pair) CountDifferences(grey, is_early ? kStep : 2 * kStep);
  if (!ends_pair) KeepRows(grey);
  return has_pair;
}

void NoiseEstimator::KeepRows(const cv::Mat& grey) {
  previous_.create((grey.rows + kStep - 1) / kStep, grey.cols, CV_8UC1);
  for (int row = 0; row < previous_.rows; ++row) grey.row(kStep * row).copyTo(previous_.row(row));
}

void NoiseEstimator::CountLevels(const cv::Mat& grey) {
  for (int y = 0; y < grey.rows; y += kStep) {
    const uchar* now = grey.ptr(y);
    for (int x = 0; x < grey.cols; x += kStep)
      if (now[x] >= kLowest - 1) ++levels_[now[x]];
  }
}

void NoiseEstimator::CountDifferences(const cv::Mat& grey, int step) {
  for (int y = 0; y < grey.rows; y += step) {
    const uchar *now = grey.ptr(y), *before = previous_.ptr(y / kStep);
    for (int x = 0; x < grey.cols; x += step) {
      const int difference = std::abs(now[x] - before[x]), level = (now[x] + before[x]) / 2;
      if (difference < kMaxDifference)
        ++differences_[static_cast<std::size_t>(level * kBins / 256)][static_cast<std::size_t>(difference)];
    }
  }
}

NoiseModel NoiseEstimator::Estimate() const {
  constexpr double kRoundingVariance = 1.0 / 12;
  constexpr std::int64_t kEnough = 200;
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (int bin = 0; bin < kBins; ++bin) {
    const auto& counts = differences_[static_cast<std::size_t>(bin)];
    double variance = 1e9;
    std::int64_t number = 0;
    // Leave out what is beyond four deviations of the rest until that settles.
    for (int pass = 0; pass < 6; ++pass) {
      double sum = 0;
      number = 0;
      for (int d = 0; d < kMaxDifference && d * d <= 16 * 2 * variance + 1; ++d) {
        number += counts[static_cast<std::size_t>(d)];
        sum += static_cast<double>(counts[static_cast<std::size_t>(d)]) * d * d;
      }
      if (number < kEnough) break;
      variance = 0.5 * sum / static_cast<double>(number);
    }
    if (number < kEnough) continue;
    const Eigen::Vector2d row(1, (bin + 0.5) * 256 / kBins);
    const double weight = static_cast<double>(number) / std::pow(variance + kRoundingVariance, 2);
    normal += weight * row * row.transpose();
    right += weight * row * variance;
  }
  NoiseModel model;
  if (normal(0, 0) <= 0) return model;
  normal(1, 1) += 1e-9 * normal(0, 0);  // a single level seen: no gain
  const Eigen::Vector2d line = normal.inverse() * right;
  model.gain = std::max(line[1], 0.0);
  model.read_variance = std::max(line[1] >= 0 ? line[0] : right[0] / normal(0, 0), 2 * kRoundingVariance);
  return model;
}

double NoiseEstimator::SaturationLevel() const {
  std::int64_t above = 0;  // what coding leaves beyond the level
  for (int level = 255; level >= kLowest; --level) {
    const auto at = static_cast<std::size_t>(level);
    // Saturation piles pixels up on one level; a bright tail thins out.
    if (levels_[at] > 4 * std::max<std::int64_t>({levels_[at - 1], above, 2})) return level;
    above += levels_[at];
  }
  return 255;
}

}  // namespace lake::tracking
