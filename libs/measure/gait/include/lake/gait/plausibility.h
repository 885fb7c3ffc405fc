// What a person's leg can do: a result beyond that is an error, never a table.
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
  double most_knee_sigma_deg = 10;         // root mean square; of a knee that could be anywhere: 40°
  double most_outliers = 0.25;             // share of a marker's detections that the fit does not explain
  double leg_mm = 850;                     // ankle to hip; stands in for a scale where there is none
  std::string ways_out = LegFitOptions().ways_out;  // for messages
};

// Throws Error naming what is beyond which limit and in which frames. Speeds and accelerations are those of the
// trajectory's known samples, all its markers, over a twentieth of a second.
void CheckPlausible(const motion::LegMotion& motion, const motion::MarkerRecording& trajectory,
                    const PlausibilityLimits& limits = {});

// The same, and whether the fit explains what was seen.
void CheckPlausible(const LegFitResult& result, const PlausibilityLimits& limits = {});

}  // namespace lake::gait
