// Numbers that many rooms write: no number, no limit, pi, millimetres in a metre, the larger of two.
#pragma once

#include <cmath>
#include <limits>
#include <numbers>

namespace lake {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kPi = std::numbers::pi;
inline constexpr double kMmPerM = 1000;
// Standard deviations along each of two axes that hold 95 % of the places: √(−2 ln 0.05).
inline constexpr double kEllipse95 = 2.447747;

// NaN where one of them is.
inline double LargerOrNaN(double a, double b) {
  return std::isnan(a) || a >= b ? a : b;
}

}  // namespace lake
