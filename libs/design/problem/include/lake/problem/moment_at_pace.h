// The knee's moment in a rise that takes another time than the measured one.
#pragma once

#include <optional>

#include "lake/problem/load_profile.h"

namespace lake::problem {

// The same path gone along evenly in `duration_s`: of what accelerations add to the moment the part (own / duration)^2
// is left, and the rest, as lake-loads has it as "knee_slow_nm" in the profile's file, is that of the pose. Samples
// where either is not known are not known. nullopt if the file does not have it. Throws Error as ReadLoadProfile.
std::optional<LoadProfile> AtPace(const LoadProfile& profile, double duration_s);

}  // namespace lake::problem
