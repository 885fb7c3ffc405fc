// Blobs in a sequence of grey pictures: what the reflective and the colour detector share.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "lake/tracking/blob_search.h"
#include "lake/tracking/marker_detector.h"
#include "lake/tracking/noise_estimate.h"

namespace lake::tracking {

// The part of the frame time during which the shutter is open, from the streaks of fast blobs: each is fitted with
// several assumed exposures, and the one that fits best over all of them is believed.
class ShutterEstimator {
 public:
  static constexpr std::array<double, 6> kCandidates = {0, 0.2, 0.4, 0.6, 0.8, 1.0};

  bool Wants(const Eigen::Vector2d& velocity_px) const;
  void Add(const cv::Mat& grey, const Blob& blob, const Eigen::Vector2d& velocity_px, const BlobFitOptions& options);

  double Fraction() const { return fraction_; }
  bool IsKnown() const { return samples_ >= kEnough; }

 private:
  static constexpr int kEnough = 12, kPlenty = 60;
  int samples_ = 0;
  double fraction_ = 0.5;
  std::array<double, kCandidates.size()> cost_ = {};
};

// Whether a fit is something worth following: compact, with an edge, on a background that the model explains.
bool IsMarkerLike(const BlobFit& fit);

MarkerDetection MakeDetection(const BlobFit& fit);

class BlobFinder {
 public:
  explicit BlobFinder(const DetectorRegion& region) : region_(region) {}

  std::vector<MarkerDetection> Detect(const cv::Mat& grey, std::span<const MarkerPrediction> predictions, Look look);

  ImageFigures Figures() const {
    return {fit_options_.noise, fit_options_.saturation_level,
            shutter_.IsKnown() ? std::optional(shutter_.Fraction()) : std::nullopt};
  }

 private:
  void LearnNoise(const cv::Mat& grey);
  void LearnFromFits(const cv::Mat& grey, std::span<const MarkerPrediction> predictions,
                     const std::vector<std::optional<BlobFit>>& fits);
  void LearnNoiseFromFits(std::vector<double> chi_squares);
  void ScaleNoise(double factor);
  Blob Start(const MarkerPrediction& prediction, const Eigen::Vector2d& place) const;
  double StreakDeviation(const MarkerPrediction& prediction, const Eigen::Vector2d& place) const;
  bool LooksLike(const BlobFit& fit, const MarkerPrediction& prediction) const;
  void FitTogether(const cv::Mat& grey, std::span<const MarkerPrediction> predictions,
                   const std::vector<std::size_t>& members, std::vector<std::optional<BlobFit>>& fits) const;
  std::optional<BlobFit> FitAt(const cv::Mat& grey, const Eigen::Vector2d& place,
                               const MarkerPrediction& prediction) const;
  std::optional<BlobFit> SearchAndFit(const cv::Mat& grey, const MarkerPrediction& prediction) const;
  cv::Rect BoxAround(const cv::Mat& grey, const MarkerPrediction& prediction) const;
  void FindNew(const cv::Mat& grey, const cv::Rect& box, std::span<const MarkerPrediction> predictions,
               std::vector<MarkerDetection>& found);
  std::optional<BlobFit> FitNew(const cv::Mat& grey, const BlobCandidate& candidate) const;
  bool WasRefused(const BlobCandidate& candidate) const;

  DetectorRegion region_;
  BlobFitOptions fit_options_;
  NoiseEstimator noise_;
  ShutterEstimator shutter_;
  double chi_square_ = 1;  // running typical value, by which the noise model is scaled
  double contrast_ = 0;    // running contrast of the blobs followed
  double level_ = 0;       // their running mean level; 0 while none is followed
  int misjudged_ = 0;      // frames in a row in which most fits tell of another noise

  // Candidates that turned out to be no markers. Furniture stays where it is: they are not tried again for a while.
  struct Refusal {
    BlobCandidate candidate;
    int searches_left;
  };
  std::vector<Refusal> refusals_;
};

}  // namespace lake::tracking
