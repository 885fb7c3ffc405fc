// Sit-to-stand curves in closed form: what the comparison must take apart again.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "lake/compare/registration.h"
#include "lake/core/angles.h"

namespace lake {

struct ClosedFormLeg {
  double shank_mm = 420, thigh_mm = 400;
  double seated_shank_deg = 6, peak_shank_deg = 18, standing_shank_deg = 3;
  double seated_knee_deg = 92, standing_knee_deg = 5;
};

inline double SmoothStep(double u) {
  u = std::min(std::max(u, 0.0), 1.0);
  return u * u * u * (10 + u * (-15 + 6 * u));
}

// At a fraction 0..1 of the motion.
inline void AppendPose(const ClosedFormLeg& leg, double u, compare::StsCurve& curve) {
  const double shank_deg = leg.seated_shank_deg + (leg.peak_shank_deg - leg.seated_shank_deg) * SmoothStep(u / 0.55) +
                           (leg.standing_shank_deg - leg.peak_shank_deg) * SmoothStep((u - 0.35) / 0.65);
  const double knee_deg =
      leg.seated_knee_deg + (leg.standing_knee_deg - leg.seated_knee_deg) * SmoothStep((u - 0.1) / 0.9);
  const auto along = [](double length, double lean_deg) {
    return Eigen::Vector2d(length * std::sin(RadiansFromDegrees(lean_deg)),
                           length * std::cos(RadiansFromDegrees(lean_deg)));
  };
  curve.ankle.emplace_back(0, 0);
  curve.knee.push_back(along(leg.shank_mm, shank_deg));
  curve.hip.push_back(curve.knee.back() + along(leg.thigh_mm, shank_deg - knee_deg));
  curve.knee_deg.push_back(knee_deg);
  curve.knee_sigma_mm.push_back(0.1);
}

// `registration` maps a fraction of the motion to another; `offset_mm` is in the shank frame.
inline compare::StsCurve MakeCurve(
    const ClosedFormLeg& leg, const std::function<double(double)>& registration = [](double u) { return u; },
    const Eigen::Vector2d& offset_mm = Eigen::Vector2d::Zero()) {
  compare::StsCurve curve;
  curve.repetition = 1;
  curve.duration_s = 2;
  for (int i = 0; i < compare::kPercentSamples; ++i) AppendPose(leg, registration(i / 100.0), curve);
  const compare::StsCurve human = curve;
  for (std::size_t i = 0; i < compare::kPercentSamples; ++i) curve.knee[i] += compare::ShankAxes(human, i) * offset_mm;
  return curve;
}

inline double IssueWarp(double s) {
  return s + 0.05 * std::sin(std::numbers::pi * s);
}

inline void AddNoise(compare::StsCurve& curve, double sigma_mm, std::mt19937& random) {
  std::normal_distribution<double> normal(0, sigma_mm);
  for (Eigen::Vector2d& knee : curve.knee) {
    const double x = normal(random), y = normal(random);
    knee += Eigen::Vector2d(x, y);
  }
  curve.knee_sigma_mm.assign(compare::kPercentSamples, sigma_mm);
}

}  // namespace lake
