// The cross product in a plane.
#pragma once

#include <Eigen/Core>

namespace lake {

// a × b along the plane's normal: positive where the shorter turn from a to b is counter-clockwise.
inline double Cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace lake
