#include "lake/tracking/sigma_calibration.h"

#include <cmath>
#include <optional>

#include "lake/core/statistics.h"
#include "local_path.h"

namespace lake::tracking {
namespace {

constexpr std::size_t kHalfWindow = 4;
constexpr double kFastPx = 0.5;  // per usual frame
// What is frozen at rest over what moves: 0.57 to 0.78 on rendered recordings of known truth (x264, medium and
// veryfast).
constexpr double kAtRest = 0.65;
struct Scatter {
  std::vector<double> residuals;  // px, of both axes, scaled to the deviation of one sample
  std::vector<double> sigmas;     // px, of the fits

  void Add(const Eigen::Vector2d& residual, double sigma) {
    residuals.insert(residuals.end(), {residual.x(), residual.y()});
    sigmas.push_back(sigma);
  }
};

// What a marker's samples are compared by: the detected ones, in order.
struct Seen {
  const std::vector<motion::MarkerSample>& samples;
  const std::vector<double>& time_s;
  double frame_s;  // between frames, usually
  std::vector<std::size_t> frames;

  double Time(std::size_t k) const { return time_s[frames[k]]; }
  const motion::MarkerSample& Sample(std::size_t k) const { return samples[frames[k]]; }
};

// The residual of the middle of nine detected samples, scaled; nullopt if too many between them are missing.
std::optional<Eigen::Vector2d> Residual(const Seen& seen, std::size_t middle) {
  constexpr int kDegree = 4;
  constexpr double kLongest = 2;  // of nine frames in a row
  if (middle < kHalfWindow || middle + kHalfWindow >= seen.frames.size()) return std::nullopt;
  const double span_s = seen.Time(middle + kHalfWindow) - seen.Time(middle - kHalfWindow);
  if (span_s > kLongest * 2 * kHalfWindow * seen.frame_s) return std::nullopt;
  LocalPath path(kDegree, seen.Time(middle));
  for (std::size_t k = middle - kHalfWindow; k <= middle + kHalfWindow; ++k)
    path.Add(seen.Time(k), seen.Sample(k).position);
  const PathPoint smooth = path.Fit();
  // White noise of variance 1 leaves a residual of variance 1 − the sample's own weight.
  return (seen.Sample(middle).position - smooth.position) / std::sqrt(1 - smooth.own_weight);
}

bool IsFast(const Seen& seen, std::size_t k) {
  const std::size_t a = k > 0 ? k - 1 : k, b = std::min(k + 1, seen.frames.size() - 1);
  return a != b && (seen.Sample(b).position - seen.Sample(a).position).norm() >
                       kFastPx * (seen.Time(b) - seen.Time(a)) / seen.frame_s;
}

// The standard deviation of the residuals, those beyond four robust deviations left out.
double TrimmedDeviation(const std::vector<double>& residuals) {
  const double limit = 4 * RobustDeviation(residuals);
  std::vector<double> kept;
  for (const double residual : residuals)
    if (std::abs(residual) <= limit) kept.push_back(residual);
  return RootMeanSquare(kept);
}

}  // namespace

SigmaCalibration CalibrateSigmas(motion::MarkerRecording& recording) {
  constexpr std::size_t kEnough = 60;
  const double frame_s = MedianInterval(recording.time_s);
  std::vector<Seen> markers;
  for (const motion::MarkerTrack& marker : recording.markers) {
    markers.push_back({marker.samples, recording.time_s, frame_s, {}});
    for (std::size_t i = 0; i < marker.samples.size(); ++i)
      if (marker.samples[i].status == motion::SampleStatus::kDetected) markers.back().frames.push_back(i);
  }
  Scatter fast, all;
  for (const Seen& seen : markers)
    for (std::size_t k = 0; k < seen.frames.size(); ++k) {
      const auto residual = Residual(seen, k);
      if (!residual) continue;
      all.Add(*residual, seen.Sample(k).sigma);
      if (IsFast(seen, k)) fast.Add(*residual, seen.Sample(k).sigma);
    }
  const Scatter& scatter = fast.sigmas.size() < kEnough ? all : fast;
  if (scatter.sigmas.size() < kEnough) return {};

  SigmaCalibration calibration;
  calibration.fit_px = RootMeanSquare(scatter.sigmas);
  calibration.scatter_px = TrimmedDeviation(scatter.residuals);
  calibration.compression_px =
      std::sqrt(std::max(0.0, std::pow(calibration.scatter_px, 2) - std::pow(calibration.fit_px, 2)));
  for (std::size_t m = 0; m < markers.size(); ++m)
    for (std::size_t k = 0; k < markers[m].frames.size(); ++k) {
      const double added = calibration.compression_px * (IsFast(markers[m], k) ? 1 : kAtRest);
      double& sigma = recording.markers[m].samples[markers[m].frames[k]].sigma;
      sigma = std::hypot(sigma, added);
    }
  return calibration;
}

}  // namespace lake::tracking
