#include "lake/gait/rolling_shutter.h"

#include <algorithm>
#include <cmath>

#include "lake/dynamics/path_smoother.h"

namespace lake::gait {
namespace {

// A marker's detections, each at the time at which its row was read.
dynamics::SeenPath SeenAtRowTimes(const motion::MarkerRecording& recording, const motion::MarkerTrack& marker,
                                  const RollingShutter& shutter) {
  constexpr double kUnknownSigma_px = 0.1;
  dynamics::SeenPath seen = dynamics::UnseenPath(2, recording.time_s);
  for (std::size_t i = 0; i < recording.Frames(); ++i) {
    const motion::MarkerSample& sample = marker.samples[i];
    if (sample.status != motion::SampleStatus::kDetected) continue;
    seen.See(i, sample.position, sample.sigma > 0 ? sample.sigma : kUnknownSigma_px);
    seen.time_s[i] += shutter.DelayS(sample.position);
  }
  return seen;
}

void MoveToFrameTimes(const motion::MarkerRecording& recording, const RollingShutter& shutter,
                      motion::MarkerTrack& marker) {
  constexpr std::ptrdiff_t kLeastDetections = 8;  // for a path
  const dynamics::SeenPath seen = SeenAtRowTimes(recording, marker, shutter);
  if (std::ranges::count_if(seen.sigma, [](double sigma) { return sigma > 0; }) < kLeastDetections) return;
  dynamics::LearningOptions options;
  options.trust = dynamics::SigmaTrust::kScale;
  const dynamics::SmoothedPath path = dynamics::LearnAndSmooth(seen, dynamics::PersonPrior(1), options);
  for (std::size_t i = 0; i < recording.Frames(); ++i) {
    if (!seen.IsSeen(i)) continue;
    const double back_s = recording.time_s[i] - seen.time_s[i];
    const dynamics::PathPoint& point = path.point[i];
    marker.samples[i].position += (back_s * point.velocity + back_s * back_s / 2 * point.acceleration).head<2>();
  }
}

}  // namespace

RollingShutter ShutterOf(double readout_s, int width_px, int height_px, int rotation_deg, bool mirrored) {
  // Where the sensor's downward direction points in the picture as shown.
  const double w = 1.0 / width_px, h = 1.0 / height_px, sideways_s = mirrored ? -readout_s : readout_s;
  switch (rotation_deg) {
    case 90:
      return {-sideways_s, {w, 0}};
    case 180:
      return {-readout_s, {0, h}};
    case 270:
      return {sideways_s, {w, 0}};
    default:
      return {readout_s, {0, h}};
  }
}

motion::MarkerRecording AtFrameTimes(const motion::MarkerRecording& recording, const RollingShutter& shutter) {
  if (shutter.readout_s == 0) return recording;
  motion::MarkerRecording moved = recording;
  for (motion::MarkerTrack& marker : moved.markers) MoveToFrameTimes(recording, shutter, marker);
  return moved;
}

}  // namespace lake::gait
