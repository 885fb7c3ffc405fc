// The whole strides among the events of a walk.
#pragma once

#include <vector>

#include "lake/gait/walking.h"

namespace lake::gait {

struct Stride {
  motion::StsEvent strike, off, next;
};

// In the order of time: heel strike, toe-off and the next heel strike of the measured leg, by their numbers.
std::vector<Stride> StridesOf(const std::vector<motion::StsEvent>& events);

// Sets `strides` and `incomplete`.
void CountStrides(const std::vector<motion::StsEvent>& events, Walk& walk);

}  // namespace lake::gait
