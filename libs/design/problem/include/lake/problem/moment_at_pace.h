// The knee's moment in a rise that takes another time than the measured one.
#pragma once

#include <functional>
#include <optional>

#include "lake/linkage/linkage.h"
#include "lake/problem/load_profile.h"
#include "lake/problem/problem.h"

namespace lake::problem {

// The same path gone along evenly in `duration_s`: of what accelerations add to the moment the part (own / duration)^2
// is left, and the rest, as lake-loads has it as "knee_slow_nm" in the profile's file, is that of the pose. Samples
// where either is not known are not known. nullopt if the file does not have it. Throws Error as ReadLoadProfile.
std::optional<LoadProfile> AtPace(const LoadProfile& profile, double duration_s);

// A problem whose profile has the moments of a rise in `moments_s`.
struct ProblemAtPace {
  SynthesisProblem problem;
  double moments_s = 0;
};

// The problem at the pace of the rise that FindAssistance has for its design: in duration_s, else the shortest that
// the actuator allows, else the profile's own. The design and its shortest rise depend on the moments in turn, so both
// are sought until the duration stays within 0.5 %. `links_for` gives the design of a problem, nullopt where it has
// none: then the moments stay as they are. Needs a load profile; throws Error as AtPace and FindAssistance.
ProblemAtPace AtItsPace(SynthesisProblem problem,
                        const std::function<std::optional<linkage::Links>(const SynthesisProblem& problem)>& links_for);

}  // namespace lake::problem
