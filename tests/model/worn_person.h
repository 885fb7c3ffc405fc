// A person who wears the published design, in a rise: made up.
#pragma once

#include <cmath>

#include "lake/core/angles.h"
#include "lake/model/coupled_model.h"
#include "published_links.h"

namespace lake::testing {

inline parts::Mechanism Published() {
  constexpr double kShortestStroke_mm = 245;
  return parts::MakeMechanism(kPublishedLinks, linkage::FindUsedRange(kPublishedLinks, kShortestStroke_mm, {}), {});
}

// A rise of 6 s from 92° to 8°.
inline model::Subject Wearing(const parts::Mechanism& mechanism, const Eigen::Vector2d& hinge_mm = {14, -22}) {
  model::Subject subject;
  loads::LegBody& body = subject.body.body;
  body.foot = {1.0, 0.06, 0.12};
  body.shank = {3.3, 0.18, 0.13};
  body.thigh = {7.0, 0.17, 0.13};
  body.trunk = {23.7, 0.32, 0.25};
  body.sole = {0.066, 0.2};
  body.ankle_height_m = 0.07;
  subject.shank_mm = 420;
  subject.thigh_mm = 400;
  subject.hinge_mm = hinge_mm;
  subject.cuffs.thigh = {{210, 80}, {90, 50}};
  for (int i = 0; i <= 100; ++i) {
    const double u = i / 100.0, share = u * u * (3 - 2 * u), knee_deg = 92 - 84 * share;
    subject.rise.push_back(
        {.time_s = 6 * u,
         .shank_deg = 6 + 40 * u * (1 - u),
         .knee_deg = knee_deg,
         .trunk_deg = 10 + 120 * u * (1 - u),
         .stroke_mm = *linkage::StrokeForAngle(mechanism.links, mechanism.range, RadiansFromDegrees(knee_deg))});
    const double tilt_rad = RadiansFromDegrees(subject.rise.back().trunk_deg);
    subject.body.trunk.push_back({tilt_rad, 0.32 * Eigen::Vector2d(std::sin(tilt_rad), std::cos(tilt_rad))});
  }
  return subject;
}

}  // namespace lake::testing
