#include "lake/linkage/statics.h"

#include "lake/core/cross.h"

namespace lake::linkage {

using Eigen::Vector2d;

MemberForces MemberForcesOf(const Pose& pose, double knee_torque_nm) {
  constexpr double kMillimetresPerMetre = 1000;
  const Vector2d coupler = (pose.shank_pin - pose.tip).normalized();
  const Vector2d actuator = (pose.tip - pose.mount).normalized();
  const Vector2d bar = (pose.tip - pose.thigh_pin).normalized();
  MemberForces forces;
  // Shank about K: the coupler's push at S gives the torque. In the thigh frame flexion turns anticlockwise.
  forces.coupler_n = -knee_torque_nm * kMillimetresPerMetre / Cross(pose.shank_pin - pose.knee, coupler);
  // Pin R: actuator and bar push it away from M and P, the coupler away from S.
  const double between = Cross(actuator, bar);
  forces.actuator_n = forces.coupler_n * Cross(coupler, bar) / between;
  forces.bar_n = forces.coupler_n * Cross(actuator, coupler) / between;
  return forces;
}

}  // namespace lake::linkage
