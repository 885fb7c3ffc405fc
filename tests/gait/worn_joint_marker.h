// An exoskeleton's joint beside the knee of a recorded or drawn leg.
#pragma once

#include <Eigen/Core>
#include <random>

#include "lake/motion/marker_recording.h"

namespace lake {

// Adds a marker `exo_knee` at an offset from the knee in the shank's frame, x anterior, y from ankle to knee, mm. y of
// the plane is up, and the person faces +x (forward 1) or −x (−1). `noise_mm` is its own, beside the knee's; SD per
// axis.
inline void AddWornJoint(const Eigen::Vector2d& offset_mm, double forward, motion::MarkerRecording& recording,
                         double noise_mm = 0) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 1);
  motion::MarkerTrack joint = *recording.Find("knee");
  joint.name = "exo_knee";
  const motion::MarkerTrack& ankle = *recording.Find("ankle");
  for (std::size_t i = 0; i < joint.samples.size(); ++i) {
    Eigen::Vector2d& place = joint.samples[i].position;
    const Eigen::Vector2d up = (place - ankle.samples[i].position).normalized(),
                          anterior = forward * Eigen::Vector2d(up.y(), -up.x());
    place += offset_mm.x() * anterior + offset_mm.y() * up;
    place += noise_mm * Eigen::Vector2d(noise(random), noise(random));
  }
  recording.markers.push_back(joint);
}

}  // namespace lake
