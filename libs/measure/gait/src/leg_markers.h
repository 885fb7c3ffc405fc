// The markers and the segments of the leg, which are fitted together. Not part of the interface.
#pragma once

#include "lake/motion/leg_motion.h"

namespace lake::gait {

using motion::LegMarker;
using enum motion::LegMarker;
inline constexpr int kLegMarkers = 4;                            // ankle to waist
enum LegSegmentIndex : std::uint8_t { kShank, kThigh, kTrunk };  // of motion::kSegments

}  // namespace lake::gait
