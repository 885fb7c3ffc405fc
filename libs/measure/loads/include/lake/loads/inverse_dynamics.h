// Newton–Euler in the sagittal plane: what has to act on moving bodies from outside, about any point.
//
//   F = Σ m (a − g)        M = Σ (c − p) × m (a − g) + I α
//
// Of all bodies above a joint this is what the joint transmits (top-down); of all bodies below it, less the ground's
// force, likewise (bottom-up). Axes of the leg frame: x the way the subject faces, y up; moments and angles are
// counter-clockwise there, from x to y. SI units: m, kg, s, N, N·m.
#pragma once

#include <Eigen/Core>
#include <span>

namespace lake::loads {

inline constexpr double kGravity_m_s2 = 9.80665;  // standard gravity

// A rigid body at one moment.
struct Body {
  double mass_kg = 0;
  double inertia_kg_m2 = 0;  // about its centre of mass
  Eigen::Vector2d centre_m = Eigen::Vector2d::Zero();
  Eigen::Vector2d acceleration_m_s2 = Eigen::Vector2d::Zero();  // of the centre
  double angular_acceleration_rad_s2 = 0;
};

struct Wrench {
  Eigen::Vector2d force_n = Eigen::Vector2d::Zero();
  double moment_nm = 0;  // about the point that was asked for
};

// The bodies' mass times acceleration less their weight: F and M above.
Wrench RequiredWrench(std::span<const Body> bodies, const Eigen::Vector2d& about_m);

// The same wrench about another point.
Wrench About(const Wrench& wrench, const Eigen::Vector2d& from_m, const Eigen::Vector2d& to_m);

}  // namespace lake::loads
