// The linkage in one pose over a box of links, with derivatives by the links: at d_min, where the bar angle phi is an
// axis of its own, and at a given knee angle of the used range.
//
// With e and s the directions of PR and KS, a prime for the derivative by phi or kappa = pi - theta, and u = S - R:
//   dkappa = (l1 dl1 + u.e dl2 + u.y dl3 - u.s dl4 + u.R' dphi) / (u.S')        u.S' >= 0: the assembled branch
//   dphi at a given kappa: the same, solved for dphi                            u.R' >= 0: the used range has no turn
//   dphi at d_min = (w.x dl5 + w.y dl6 - w.e dl2) / (w.R'),  w = R - M           w.R' >= 0
#pragma once

#include <functional>
#include <optional>

#include "cuts.h"
#include "lake/problem/problem.h"

namespace lake::certificate {

// The set on which derivatives hold: order of the links, Grashof's law and the distance to the actuator's singularity,
// each but for kRounding_mm. It is convex, so with two designs all between them are in it, and in it every triangle of
// the linkage closes: l8 <= l2 + l3 <= l1 + l4 - g, l8 >= l2 - l3 >= l4 - l1 + g, and likewise for D = |PS|.
struct Margins {
  double grashof_mm = 0, singularity_mm = 0;
};
inline constexpr double kRounding_mm = 1e-9;

// l8^2 = |KR|^2 as (l2 - l3)^2 + 4 l2 l3 cos^2(phi/2): no cancellation.
Interval SquaredTipDistance(const AxisBox& box);
// Eq. (2), and kappa = beta1 + beta2, Eq. (3); empty where no linkage of the box closes.
Interval Beta1Of(const AxisBox& box);
Interval KappaOf(const AxisBox& box);

struct PoseSlopes {
  std::array<Slope, 6> links;
  Slope phi, kappa, stroke;
  Slope shank, turning;        // u.S' / l4 and u.R' / l2, mm
  std::optional<Slope> ratio;  // u.S' / u.R', where kappa is given
};

// A box and, if one is known, a design of the set in it, about which functions are expanded.
struct Region {
  AxisBox box;
  std::optional<AxisPoint> anchor;
};

// nullopt: no linkage of the box has this pose.
std::optional<PoseSlopes> PoseAtShortestStroke(const Region& region, double d_min_mm, const Margins& margins);
// At kappa, for links that stand; the stroke is at least the shortest.
std::optional<PoseSlopes> PoseAtAngle(const Region& region, const Interval& kappa_rad, double d_min_mm,
                                      const Margins& margins);

// phi at d_min as a function of the links; `phi_rad` is known to contain it.
Slope BarAngleAtShortestStroke(const AxisBox& box, const Interval& phi_rad, double d_min_mm, const Margins& margins);
// phi at d_min of one design; empty where it does not close.
Interval BarAngleOfPoint(const AxisBox& point, double d_min_mm);
// alpha1, no larger than phi at d_min.
Slope MountAngle(const AxisBox& box);
// l2 + d_min - l7.
Slope ActuatorSlack(const AxisBox& box, double d_min_mm);

// The quantities of problem::PoseQuantities over a box; where kappa is given their ratios have one range less in them.
class SlopeQuantities {
 public:
  explicit SlopeQuantities(const PoseSlopes& pose) : pose_(pose), actuator_(Actuator()) {}

  Slope Constant(double value) const { return Interval(value); }
  Slope Stroke_mm() const { return pose_.stroke; }
  Slope Theta_deg() const { return (kPiInterval - pose_.kappa) * (Interval(180) / kPiInterval); }
  problem::Ratio<Slope> MomentArm() const;
  problem::Ratio<Slope> TransmissionSine() const { return {pose_.shank, pose_.links[kL1]}; }
  problem::Ratio<Slope> CouplerForce() const { return {pose_.links[kL1], pose_.links[kL4] * pose_.shank}; }
  problem::Ratio<Slope> BarForce() const;

 private:
  Slope Actuator() const;  // w.R' / l2

  const PoseSlopes& pose_;
  Slope actuator_;
};

// A requirement at one pose, as a function that is >= 0 where it holds.
using PoseRow = std::function<Slope(const SlopeQuantities&)>;

}  // namespace lake::certificate
