// Numbers that many rooms write: no number, no limit, pi, and millimetres in a metre.
#pragma once

#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace lake {

inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr double kPi = std::numbers::pi;
inline constexpr double kMmPerM = 1000;

// Nothing if it is no number, or none that ends: an empty cell of a table.
inline std::optional<double> Finite(double value) {
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

}  // namespace lake
