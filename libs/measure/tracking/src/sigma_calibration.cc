#include "lake/tracking/sigma_calibration.h"

#include <array>
#include <cmath>
#include <optional>

#include "lake/core/statistics.h"

namespace lake::tracking {
namespace {

constexpr std::size_t kHalfWindow = 4;
constexpr double kFastPx = 0.5;  // per frame
// What is frozen at rest over what moves: 0.57 to 0.78 on rendered recordings of known truth (x264, medium and
// veryfast).
constexpr double kAtRest = 0.65;
// Weights of the value at the centre of a fourth-degree polynomial through nine samples (Savitzky & Golay 1964, table).
constexpr std::array<double, 9> kSmooth = {15. / 429,  -55. / 429, 30. / 429,  135. / 429, 179. / 429,
                                           135. / 429, 30. / 429,  -55. / 429, 15. / 429};

struct Scatter {
  std::vector<double> residuals;  // px, of both axes, scaled to the deviation of one sample
  std::vector<double> sigmas;     // px, of the fits

  void Add(const Eigen::Vector2d& residual, double sigma) {
    residuals.insert(residuals.end(), {residual.x(), residual.y()});
    sigmas.push_back(sigma);
  }
};

// The residual of the middle of nine detected samples, scaled; nullopt if one is missing.
std::optional<Eigen::Vector2d> Residual(const std::vector<motion::MarkerSample>& samples, std::size_t middle) {
  if (middle < kHalfWindow || middle + kHalfWindow >= samples.size()) return std::nullopt;
  Eigen::Vector2d smooth(0, 0);
  for (std::size_t i = 0; i < kSmooth.size(); ++i) {
    const motion::MarkerSample& sample = samples[middle - kHalfWindow + i];
    if (sample.status != motion::SampleStatus::kDetected) return std::nullopt;
    smooth += kSmooth[i] * sample.position;
  }
  // White noise of variance 1 leaves a residual of variance 1 − the centre's own weight.
  return (samples[middle].position - smooth) / std::sqrt(1 - kSmooth[kHalfWindow]);
}

bool IsFast(const std::vector<motion::MarkerSample>& samples, std::size_t i) {
  const std::size_t a = i > 0 && samples[i - 1].IsKnown() ? i - 1 : i,
                    b = i + 1 < samples.size() && samples[i + 1].IsKnown() ? i + 1 : i;
  return a != b && (samples[b].position - samples[a].position).norm() > kFastPx * static_cast<double>(b - a);
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
  Scatter fast, all;
  for (const motion::MarkerTrack& marker : recording.markers)
    for (std::size_t i = 0; i < marker.samples.size(); ++i) {
      const auto residual = Residual(marker.samples, i);
      if (!residual) continue;
      all.Add(*residual, marker.samples[i].sigma);
      if (IsFast(marker.samples, i)) fast.Add(*residual, marker.samples[i].sigma);
    }
  const Scatter& scatter = fast.sigmas.size() < kEnough ? all : fast;
  if (scatter.sigmas.size() < kEnough) return {};

  SigmaCalibration calibration;
  calibration.fit_px = RootMeanSquare(scatter.sigmas);
  calibration.scatter_px = TrimmedDeviation(scatter.residuals);
  calibration.compression_px =
      std::sqrt(std::max(0.0, std::pow(calibration.scatter_px, 2) - std::pow(calibration.fit_px, 2)));
  for (motion::MarkerTrack& marker : recording.markers) {
    std::vector<double> added;
    for (std::size_t i = 0; i < marker.samples.size(); ++i)
      added.push_back(calibration.compression_px * (IsFast(marker.samples, i) ? 1 : kAtRest));
    for (std::size_t i = 0; i < marker.samples.size(); ++i)
      if (marker.samples[i].IsKnown()) marker.samples[i].sigma = std::hypot(marker.samples[i].sigma, added[i]);
  }
  return calibration;
}

}  // namespace lake::tracking
