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

// How far each cuff slips, in the order of CuffsOf, mm in the shank's frame, of a hinge at p = (x, y) there that the
// actuator holds at the knee's angle and `error_rad` more: the least energy over all that the two links can do. As
// cuffs yield alike across and along, their stiffness has no part in it. R(φ) is a turn forward, J d = (d_y, −d_x):
//   d: a cuff from its link's hinge;  c = d on the shank, on the thigh d + (turn(θ − θ_standing) − 1) p, its misfit
//   e = d on the thigh, R(error) d on the shank;  both about their means
//   slip = R(φ) e − c, where the thigh's link turns by φ, found by Newton's method:
//   a sin φ − b cos φ + φ Σ_t L²/12 + (φ + error) Σ_s L²/12 = 0,  a = Σ e·c,  b = Σ J e·c
template <typename T>
std::vector<std::array<T, 2>> SlipsOf(const CuffOptions& cuffs, const T& flexion_rad, const T& standing_rad,
                                      const T& x_mm, const T& y_mm, double error_rad = 0) {
  using std::cos, std::sin;
  struct Point {
    T x, y;
  };
  const T turned_rad = flexion_rad - standing_rad, none = 0.0 * x_mm;
  const Point on_thigh{cos(turned_rad) * x_mm - sin(turned_rad) * y_mm,
                       sin(turned_rad) * x_mm + cos(turned_rad) * y_mm};
  const Point up{-sin(flexion_rad), cos(flexion_rad)};  // along the thigh
  const auto less = [](const Point& p, const Point& q) { return Point{p.x - q.x, p.y - q.y}; };
  const auto plus = [](const Point& p, const Point& q, double q_factor) {
    return Point{p.x + q.x * q_factor, p.y + q.y * q_factor};
  };
  const std::vector<PlacedCuff> all = CuffsOf(cuffs);
  std::vector<Point> e, c;
  Point mean_e{none, none}, mean_c{none, none};
  double thigh_mm2 = 0, shank_mm2 = 0;
  for (const PlacedCuff& cuff : all) {
    if (cuff.on_thigh) {
      e.push_back(Point{up.x * cuff.from_knee_mm - on_thigh.x, up.y * cuff.from_knee_mm - on_thigh.y});
      c.push_back(plus(e.back(), less(on_thigh, {x_mm, y_mm}), 1));
    } else {
      c.push_back(Point{-x_mm, -y_mm - cuff.from_knee_mm});
      e.push_back(Point{cos(error_rad) * c.back().x + sin(error_rad) * c.back().y,
                        cos(error_rad) * c.back().y - sin(error_rad) * c.back().x});
    }
    mean_e = plus(mean_e, e.back(), 1 / static_cast<double>(all.size()));
    mean_c = plus(mean_c, c.back(), 1 / static_cast<double>(all.size()));
    (cuff.on_thigh ? thigh_mm2 : shank_mm2) += cuff.length_mm * cuff.length_mm / 12;
  }
  T a = none, b = none;
  for (std::size_t i = 0; i < all.size(); ++i) {
    e[i] = less(e[i], mean_e);
    c[i] = less(c[i], mean_c);
    a = a + e[i].x * c[i].x + e[i].y * c[i].y;
    b = b + (e[i].y * c[i].x - e[i].x * c[i].y);
  }
  // From the solution for small turns; each step doubles the digits, of the derivatives too.
  constexpr int kSteps = 5;
  const double length_mm2 = thigh_mm2 + shank_mm2, held_mm2 = shank_mm2 * error_rad;
  T turn = (b - held_mm2) / (a + length_mm2);
  for (int step = 0; step < kSteps; ++step)
    turn = turn - (a * sin(turn) - b * cos(turn) + turn * length_mm2 + held_mm2) /
                      (a * cos(turn) + b * sin(turn) + length_mm2);
  std::vector<std::array<T, 2>> slips;
  for (std::size_t i = 0; i < all.size(); ++i)
    slips.push_back(
        {cos(turn) * e[i].x + sin(turn) * e[i].y - c[i].x, cos(turn) * e[i].y - sin(turn) * e[i].x - c[i].y});
  return slips;
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
// the geometric mean is expected. Throws UsageError as CheckCuffs and
// CheckStiffnesses.
CuffCourse CourseOf(const std::vector<double>& flexion_deg, const HingePlace& place, const CuffOptions& options);

}  // namespace lake::cuffs
