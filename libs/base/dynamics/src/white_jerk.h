// Position, velocity and acceleration driven by white jerk, over a time. Not part of the interface.
#pragma once

#include <Eigen/Core>

namespace lake::dynamics {

inline Eigen::Matrix3d JerkTransition(double t) {
  return Eigen::Matrix3d{{1, t, t * t / 2}, {0, 1, t}, {0, 0, 1}};
}

// Of the state after a time t > 0, by white jerk of density 1.
inline Eigen::Matrix3d JerkCovariance(double t) {
  const double t2 = t * t, t3 = t2 * t, t4 = t3 * t, t5 = t4 * t;
  return Eigen::Matrix3d{{t5 / 20, t4 / 8, t3 / 6}, {t4 / 8, t3 / 3, t2 / 2}, {t3 / 6, t2 / 2, t}};
}

}  // namespace lake::dynamics
