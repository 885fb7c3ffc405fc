#include "lake/tracking/sigma_calibration.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lake/core/statistics.h"
#include "local_path.h"

namespace lake::tracking {
namespace {

constexpr double kFastPx = 0.5;  // per usual frame

// Half the window that a path is smooth in: as long at any frame rate, but of enough samples.
std::size_t HalfWindow(double frame_s) {
  constexpr double kHalf_s = 0.067;
  constexpr long kFewest = 4;
  return static_cast<std::size_t>(std::max(kFewest, std::lround(kHalf_s / frame_s)));
}

// What compression adds to a fast sample's error, from what it adds to the scatter. Blocks are shifted by quarters of a
// pixel, which leaves up to 0.07 px; more than that is what the encoder did not put right for want of bits, and that
// stays for some frames, so that a smooth path goes along with it. Of rendered recordings (x264 medium and veryfast,
// x265, crf 17 to 40, 60 and 120 Hz) the error over the scatter was 1.0 at 0.04 and 0.055 px, 1.05 to 1.08 at 0.063,
// 1.2 at 0.08 and 1.3 at 0.09 to 0.1.
double WithSlowPart(double scatter_px) {
  constexpr double kNone_px = 0.055, kRise_px = 0.12, kMost = 2;
  return scatter_px * std::clamp(1 + (scatter_px - kNone_px) / kRise_px, 1.0, kMost);
}

// What is frozen at rest over what moves: 0.57 to 0.78 where compression is weak; where it is strong, nothing is
// refined afterwards.
double ShareAtRest(double scatter_px) {
  constexpr double kLeast = 0.65, kWhole_px = 0.075;
  return std::clamp(scatter_px / kWhole_px, kLeast, 1.0);
}

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

// The residual of the middle of a window of detected samples, scaled; nullopt if too many between them are missing.
std::optional<Eigen::Vector2d> Residual(const Seen& seen, std::size_t middle) {
  constexpr int kDegree = 4;
  constexpr double kLongest = 2;  // of as many frames in a row
  const std::size_t half = HalfWindow(seen.frame_s);
  if (middle < half || middle + half >= seen.frames.size()) return std::nullopt;
  const double span_s = seen.Time(middle + half) - seen.Time(middle - half);
  if (span_s > kLongest * 2 * static_cast<double>(half) * seen.frame_s) return std::nullopt;
  LocalPath path(kDegree, seen.Time(middle));
  for (std::size_t k = middle - half; k <= middle + half; ++k) path.Add(seen.Time(k), seen.Sample(k).position);
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

constexpr std::size_t kEnough = 60;  // samples

// An encoder leaves a marker displaced only as long as what that leaves in its picture is less than it quantises, so
// what it displaces stays within a multiple of the fits' own sigma, which that coarseness makes larger too: the error
// was 3.2 to 6.0 times the fits' sigma, of all markers, on rendered recordings (x264 medium and veryfast, x265, crf 15
// to 40, 24 to 240 Hz, radii of 3 and 4 px). A person's jitter knows no such bound.
constexpr double kMostOfFits = 5.5;

// What compression adds to the scatter; nullopt where too few samples show it.
std::optional<SigmaCalibration> CompressionIn(const Scatter& scatter) {
  if (scatter.sigmas.size() < kEnough) return std::nullopt;
  SigmaCalibration found;
  found.fit_px = RootMeanSquare(scatter.sigmas);
  found.scatter_px = TrimmedDeviation(scatter.residuals);
  found.compression_px = std::sqrt(std::max(0.0, std::pow(found.scatter_px, 2) - std::pow(found.fit_px, 2)));
  return found;
}

void Append(const Scatter& more, Scatter& all) {
  all.residuals.insert(all.residuals.end(), more.residuals.begin(), more.residuals.end());
  all.sigmas.insert(all.sigmas.end(), more.sigmas.begin(), more.sigmas.end());
}

}  // namespace

SigmaCalibration CalibrateSigmas(motion::MarkerRecording& recording) {
  const double frame_s = MedianInterval(recording.time_s);
  std::vector<Seen> markers;
  for (const motion::MarkerTrack& marker : recording.markers) {
    markers.push_back({marker.samples, recording.time_s, frame_s, {}});
    for (std::size_t i = 0; i < marker.samples.size(); ++i)
      if (marker.samples[i].status == motion::SampleStatus::kDetected) markers.back().frames.push_back(i);
  }
  std::vector<Scatter> fast(markers.size());
  Scatter all_fast, all;
  for (std::size_t m = 0; m < markers.size(); ++m) {
    for (std::size_t k = 0; k < markers[m].frames.size(); ++k) {
      const auto residual = Residual(markers[m], k);
      if (!residual) continue;
      all.Add(*residual, markers[m].Sample(k).sigma);
      if (IsFast(markers[m], k)) fast[m].Add(*residual, markers[m].Sample(k).sigma);
    }
    Append(fast[m], all_fast);
  }
  const auto pooled = CompressionIn(all_fast.sigmas.size() < kEnough ? all : all_fast);
  if (!pooled) return {};
  const double most_px = kMostOfFits * pooled->fit_px;

  for (std::size_t m = 0; m < markers.size(); ++m) {
    // A marker of little contrast is displaced farther before the encoder finds it worth a correction. One that is
    // slow stays displaced for some frames, and its smooth path goes along, so its own scatter may show too little.
    const double fast_px = CompressionIn(fast[m]).value_or(*pooled).compression_px;
    const double slow_px = std::max(fast_px, pooled->compression_px);
    for (std::size_t k = 0; k < markers[m].frames.size(); ++k) {
      const double added_px =
          IsFast(markers[m], k) ? WithSlowPart(fast_px) : ShareAtRest(slow_px) * WithSlowPart(slow_px);
      double& sigma = recording.markers[m].samples[markers[m].frames[k]].sigma;
      sigma = std::hypot(sigma, std::min(added_px, most_px));
    }
  }
  SigmaCalibration calibration = *pooled;
  calibration.compression_px = std::min(WithSlowPart(pooled->compression_px), most_px);
  return calibration;
}

}  // namespace lake::tracking
