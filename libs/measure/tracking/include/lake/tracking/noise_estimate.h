// The image noise of a video, from what changes between frames where nothing moves.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "lake/tracking/blob_fit.h"

namespace lake::tracking {

// Collects differences of successive frames by grey level; half their variance is the noise's (Foi et al. 2008 for the
// Poisson–Gaussian model, doi:10.1109/TIP.2008.2001399). What moves is left out by its size. Compression removes noise
// from still parts, so the result is a lower bound there; fits scale it by their own residuals. Light and gain change:
// after the first frames a pair is looked at every now and then, and what is older counts half as much each time.
class NoiseEstimator {
 public:
  // Takes every frame, in order. Returns whether something was learnt from it.
  bool Add(const cv::Mat& grey);
  bool IsBeginning() const { return frames_ <= kFirst; }

  // The line variance(level) through the levels seen, at least that of rounding to whole levels.
  NoiseModel Estimate() const;

  // The grey level at which the video saturates, as seen so far: the highest on which pixels pile up; 255 if there is
  // none.
  double SaturationLevel() const;

 private:
  static constexpr std::int64_t kFirst = 6;  // frames, all of which are looked at
  static constexpr int kBins = 16, kMaxDifference = 64;
  void KeepRows(const cv::Mat& grey);
  void CountLevels(const cv::Mat& grey);
  void CountDifferences(const cv::Mat& grey, int step);

  cv::Mat previous_;  // its rows that are looked at
  std::int64_t frames_ = 0;
  std::array<std::array<std::int64_t, kMaxDifference>, kBins> differences_ = {};  // counts of |difference| by level
  std::array<std::int64_t, 256> levels_ = {};                                     // counts of the brightest levels
};

}  // namespace lake::tracking
