#include "lake/gait/rolling_shutter.h"

#include <cmath>

namespace lake::gait {
namespace {

struct TimedPlace {
  double time_s;
  Eigen::Vector2d position;
};

// Lagrange's polynomial through the places.
Eigen::Vector2d ValueAt(const std::vector<TimedPlace>& places, double time_s) {
  Eigen::Vector2d value = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < places.size(); ++i) {
    double weight = 1;
    for (std::size_t k = 0; k < places.size(); ++k)
      if (k != i) weight *= (time_s - places[k].time_s) / (places[i].time_s - places[k].time_s);
    value += weight * places[i].position;
  }
  return value;
}

// The sample and up to two detected ones on each side, as long as they are near in time.
std::vector<TimedPlace> PlacesAround(const motion::MarkerRecording& recording, const motion::MarkerTrack& marker,
                                     std::size_t i, const RollingShutter& shutter) {
  constexpr int kEachSide = 2;
  constexpr double kFarthest_s = 0.1;  // a leg's path is a parabola for about as long
  const auto place = [&](std::size_t k) {
    const Eigen::Vector2d& position = marker.samples[k].position;
    return TimedPlace{recording.time_s[k] + shutter.DelayS(position), position};
  };
  std::vector<TimedPlace> places = {place(i)};
  for (const bool forward : {false, true}) {
    std::size_t last = i;
    for (int found = 0; found < kEachSide;) {
      std::size_t next = last;
      bool seen = false;
      for (std::size_t step = 1; !seen; ++step) {
        if (forward ? last + step >= marker.samples.size() : last < step) break;
        next = forward ? last + step : last - step;
        if (std::abs(recording.time_s[next] - recording.time_s[last]) > kFarthest_s) break;
        seen = marker.samples[next].status == motion::SampleStatus::kDetected;
      }
      if (!seen) break;
      places.push_back(place(next));
      last = next;
      ++found;
    }
  }
  return places;
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
  for (std::size_t m = 0; m < recording.markers.size(); ++m)
    for (std::size_t i = 0; i < recording.Frames(); ++i)
      if (recording.markers[m].samples[i].status == motion::SampleStatus::kDetected)
        moved.markers[m].samples[i].position =
            ValueAt(PlacesAround(recording, recording.markers[m], i, shutter), recording.time_s[i]);
  return moved;
}

}  // namespace lake::gait
