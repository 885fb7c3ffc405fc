// Disturbances of laboratory recordings: a subject who walks in, a second person.
#pragma once

#include <memory>

#include "lake/synth/marker_motion.h"

namespace lake::synth {

// The motion's first pose slides in from behind the subject over `walk_s`, `distance_mm` long, the shank and thigh
// swinging about the hip as one; then the motion begins. It must have a hip, and knee and ankle swing if it has them.
// Throws Error without a hip, UsageError for a time that is not positive.
std::unique_ptr<MarkerMotion> MakeWalkIn(std::shared_ptr<const MarkerMotion> motion, double walk_s,
                                         double distance_mm = 2600);

// Both motions at once; the second person's markers are named other_ankle, … and stand `offset_mm` to the right.
std::unique_ptr<MarkerMotion> MakeTwoPeople(std::shared_ptr<const MarkerMotion> subject,
                                            std::shared_ptr<const MarkerMotion> other, double offset_mm);

}  // namespace lake::synth
