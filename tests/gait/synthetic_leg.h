// Sit-to-stands with known truth: minimum-jerk segment angles, seen exactly.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "lake/core/angles.h"
#include "lake/gait/leg_angles.h"
#include "lake/gait/leg_view.h"

namespace lake {

struct SyntheticLegOptions {
  double rate_hz = 60;
  int repetitions = 2;
  double rest_s = 1.0;  // seated before each rise, and standing before each lowering
  double move_s = 1.8;  // one rise or one lowering
  bool starts_standing = false;
  double time_jitter = 0;  // of a frame's step: irregular stamps
  double shank_mm = 430, thigh_mm = 410, trunk_mm = 260;
  double skin_mm = 0;  // how much the shank's markers come apart with flexion; the thigh's by 1.7 times that
  Facing facing = Facing::kRight;
  Eigen::Vector2d ankle_mm = Eigen::Vector2d(30, 90);
};

struct SyntheticLeg {
  std::vector<double> time_s;
  std::vector<LegPoints> points_mm;  // plane frame
  std::vector<LegSample> truth;      // vectors and angles without noise
  std::vector<double> onset_s;       // when the trunk starts to move, per rise
};

// 0 before 0, 1 after 1, with vanishing speed and acceleration at both (Flash & Hogan 1985).
inline double MinimumJerk(double u) {
  if (u <= 0) return 0;
  if (u >= 1) return 1;
  return u * u * u * (10 + u * (-15 + 6 * u));
}

struct SyntheticAngles {
  double shank_deg, thigh_deg, trunk_deg;
};

// 0 seated … 1 standing, `u` linear in time.
inline SyntheticAngles RiseAngles(double u) {
  const double forward = MinimumJerk(u / 0.5), back = MinimumJerk((u - 0.45) / 0.55);
  return {8 + 12 * MinimumJerk((u - 0.1) / 0.4) - 19 * back, -84 + 86 * MinimumJerk((u - 0.3) / 0.7),
          5 + 35 * forward - 40 * back};
}

inline SyntheticLeg MakeSyntheticLeg(const SyntheticLegOptions& o, unsigned seed = 1) {
  SyntheticLeg leg;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> jitter(-0.5, 0.5);
  const double cycle_s = 2 * (o.rest_s + o.move_s), total_s = o.repetitions * cycle_s;
  const double offset_s = o.starts_standing ? o.rest_s + o.move_s : 0;
  for (int r = 0; r <= o.repetitions; ++r) {
    const double onset_s = r * cycle_s + o.rest_s - offset_s;
    if (onset_s > 0 && onset_s + o.move_s < total_s) leg.onset_s.push_back(onset_s);
  }
  for (int i = 0; i < total_s * o.rate_hz; ++i) {
    const double t = (i + (i > 0 ? o.time_jitter * jitter(random) : 0)) / o.rate_hz;
    const double phase = std::fmod(t + offset_s, cycle_s);
    const bool lowering = phase > cycle_s / 2;
    const double u = ((lowering ? phase - cycle_s / 2 : phase) - o.rest_s) / o.move_s;
    const SyntheticAngles angles = RiseAngles(lowering ? 1 - u : u);
    const double side = o.facing == Facing::kRight ? 1 : -1;
    const auto along = [&](double length, double lean_deg) {
      const double lean_rad = RadiansFromDegrees(lean_deg);
      return Eigen::Vector2d(side * length * std::sin(lean_rad), length * std::cos(lean_rad));
    };
    const double skin_mm = o.skin_mm * std::sin(RadiansFromDegrees(angles.shank_deg - angles.thigh_deg));
    LegPoints points;
    points.ankle = o.ankle_mm + Eigen::Vector2d(3 * std::sin(2 * t), 1.5 * std::sin(3 * t));
    points.knee = *points.ankle + along(o.shank_mm + skin_mm, angles.shank_deg);
    points.hip = *points.knee + along(o.thigh_mm - 1.7 * skin_mm, angles.thigh_deg);
    points.waist = *points.hip + along(o.trunk_mm, angles.trunk_deg);
    leg.time_s.push_back(t);
    leg.points_mm.push_back(points);
    leg.truth.push_back(MakeLegSample(points, o.facing, Eigen::Vector2d::UnitY()));
  }
  return leg;
}

}  // namespace lake
