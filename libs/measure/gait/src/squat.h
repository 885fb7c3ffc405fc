// The events of squats.
#pragma once

#include <vector>

#include "lake/gait/leg_fit.h"

namespace lake::gait {

// Descent, bottom and standing of each rise without a seat (FoundStsEvents): the hip is lowest at the bottom, and comes
// down, or goes up, at more than 5 % of its peak speed between the others. Their SDs are not known. A squat that the
// recording cuts off is left out, and so is one in which the ankle rises as in a jump.
std::vector<motion::StsEvent> FindSquats(const LegFitResult& leg);

}  // namespace lake::gait
