// What a person or a device can be. Wider than all that was measured: what lies beyond is a slip, mostly of units.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

#include "lake/core/error.h"

namespace lake {

struct PlausibleRange {
  double low, high;
  const char* unit;
  const char* what;

  bool Holds(double value) const { return value >= low && value <= high; }
};

// The lightest walks at one year; the heaviest weighed 635 kg (J. B. Minnoch, 1978).
inline constexpr PlausibleRange kPlausibleMass{10, 650, "kg", "a person's mass"};
// Adults from 546 mm (C. B. Dangi, 2012) to 2720 mm (R. Wadlow, 1940).
inline constexpr PlausibleRange kPlausibleStature{500, 2750, "mm", "a person's stature"};
// 0.245 and 0.246 of the stature (Drillis & Contini 1966), with room for a marker beside the joint.
inline constexpr PlausibleRange kPlausibleSegment{100, 1000, "mm", "a thigh or shank"};
// The patellar tendon tears at some 550 N m (Zernicke et al. 1977, J Bone Joint Surg Am 59:179).
inline constexpr PlausibleRange kPlausibleKneeTorque{-1000, 1000, "N m", "a knee's moment"};
// A marker on an exoskeleton's part is no farther from the part's joint than the longest segment that it lies along.
inline constexpr PlausibleRange kPlausibleJointMarker{-700, 700, "mm", "the place of a marker on the joint's parts"};
// Skin moves by 30 mm on a knee at most (Leardini et al. 2005, Gait Posture 21:212); beyond this no marker is on it.
inline constexpr PlausibleRange kPlausibleMarkerDeviation{0, 200, "mm", "a marker's deviation from its joint"};
// Electric cylinders end at some 100 kN and 2000 mm of stroke; what a leg carries has a hundredth of the force.
inline constexpr PlausibleRange kPlausibleForce{0, 100e3, "N", "an actuator's force"};
inline constexpr PlausibleRange kPlausibleStroke{0, 2000, "mm", "an actuator's length"};

// "--mass 700 kg: a person's mass lies between 10 and 650 kg".
inline std::string ImplausibleText(std::string_view name, double value, const PlausibleRange& range) {
  return fmt::format("{} {} {}: {} lies between {} and {} {}", name, value, range.unit, range.what, range.low,
                     range.high, range.unit);
}

// Throws UsageError.
inline void CheckPlausible(std::string_view name, double value, const PlausibleRange& range) {
  if (!range.Holds(value)) throw UsageError("{}", ImplausibleText(name, value, range));
}

}  // namespace lake
