// The image noise of a video, from what changes between frames where nothing moves.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "lake/tracking/blob_fit.h"

namespace lake::tracking {

// Collects differences of successive frames by grey level; half their variance is the noise's (Foi et al. 2008 for the
// Poisson–Gaussian model, doi:10.1109/TIP.2008.2001399). What moves is left out by its size. Compression removes noise
// from still parts, so the result is a lower bound there; fits scale it by their own residuals.
class NoiseEstimator {
 public:
  void Add(const cv::Mat& grey);
  int Frames() const { return frames_; }

  // The line variance(level) through the levels seen, at least that of rounding to whole levels.
  NoiseModel Estimate() const;

  // The grey level at which the video saturates: the highest that occurs, if it occurs often; 255 otherwise.
  double SaturationLevel() const;

 private:
  static constexpr int kBins = 16, kMaxDifference = 64;
  cv::Mat previous_;
  int frames_ = 0;
  std::array<std::array<std::int64_t, kMaxDifference>, kBins> differences_ = {};  // counts of |difference| by level
  std::array<std::int64_t, 256> levels_ = {};
};

}  // namespace lake::tracking
