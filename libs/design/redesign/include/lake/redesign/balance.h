// The body in a human's motion that an exoskeleton drives: where it is, and where the ground's force then acts.
//
// The exoskeleton decides the knee angle theta; the person decides how far the leg, from ankle to hip, and the trunk
// lean (Lean, against the human trial). The hip is on a circle about the ankle that theta sets (human_motion.h), the
// trunk's centre of mass turns with the trunk. Accelerations are differences over a twentieth of the rise to either
// side, as long as the knots of a free program are apart: what a step of the actuator's speed does within that, soft
// tissue takes up. After the rise the body stays where it is.
#pragma once

#include <algorithm>

#include "lake/core/numbers.h"
#include "lake/loads/body_path.h"
#include "lake/redesign/human_motion.h"

namespace lake::redesign {

// The most that a person leans otherwise than in the human trial, to be in balance along the program.
struct LeanLimits {
  double trunk_deg = 30, leg_deg = 10;
};

// While the seat bears a part, the hip is at the human's own height but for what a cushion gives.
inline constexpr double kSeatGives_mm = 20;

// Direction from ankle to hip, from the vertical, forward positive.
inline double LeanOf(const HumanSample& human) {
  return std::atan2(human.sin_lean, human.cos_lean);
}

// How far the hip is above the ankle, mm.
template <typename T>
T HipHeight(const HumanSample& human, const T& theta_rad, const T& leg_lean_rad) {
  using std::cos, std::sin, std::sqrt;
  const T along = cos(theta_rad) * human.thigh_mm + human.shank_mm, aside = sin(theta_rad) * human.thigh_mm;
  return sqrt(along * along + aside * aside) * cos(leg_lean_rad + LeanOf(human));
}

// Leans against the human's own.
template <typename T>
loads::BodyPose<T> PoseOf(const HumanSample& human, const loads::TrunkSample& trunk, const loads::LegBody& body,
                          const T& theta_rad, const T& leg_lean_rad, const T& trunk_lean_rad) {
  using std::atan2, std::cos, std::sin;
  const double shank_m = human.shank_mm / kMmPerM, thigh_m = human.thigh_mm / kMmPerM;
  const T shank = leg_lean_rad + LeanOf(human) + atan2(sin(theta_rad) * thigh_m, cos(theta_rad) * thigh_m + shank_m);
  const T thigh = shank - theta_rad;
  const T shank_x = sin(shank), shank_y = cos(shank), thigh_x = sin(thigh), thigh_y = cos(thigh);
  const double to_shank_m = shank_m - body.shank.centre_m, to_thigh_m = thigh_m - body.thigh.centre_m;
  const T hip_x = shank_x * shank_m + thigh_x * thigh_m, hip_y = shank_y * shank_m + thigh_y * thigh_m;
  const T c = cos(trunk_lean_rad), s = sin(trunk_lean_rad);
  return {{{shank_x * to_shank_m, shank_y * to_shank_m, shank},
           {shank_x * shank_m + thigh_x * to_thigh_m, shank_y * shank_m + thigh_y * to_thigh_m, thigh},
           {hip_x + c * trunk.centre_m.x() + s * trunk.centre_m.y(),
            hip_y + c * trunk.centre_m.y() - s * trunk.centre_m.x(), trunk_lean_rad + trunk.tilt_rad}}};
}

// How many samples accelerations reach to either side.
inline std::size_t BalanceReach(const HumanMotion& human) {
  return std::max<std::size_t>(1, (human.size() - 1) / 20);
}

// The first sample of the motion at which the feet alone bear the body.
std::size_t FirstOnFeet(const HumanMotion& human, const loads::BodyPath& body);

// `human`: the trial's own motion, of 101 samples as the body's; `theta_rad` per sample.
BalanceCourse FindBalance(const HumanMotion& human, const loads::BodyPath& body, const std::vector<double>& theta_rad,
                          const Lean& lean, double duration_s);

}  // namespace lake::redesign
