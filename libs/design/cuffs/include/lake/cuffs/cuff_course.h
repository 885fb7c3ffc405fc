// The forces at the cuffs over a rise, of a hinge beside the knee that its actuator holds at the knee's angle. They
// come from the misfit alone: neither the actuator's moment nor the device's weight is in
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

// How far a cuff slips, mm in the shank's frame, of a hinge at p = (x, y) there: what LoadOnLeg gives of a held hinge,
// as a template. Where cuffs yield alike across and along, their stiffness has no part in it:
//   m = (turn(θ − θ_standing) − 1) p: how far the hinge's place on the thigh is from that on the shank
//   d: a cuff from its link's hinge;  J d = (d_y, −d_x);  n: number of cuffs, n_t of them the thigh's
//   e = Σ d n_t/n − Σ_t d
//   φ: m·Je cos φ + (Σ d² − |Σ d|²/n − m·e) sin φ + φ Σ L²/12 = 0, the links' turn, by Newton's method
//   a = (cos φ − 1) d + sin φ J d;  u = (n_t m − Σ a)/n
//   slip = u + a on the shank,  u − m + a on the thigh
template <typename T>
std::array<T, 2> SlipOf(const CuffOptions& cuffs, const CuffPlace& of, const T& flexion_rad, const T& standing_rad,
                        const T& x_mm, const T& y_mm) {
  using std::cos, std::sin;
  const T turned_rad = flexion_rad - standing_rad, c = cos(turned_rad), s = sin(turned_rad);
  const T thigh_x = c * x_mm - s * y_mm, thigh_y = s * x_mm + c * y_mm;  // the hinge's place on the thigh
  const T m_x = thigh_x - x_mm, m_y = thigh_y - y_mm;
  const T up_x = -sin(flexion_rad), up_y = cos(flexion_rad);  // along the thigh
  const auto from_hinge = [&](const CuffPlace& place) {
    const double r = CuffAt(cuffs, place).from_knee_mm;
    return place.on_thigh ? std::array<T, 2>{up_x * r - thigh_x, up_y * r - thigh_y}
                          : std::array<T, 2>{-x_mm, -y_mm - r};
  };
  const T none = 0.0 * x_mm;
  T d_x = none, d_y = none, thigh_d_x = none, thigh_d_y = none, square_mm2 = none;
  double length_mm2 = 0;
  const std::vector<CuffPlace> places = PlacesOf(cuffs);
  for (const CuffPlace& place : places) {
    const auto [x, y] = from_hinge(place);
    d_x = d_x + x;
    d_y = d_y + y;
    square_mm2 = square_mm2 + x * x + y * y;
    length_mm2 += CuffAt(cuffs, place).length_mm * CuffAt(cuffs, place).length_mm / 12;
    if (!place.on_thigh) continue;
    thigh_d_x = thigh_d_x + x;
    thigh_d_y = thigh_d_y + y;
  }
  const auto all = static_cast<double>(places.size()), thighs = static_cast<double>(cuffs.thigh.size());
  const T e_x = d_x * (thighs / all) - thigh_d_x, e_y = d_y * (thighs / all) - thigh_d_y;
  const T of_cos = m_x * e_y - m_y * e_x;
  const T of_sin = square_mm2 - (d_x * d_x + d_y * d_y) * (1 / all) - (m_x * e_x + m_y * e_y);
  // From the solution for small turns; each step doubles the digits, of the derivatives too.
  constexpr int kSteps = 5;
  T turn = -of_cos / (of_sin + length_mm2);
  for (int step = 0; step < kSteps; ++step)
    turn = turn - (of_cos * cos(turn) + of_sin * sin(turn) + turn * length_mm2) /
                      (of_sin * cos(turn) - of_cos * sin(turn) + length_mm2);
  const T less = cos(turn) - 1.0, sine = sin(turn);
  const T u_x = (m_x * thighs - less * d_x - sine * d_y) * (1 / all);
  const T u_y = (m_y * thighs - less * d_y + sine * d_x) * (1 / all);
  const auto [x, y] = from_hinge(of);
  const T a_x = less * x + sine * y, a_y = less * y - sine * x;
  if (of.on_thigh) return {u_x - m_x + a_x, u_y - m_y + a_y};
  return {u_x + a_x, u_y + a_y};
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
