// Numbers that many rooms write: no number, no limit, pi, and millimetres in a metre.
#pragma once

#include <limits>
#include <numbers>

namespace lake {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kPi = std::numbers::pi;
inline constexpr double kMmPerM = 1000;

}  // namespace lake
