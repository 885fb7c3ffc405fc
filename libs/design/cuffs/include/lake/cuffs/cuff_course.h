// The forces at the cuffs over a rise, of a hinge beside the knee that its actuator holds at the knee's angle. They
// come from the misfit alone and are in proportion to it: neither the actuator's moment nor the device's weight is in
// them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <vector>

#include "lake/cuffs/cuff_model.h"

namespace lake::cuffs {

// N, with what the stiffness and the place's own uncertainty leave open (95 %: of the place the ellipse, 2.45 standard
// deviations in any direction).
struct CuffForce {
  double force_n = 0, low_n = 0, high_n = 0;
};

// How far one of a segment's cuffs slips, mm in the shank's frame, of a hinge at (x, y) there: CourseOf in closed form,
// as a template. Where cuffs yield alike across and along, their stiffness has no part in it:
//   m = (turn(θ − θ_standing) − 1) p,   slip = u − r φ a_s on the shank,  u − m + r φ a_t on the thigh
//   b = Σ r a_t − Σ r a_s over the thigh's and the shank's cuffs;  a: the segments' axes to the front; n: cuffs
//   φ = (Σ_t r a_t·m − n_t b·m/n) / (Σ (r² + L²/12) − b²/n),   u = (n_t m − φ b)/n
template <typename T>
std::array<T, 2> SlipOf(const CuffOptions& cuffs, bool on_thigh, std::size_t cuff, const T& flexion_rad,
                        const T& standing_rad, const T& x_mm, const T& y_mm) {
  using std::cos, std::sin;
  double thigh_mm = 0, shank_mm = 0, square_mm2 = 0;
  for (const Cuff& one : cuffs.thigh) thigh_mm += one.from_knee_mm;
  for (const Cuff& one : cuffs.shank) shank_mm += one.from_knee_mm;
  for (const auto* all : {&cuffs.thigh, &cuffs.shank})
    for (const Cuff& one : *all) square_mm2 += one.from_knee_mm * one.from_knee_mm + one.length_mm * one.length_mm / 12;
  const auto of_thigh = static_cast<double>(cuffs.thigh.size());
  const double all = of_thigh + static_cast<double>(cuffs.shank.size());
  const T turned_rad = flexion_rad - standing_rad, c = cos(turned_rad), s = sin(turned_rad);
  const T m_x = c * x_mm - s * y_mm - x_mm, m_y = s * x_mm + c * y_mm - y_mm;
  const T front_x = cos(flexion_rad), front_y = sin(flexion_rad);
  const T b_x = front_x * thigh_mm - shank_mm, b_y = front_y * thigh_mm;
  const T turn = ((front_x * m_x + front_y * m_y) * thigh_mm - (b_x * m_x + b_y * m_y) * (of_thigh / all)) /
                 (square_mm2 - (b_x * b_x + b_y * b_y) * (1 / all));
  const T u_x = (m_x * of_thigh - turn * b_x) * (1 / all), u_y = (m_y * of_thigh - turn * b_y) * (1 / all);
  const T swing = turn * (on_thigh ? cuffs.thigh : cuffs.shank)[cuff].from_knee_mm;
  if (on_thigh) return {u_x - m_x + swing * front_x, u_y - m_y + swing * front_y};
  return {u_x - swing, u_y};
}

// Per sample; of a segment's cuffs the largest.
struct CuffCourse {
  std::vector<CuffForce> thigh_n, shank_n, knee_shear_n;
};

// The largest over the course; NaN where one is unknown.
CuffForce Largest(const std::vector<CuffForce>& course);

// Where the hinge is against the knee at standing: shank's frame (x anterior, y up the shank), standard deviation along
// each axis.
struct HingePlace {
  Eigen::Vector2d mm = Eigen::Vector2d::Zero();
  double sd_mm = 0;
};

// `flexion_deg`: the knee's, per sample; the last is standing, where the cuffs are free of stress. Of the stiffnesses
// the geometric mean is expected. Throws as LoadOnLeg.
CuffCourse CourseOf(const std::vector<double>& flexion_deg, const HingePlace& place, const CuffOptions& options);

}  // namespace lake::cuffs
