// Independent routes to the pose and its derivatives, to hold the closed form against.
#pragma once

#include <array>
#include <cmath>
#include <limits>

#include "lake/linkage/linkage.h"
#include "lake/linkage/loop_equations.h"

namespace lake {

// The same pose from Newton's method on the two loop equations, started at (phi, theta); an independent route for
// checking.
struct NewtonPose {
  double phi_rad = 0, theta_rad = 0;
  int iterations = 0;
  bool converged = false;
};
inline NewtonPose SolvePoseNewton(const linkage::Links& links, double stroke_mm, double start_phi_rad,
                                  double start_theta_rad) {
  constexpr int kMostIterations = 60;
  constexpr double kSmallStep_rad = 1e-14;
  const auto l = links.Values();
  NewtonPose pose{start_phi_rad, start_theta_rad, 0, false};
  double last_step = std::numeric_limits<double>::infinity();
  while (pose.iterations < kMostIterations) {
    const auto residual = linkage::LoopResiduals(l.data(), stroke_mm, pose.phi_rad, pose.theta_rad);
    const auto v = linkage::LoopVectorsOf(l.data(), pose.phi_rad, pose.theta_rad);
    // The first loop holds phi alone, so the two equations are solved one after the other.
    const double phi_slope = linkage::Dot(v.actuator, v.tip_motion) / linkage::kLoopScale_mm;
    const double theta_slope = -linkage::Dot(v.coupler, v.shank_motion) / linkage::kLoopScale_mm;
    const double phi_step = -residual[0] / phi_slope;
    const double theta_step =
        (-residual[1] + linkage::Dot(v.coupler, v.tip_motion) / linkage::kLoopScale_mm * phi_step) / theta_slope;
    if (!std::isfinite(phi_step) || !std::isfinite(theta_step)) return pose;
    pose.phi_rad += phi_step;
    pose.theta_rad += theta_step;
    ++pose.iterations;
    const double step = std::hypot(phi_step, theta_step);
    pose.converged =
        step <= kSmallStep_rad || (step < 1e-8 && step >= last_step);  // no further gain: rounding is reached
    if (pose.converged) return pose;
    last_step = step;
  }
  return pose;
}

// Derivatives of theta at fixed branch, rad per mm.
struct AngleDerivatives {
  std::array<double, 6> link;  // d theta / d l1..l6
  double stroke;               // d theta / d d
};
inline AngleDerivatives AngleDerivativesOf(const linkage::Links& links, const linkage::Pose& pose) {
  // Implicit differentiation of f1 = (|w|^2 - d^2) / 2 and f2 = (|u|^2 - l1^2) / 2 in (phi, kappa = pi - theta).
  const Eigen::Vector2d w = pose.tip - pose.mount, u = pose.shank_pin - pose.tip;
  const Eigen::Vector2d bar = (pose.tip - pose.thigh_pin) / links.l2, shank = pose.shank_pin / links.l4;
  const Eigen::Vector2d tip_motion = links.l2 * Eigen::Vector2d(bar.y(), -bar.x()),
                        shank_motion = links.l4 * Eigen::Vector2d(shank.y(), -shank.x());
  const auto theta_slope = [&](double f1_slope, double f2_slope) {
    const double phi_slope = -f1_slope / w.dot(tip_motion);
    return (f2_slope - u.dot(tip_motion) * phi_slope) / u.dot(shank_motion);
  };
  return {{theta_slope(0, -links.l1), theta_slope(w.dot(bar), -u.dot(bar)), theta_slope(0, -u.y()),
           theta_slope(0, u.dot(shank)), theta_slope(-w.x(), 0), theta_slope(-w.y(), 0)},
          theta_slope(-pose.stroke_mm, 0)};
}

}  // namespace lake
