// The noise of a marker whose file does not say it. Not part of the interface.
#pragma once

#include <vector>

#include "lake/motion/marker_recording.h"

namespace lake::gait {

// The noise per axis of a smooth path's samples, from their sixth differences; robust against jumps. At least what
// files are written with, 0.001.
double NoiseFromDifferences(const motion::MarkerTrack& track, const std::vector<char>& seen);

}  // namespace lake::gait
