// What the customary filter takes of the movement itself, beside the noise. Not part of the interface.
#pragma once

#include <vector>

#include "lake/motion/leg_motion.h"

namespace lake::gait {

// Adds to the knee angle's standard deviations what a filter takes of the angle: by frame, that of the fit's curves
// after the filter less that before it (deg, NaN where not known). Throws Error for a cutoff that takes a considerable
// share of the angle's variance over time.
void AccountForFilterLoss(const std::vector<double>& taken_deg, double cutoff_hz, motion::LegMotion& motion);

}  // namespace lake::gait
