// Drawn walks (lake/synth/walk_motion.h) as recordings with noise.
#pragma once

#include <Eigen/Core>
#include <random>

#include "lake/motion/marker_recording.h"
#include "lake/synth/walk_motion.h"

namespace lake {

struct DrawnWalkOptions {
  double rate_hz = 100, length_s = 6, stride_s = 1.1, stride_mm = 1300, stance = 0.62;
  double direction = 1;       // 1 towards +x, −1 towards −x
  bool is_treadmill = false;  // the hip stays
  bool is_backward = false;   // the same, played backward
  double noise_mm = 0;
  unsigned seed = 1;
};

// Markers ankle, knee, hip, waist, heel, toe, other_ankle, other_heel, other_toe in the plane frame, mm. Heel strikes
// are at (k + 0.3) strides of stride_s, toe-offs at `stance` after them, those of the other leg half a stride later.
inline motion::MarkerRecording DrawWalk(const DrawnWalkOptions& o) {
  motion::MarkerRecording recording;
  recording.unit = motion::LengthUnit::kMm;
  for (const char* name : {"ankle", "knee", "hip", "waist", "heel", "toe", "other_ankle", "other_heel", "other_toe"})
    recording.markers.push_back({name, {}});
  std::mt19937 random(o.seed);
  std::normal_distribution<double> noise(0, 1);
  const auto frames = static_cast<int>(o.length_s * o.rate_hz);
  for (int i = 0; i < frames; ++i) {
    const double t = i / o.rate_hz, at = (o.is_backward ? o.length_s - t : t) / o.stride_s - 0.3;
    const auto pose = synth::DrawWalk(at, {.stride_s = o.stride_s, .stride_mm = o.stride_mm, .stance = o.stance});
    recording.frame.push_back(i);
    recording.time_s.push_back(t);
    for (motion::MarkerTrack& marker : recording.markers) {
      const Eigen::Vector2d& place = pose.at(marker.name);
      const double x = place.x() - (o.is_treadmill ? at * o.stride_mm : 0);
      marker.samples.push_back(
          {Eigen::Vector2d(o.direction * x + o.noise_mm * noise(random), place.y() + o.noise_mm * noise(random)),
           o.noise_mm, motion::SampleStatus::kDetected});
    }
  }
  return recording;
}

}  // namespace lake
