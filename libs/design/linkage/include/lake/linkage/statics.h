// The forces in every member and pin of the linkage at rest, by the balance of each body: a check independent of the
// virtual work that gives the actuator's force (ActuatorForce in linkage.h).
//
// The mechanism bears a couple between shank and thigh, the knee torque; its own weight is left out, as is what the
// knee joint itself carries. Then actuator, coupler and slewing bar are loaded at their two pins alone, along the line
// between them, and shank and thigh plate each pass the couple on to the leg: the three forces on the thigh plate, at
// K, P and M, have no sum and a moment equal to the torque.
#pragma once

#include <algorithm>
#include <cmath>

#include "lake/linkage/linkage.h"

namespace lake::linkage {

// Forces in N. Along a member they are positive when it pushes its pins apart, as the actuator's is; infinite at a dead
// point.
struct MemberForces {
  double actuator_n = 0;  // M to R
  double coupler_n = 0;   // R to S
  double bar_n = 0;       // P to R

  // The force on each pin, never negative: the coupler's at K and S, the bar's at P, the actuator's at M (the mount on
  // the thigh); at the tip R, where three members meet, the largest of their forces.
  double KneePin() const { return std::abs(coupler_n); }
  double ThighPin() const { return std::abs(bar_n); }
  double TipPin() const { return std::max({std::abs(actuator_n), std::abs(coupler_n), std::abs(bar_n)}); }
  double ShankPin() const { return std::abs(coupler_n); }
  double Mount() const { return std::abs(actuator_n); }
};

// At a knee torque in N m, positive in extension.
MemberForces MemberForcesOf(const Pose& pose, double knee_torque_nm);

}  // namespace lake::linkage
