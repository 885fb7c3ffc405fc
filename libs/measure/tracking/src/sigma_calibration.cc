#include "lake/tracking/sigma_calibration.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "lake/core/statistics.h"
#include "lake/dynamics/marker_path.h"
#include "leg_scale.h"

namespace lake::tracking {
namespace {

constexpr std::size_t kEnough = 60;  // samples

// What coding adds to the error of markers, over their fits' sigmas, in quadrature:
//
//     at_usual_bits · scatter^of_scatter · (bits per pixel / usual_bits)^−of_bits,
//
// `scatter` what scatters in the distances of moving neighbours beyond the fits' sigmas, over these. The exponent of
// the scatter is less than 1: distances hold the skin's tremor too, which is as white as errors, and errors that last
// for some frames look like slow changes. By robust regression on the markers of 593 rendered recordings of people and
// of drawn motions (24 to 120 Hz, 0.001 to 1.2 bits per pixel), the root mean square of what it leaves in the first
// factor: a marker's error is within a factor of 1.28 (1 SD), each recording's by the others. Where the scatter shows
// coding at all, what holds still at rest errs by the whole of it at least.
struct CodingError {
  double at_usual_bits, usual_bits, of_scatter, of_bits;
};

// H.264's stands for codecs that were not measured.
CodingError CodingErrorOf(const video::VideoInfo& video) {
  if (video.coded_frame_by_frame) return {1.05, 0.2, 0, 0.37};
  if (video.codec == "hevc") return {1.95, 0.01, 0.6, 0.1};
  if (video.codec == "mpeg4") return {2.86, 0.04, 0, 0.22};
  return {2.08, 0.01, 0.45, 0.11};
}

double AddedOverFit(const video::VideoInfo& video, double scatter, bool holds_still) {
  constexpr double kMostScatter = 10;  // 95 % of the markers had less; more is the person's
  if (video.is_lossless) return 0;
  const CodingError error = CodingErrorOf(video);
  const double added = error.at_usual_bits * std::pow(std::min(scatter, kMostScatter), error.of_scatter) *
                       std::pow(video.bits_per_pixel.value_or(error.usual_bits) / error.usual_bits, -error.of_bits);
  return holds_still && error.of_scatter > 0 ? std::max(added, scatter) : added;
}

// Of what compression adds to the error: what smoothing does not take away, in 84 rendered films of people 0.74 (0.4
// where coding was strong, 0.85 where it was weak).
constexpr double kLasting = 0.7;

using Path = std::vector<dynamics::PathSample>;

double MedianSigma(std::span<const Path> paths) {
  std::vector<double> sigmas;
  for (const Path& path : paths)
    for (const dynamics::PathSample& sample : path) sigmas.push_back(sample.sigma);
  return Median(std::move(sigmas));
}

std::size_t Samples(std::span<const Path> paths) {
  std::size_t samples = 0;
  for (const Path& path : paths) samples += path.size();
  return samples;
}

Path Detected(const motion::MarkerTrack& marker, const std::vector<double>& time_s) {
  Path path;
  for (std::size_t i = 0; i < marker.samples.size(); ++i) {
    const motion::MarkerSample& sample = marker.samples[i];
    if (sample.status == motion::SampleStatus::kDetected) path.push_back({time_s[i], sample.position, sample.sigma});
  }
  return path;
}

double UsualInterval(const Path& path) {
  std::vector<double> times_s;
  for (const dynamics::PathSample& sample : path) times_s.push_back(sample.time_s);
  return MedianInterval(times_s);  // longer than the recording's where a converter repeated frames
}

// Half a pixel per frame: what is slower rests, and coding repeats its error, which does not show.
constexpr double kFast_px = 0.5;

Path Moving(const Path& path) {
  if (path.size() < 2) return {};
  const double frame_s = UsualInterval(path);
  Path moving;
  for (std::size_t k = 0; k < path.size(); ++k) {
    const dynamics::PathSample &before = path[k > 0 ? k - 1 : k], &after = path[std::min(k + 1, path.size() - 1)];
    if ((after.position - before.position).norm() > kFast_px * (after.time_s - before.time_s) / frame_s)
      moving.push_back(path[k]);
  }
  return moving;
}

bool IsIn(const Path& path, double time_s) {
  return std::ranges::binary_search(path, time_s, {}, &dynamics::PathSample::time_s);
}

// The distances of each marker to the next while either moves, √2 times smaller, so that they err as markers do: they
// stay what they are however quickly the leg moves, and what scatters in them is error. Both axes hold the same.
std::vector<Path> Distances(const std::vector<Path>& detected, const std::vector<Path>& moving) {
  std::vector<Path> distances;
  for (std::size_t m = 0; m + 1 < detected.size(); ++m) {
    Path& path = distances.emplace_back();
    auto next = detected[m + 1].begin();
    for (const dynamics::PathSample& one : detected[m]) {
      while (next != detected[m + 1].end() && next->time_s < one.time_s) ++next;
      if (next == detected[m + 1].end()) break;
      if (next->time_s > one.time_s || !(IsIn(moving[m], one.time_s) || IsIn(moving[m + 1], one.time_s))) continue;
      const double distance = (one.position - next->position).norm() / std::numbers::sqrt2;
      path.push_back({one.time_s, {distance, distance}, std::hypot(one.sigma, next->sigma) / std::numbers::sqrt2});
    }
  }
  return distances;
}

// Beyond the fits' sigmas. A path hides what looks like quick movement, a distance what neighbours share.
double ExtraScatter(const std::vector<Path>& paths, const std::vector<Path>& distances, double mm_per_px) {
  return std::max(dynamics::LearnMotion(paths, mm_per_px).extra_sigma,
                  Samples(distances) < kEnough ? 0 : dynamics::LearnMotion(distances, mm_per_px).extra_sigma);
}

// Whether markers hold still at rest, as a mechanism's do, so that all that scatters in movement is coding's, and
// smoothing may take it away: a person jitters at rest too. By second differences there, of four in five: of drawn
// motions those of four in five recordings scatter by less than this, or than the fits' own sigma; of people's those of
// one in fifteen. Coding that errs by more than a person jitters at rest holds a person still too, and shows neither.
bool HoldsStill(std::span<const Path> paths, const SigmaCalibration& found, double mm_per_px) {
  constexpr double kStill = 0.15, kUnequal = 1.5, kMost = 0.8, kMostOfNormal = 1.28;  // that quantile in deviations
  constexpr double kJitterAtRest_mm = 0.2;
  if (found.scatter_px * mm_per_px > kJitterAtRest_mm) return false;
  std::vector<double> bends_px;
  for (const Path& path : paths) {
    if (path.size() < 3) continue;
    const double frame_s = UsualInterval(path);
    for (std::size_t k = 1; k + 1 < path.size(); ++k) {
      const Eigen::Vector2d in = path[k].position - path[k - 1].position, out = path[k + 1].position - path[k].position;
      if (path[k + 1].time_s - path[k - 1].time_s > 2 * kUnequal * frame_s || (in + out).norm() > 2 * kFast_px)
        continue;
      const Eigen::Vector2d bend = (out - in) / std::sqrt(6);  // of white noise: its deviation
      bends_px.insert(bends_px.end(), {std::abs(bend.x()), std::abs(bend.y())});
    }
  }
  return bends_px.size() >= 2 * kEnough &&
         Quantile(std::move(bends_px), kMost) / kMostOfNormal < std::max(kStill * found.scatter_px, found.fit_px);
}

}  // namespace

double UsualErrorOverFit(const video::VideoInfo& video) {
  constexpr double kUsualScatter = 4.2;  // the median of H.264's
  return std::hypot(1, AddedOverFit(video, kUsualScatter, false));
}

SigmaCalibration CalibrateSigmas(const video::VideoInfo& video, motion::MarkerRecording& recording) {
  std::vector<Path> detected, moving;
  for (const motion::MarkerTrack& marker : recording.markers) {
    detected.push_back(Detected(marker, recording.time_s));
    moving.push_back(Moving(detected.back()));
  }
  const std::vector<Path>& compared = Samples(moving) >= kEnough ? moving : detected;
  if (Samples(compared) < kEnough) return {};
  const double mm_per_px = MillimetresPerPx(recording),
               extra_px = ExtraScatter(compared, Distances(detected, moving), mm_per_px);
  SigmaCalibration calibration;
  calibration.fit_px = MedianSigma(compared);
  calibration.scatter_px = std::hypot(calibration.fit_px, extra_px);
  const bool holds_still = HoldsStill(detected, calibration, mm_per_px);
  std::vector<double> added, sigmas;
  for (std::size_t m = 0; m < recording.markers.size(); ++m) {
    if (detected[m].empty()) continue;
    const double fit_px = MedianSigma(std::span(&detected[m], 1)),
                 added_px = fit_px * AddedOverFit(video, extra_px / fit_px, holds_still);
    for (motion::MarkerSample& sample : recording.markers[m].samples)
      if (sample.status == motion::SampleStatus::kDetected) sample.sigma = std::hypot(sample.sigma, added_px);
    for (const dynamics::PathSample& sample : compared[m]) {
      added.push_back(added_px);
      sigmas.push_back(std::hypot(sample.sigma, added_px));
    }
  }
  calibration.compression_px = RootMeanSquare(added);
  if (!holds_still)
    calibration.lasting_share = kLasting * std::pow(calibration.compression_px / RootMeanSquare(sigmas), 2);
  return calibration;
}

}  // namespace lake::tracking
