// How large a leg is in the picture. Not part of the interface.
#pragma once

#include "lake/motion/marker_recording.h"

namespace lake::tracking {

// mm to a pixel, by the length of the named leg from ankle over knee to hip, for which an adult's 850 mm stand; a usual
// 2 where these are not named or never seen together.
double MillimetresPerPx(const motion::MarkerRecording& recording);

inline constexpr double kReach_mm = 2000;  // where a person may be

}  // namespace lake::tracking
