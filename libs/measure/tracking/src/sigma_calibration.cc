#include "lake/tracking/sigma_calibration.h"

#include <algorithm>
#include <cmath>

#include "lake/core/statistics.h"
#include "lake/dynamics/marker_path.h"
#include "leg_scale.h"

namespace lake::tracking {
namespace {

constexpr std::size_t kEnough = 60;  // samples

// The error of coded markers over their fits' sigmas,
//
//     at_usual_bits · scatter^of_scatter · (bits per pixel / usual_bits)^of_bits,
//
// `scatter` what the motion's model leaves to the measurement, over the fits' sigma. The exponent of the scatter is
// less than 1: the model tells errors from motion, but not from the skin's tremor, which is as white, and it takes
// errors that last for some frames for motion. By robust regression on the markers of 593 rendered recordings of people
// and of drawn motions (24 to 120 Hz, 0.001 to 1.2 bits per pixel), the root mean square of what it leaves in the first
// factor: a marker's error is within a factor of 1.28 (1 SD), each recording's by the others.
struct CodingError {
  double at_usual_bits, usual_bits, of_scatter, of_bits;
};

// H.264's stands for codecs that were not measured.
CodingError CodingErrorOf(const video::VideoInfo& video) {
  if (video.coded_frame_by_frame) return {1.5, 0.2, 0, -0.14};
  if (video.codec == "hevc") return {1.92, 0.01, 0.63, -0.07};
  if (video.codec == "mpeg4") return {2.5, 0.04, 0.14, -0.17};
  return {2.22, 0.01, 0.43, -0.1};
}

double ErrorOverFit(const video::VideoInfo& video, double scatter) {
  constexpr double kMostScatter = 10;  // 95 % of the markers had less; more is the person's
  if (video.is_lossless) return 1;
  const CodingError error = CodingErrorOf(video);
  const double bits = video.bits_per_pixel.value_or(error.usual_bits) / error.usual_bits;
  return std::max(1.0, error.at_usual_bits * std::pow(std::min(scatter, kMostScatter), error.of_scatter) *
                           std::pow(bits, error.of_bits));
}

// Of what compression adds to the error: what smoothing does not take away, in 84 rendered films of people 0.74 (0.4
// where coding was strong, 0.85 where it was weak).
constexpr double kLasting = 0.7;

double MedianSigma(const std::vector<dynamics::PathSample>& path) {
  std::vector<double> sigmas;
  for (const dynamics::PathSample& sample : path) sigmas.push_back(sample.sigma);
  return Median(std::move(sigmas));
}

std::size_t Samples(const std::vector<std::vector<dynamics::PathSample>>& paths) {
  std::size_t samples = 0;
  for (const std::vector<dynamics::PathSample>& path : paths) samples += path.size();
  return samples;
}

std::vector<dynamics::PathSample> Detected(const motion::MarkerTrack& marker, const std::vector<double>& time_s) {
  std::vector<dynamics::PathSample> path;
  for (std::size_t i = 0; i < marker.samples.size(); ++i) {
    const motion::MarkerSample& sample = marker.samples[i];
    if (sample.status == motion::SampleStatus::kDetected) path.push_back({time_s[i], sample.position, sample.sigma});
  }
  return path;
}

// What moves by more than half a pixel per frame: at rest coding repeats its error, which does not show.
std::vector<dynamics::PathSample> Moving(const std::vector<dynamics::PathSample>& path) {
  constexpr double kFast_px = 0.5;
  std::vector<double> times_s;
  for (const dynamics::PathSample& sample : path) times_s.push_back(sample.time_s);
  if (path.size() < 2) return {};
  const double frame_s = MedianInterval(times_s);  // longer than the recording's where a converter repeated frames
  std::vector<dynamics::PathSample> moving;
  for (std::size_t k = 0; k < path.size(); ++k) {
    const dynamics::PathSample &before = path[k > 0 ? k - 1 : k], &after = path[std::min(k + 1, path.size() - 1)];
    if ((after.position - before.position).norm() > kFast_px * (after.time_s - before.time_s) / frame_s)
      moving.push_back(path[k]);
  }
  return moving;
}

}  // namespace

double UsualErrorOverFit(const video::VideoInfo& video) {
  constexpr double kUsualScatter = 4.3;  // the median of H.264's
  return ErrorOverFit(video, kUsualScatter);
}

SigmaCalibration CalibrateSigmas(const video::VideoInfo& video, motion::MarkerRecording& recording) {
  std::vector<std::vector<dynamics::PathSample>> detected, moving;
  for (const motion::MarkerTrack& marker : recording.markers) {
    detected.push_back(Detected(marker, recording.time_s));
    moving.push_back(Moving(detected.back()));
  }
  const std::vector<std::vector<dynamics::PathSample>>& compared = Samples(moving) >= kEnough ? moving : detected;
  if (Samples(compared) < kEnough) return {};
  const dynamics::LearntMotion learnt = dynamics::LearnMotion(compared, MillimetresPerPx(recording));
  std::vector<double> fits, added, sigmas;
  for (std::size_t m = 0; m < recording.markers.size(); ++m) {
    if (detected[m].empty()) continue;
    const double fit_px = MedianSigma(detected[m]),
                 error_over_fit = ErrorOverFit(video, std::hypot(learnt.extra_sigma, fit_px) / fit_px),
                 added_px = fit_px * std::sqrt(error_over_fit * error_over_fit - 1);
    for (motion::MarkerSample& sample : recording.markers[m].samples) {
      if (sample.status != motion::SampleStatus::kDetected) continue;
      sample.sigma = std::hypot(sample.sigma, added_px);
    }
    for (const dynamics::PathSample& sample : compared[m]) {
      fits.push_back(sample.sigma);
      added.push_back(added_px);
      sigmas.push_back(std::hypot(sample.sigma, added_px));
    }
  }
  SigmaCalibration calibration;
  calibration.fit_px = Median(std::move(fits));
  calibration.scatter_px = std::hypot(calibration.fit_px, learnt.extra_sigma);
  calibration.compression_px = RootMeanSquare(added);
  calibration.lasting_share = kLasting * std::pow(calibration.compression_px / RootMeanSquare(sigmas), 2);
  return calibration;
}

}  // namespace lake::tracking
