// Degrees stand at every boundary, radians only in numerical code.
#pragma once

#include <numbers>

namespace lake {

inline constexpr double kDegreesPerRadian = 180.0 / std::numbers::pi;

constexpr double DegreesFromRadians(double radians) {
  return radians * kDegreesPerRadian;
}
constexpr double RadiansFromDegrees(double degrees) {
  return degrees / kDegreesPerRadian;
}

}  // namespace lake
