// A segment's axes, and how heavy a kilogram is.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "lake/core/angles.h"

namespace lake::cuffs {

inline constexpr double kGravity_m_s2 = 9.80665;

// Columns: across the segment (anterior) and along it (up), in the leg frame.
inline Eigen::Matrix2d AxesOf(double lean_deg) {
  const double lean = RadiansFromDegrees(lean_deg);
  Eigen::Matrix2d axes;
  axes << std::cos(lean), std::sin(lean), -std::sin(lean), std::cos(lean);
  return axes;
}

}  // namespace lake::cuffs
