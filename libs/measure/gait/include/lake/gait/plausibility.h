// What a person's leg can do: FitLeg leaves out what is beyond it, frame by frame, and says so.
#pragma once

#include "lake/gait/leg_fit.h"
#include "lake/motion/leg_motion.h"
#include "lake/motion/marker_recording.h"

namespace lake::gait {

// Wide on purpose: no trial of standing up, walking, squatting or jumping is near them, and the marker vectors' angle
// may differ from the joint's by some 15°.
struct PlausibilityLimits {
  double least_knee_deg = -40;             // hyperextension ends at about −20° (genu recurvatum)
  double most_knee_deg = 175;              // heel against the thigh: about 160°
  double most_knee_deg_s = 2000;           // standing up 200, sprinting 1100, kicking a ball 1500
  double most_speed_mm_s = 12e3;           // of a marker; standing up 1e3, a foot in running 10e3
  double most_acceleration_mm_s2 = 150e3;  // about 15 g; standing up 5e3, a shank at heel strike in running 100e3
  double shortest = 0.5, longest = 1.5;    // of a segment in one frame over its median; skin moves by some per cent
  double most_knee_sigma_deg = 10;         // of a knee that could be anywhere: 40°
  double leg_mm = 850;                     // ankle to hip; stands in for a scale where there is none
  std::string ways_out = LegFitOptions().ways_out;  // for messages
};

// Values beyond the limits.
struct Implausible {
  std::string what;                  // "the knee angle is -154 deg at worst, a person's is between …"
  std::vector<char> at;              // by frame of the recording: 1 where it is
  std::vector<std::string> markers;  // whose places it comes from, by their names in the leg; none: that of no one
};

// Speeds and accelerations are those of the trajectory's known samples, all its markers, over a twentieth of a second.
std::vector<Implausible> FindImplausible(const motion::LegMotion& motion, const motion::MarkerRecording& trajectory,
                                         const LegMarkers& names, const PlausibilityLimits& limits = {});

// The same of the trunk's length: something else was taken for the waist's marker. One near the hip's may move as much
// on the skin, so no recording is refused for it.
std::vector<Implausible> FindImplausibleTrunk(const motion::LegMotion& motion, const LegMarkers& names,
                                              const PlausibilityLimits& limits = {});

// Throws Error naming what is beyond which limit and in which frames.
void CheckPlausible(const motion::LegMotion& motion, const motion::MarkerRecording& trajectory,
                    const PlausibilityLimits& limits = {});

// "3, 8, 13 to 15": some of the frames.
std::string FramesOf(const std::vector<std::int64_t>& frame, const std::vector<char>& at);

}  // namespace lake::gait
