#include "lake/tracking/noise_estimate.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace lake::tracking {

void NoiseEstimator::Add(const cv::Mat& grey) {
  constexpr int kStep = 3;  // a ninth of the pixels is plenty
  for (int y = 0; y < grey.rows; y += kStep) {
    const uchar* now = grey.ptr(y);
    const uchar* before = previous_.empty() ? nullptr : previous_.ptr(y);
    for (int x = 0; x < grey.cols; x += kStep) {
      ++levels_[now[x]];
      if (!before) continue;
      const int difference = std::abs(now[x] - before[x]), level = (now[x] + before[x]) / 2;
      if (difference < kMaxDifference)
        ++differences_[static_cast<std::size_t>(level * kBins / 256)][static_cast<std::size_t>(difference)];
    }
  }
  grey.copyTo(previous_);
  ++frames_;
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
  int highest = 255;
  while (highest > 0 && levels_[static_cast<std::size_t>(highest)] == 0) --highest;
  // Saturation piles pixels up on one level; a bright tail thins out.
  const std::int64_t top = levels_[static_cast<std::size_t>(highest)],
                     below = highest > 0 ? levels_[static_cast<std::size_t>(highest - 1)] : 0;
  return highest >= 200 && top > 4 * std::max<std::int64_t>(below, 2) ? highest : 255;
}

}  // namespace lake::tracking
