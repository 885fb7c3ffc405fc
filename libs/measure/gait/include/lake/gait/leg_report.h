// The leg fit for the person at the terminal.
#pragma once

#include <string>

#include "lake/gait/leg_fit.h"

namespace lake::gait {

// A line for each segment's length, and one for the range of the knee angle with the markers' noise.
std::string LegFitText(const LegFitResult& result);

}  // namespace lake::gait
