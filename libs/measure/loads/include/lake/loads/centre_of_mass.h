// The whole body's centre of mass over a rise, and its momentum: what carries a person off the seat. Both legs are
// taken to move alike, the feet to stand still, the trunk's centre to turn with the trunk: what needs forces to be
// known (arms that swing, a spine that bends) is left out, so that the seat, whose force is not known, has no part in
// it.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "lake/loads/leg_dynamics.h"
#include "lake/loads/leg_path.h"

namespace lake::loads {

// Axes of the leg frame: x forward, y up. The momentum is the velocity times the body's mass.
struct CentreOfMass {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero();  // from the ground under the ankle
  Eigen::Vector2d velocity_m_s = Eigen::Vector2d::Zero();
};

// `body_kg`: of the whole body; what both legs of `body` leave of it is the trunk's. `in_trunk_m`: where the trunk's
// centre is from the table's place, along the trunk and across it (forward).
CentreOfMass CentreOfMassOf(const LegPoints& points, const LegBody& body, double body_kg,
                            const Eigen::Vector2d& in_trunk_m);

// Of one rise. NaN where markers are missing.
struct RiseMomentum {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  std::vector<CentreOfMass> rows;  // 0..100 %
  double seat_off_m = kUnknown;    // how far the centre is before the ankle at seat-off; negative behind
  double forward_seat_off_m_s = kUnknown;
  double forward_max_m_s = kUnknown, upward_max_m_s = kUnknown;  // largest of the rise
  double forward_lead_s = kUnknown;                              // from the largest forward one to seat-off
};

// The times are of `path`.
RiseMomentum FindMomentum(const LegPath& path, const LegBody& body, double body_kg, const Eigen::Vector2d& in_trunk_m,
                          double onset_s, double seat_off_s, double standing_s);

}  // namespace lake::loads
