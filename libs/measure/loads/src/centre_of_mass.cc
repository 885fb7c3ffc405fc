#include "lake/loads/centre_of_mass.h"

#include <cmath>

#include "loads_model.h"

namespace lake::loads {
namespace {

using Eigen::Vector2d;

struct Moving {
  Vector2d position_m, velocity_m_s;
};

// The centre of a segment, on the line between its ends.
Moving OnSegment(const SegmentInertia& inertia, const PointMotion& lower, const PointMotion& upper) {
  const double share = inertia.centre_m / (upper.position_m - lower.position_m).norm();
  return {upper.position_m + share * (lower.position_m - upper.position_m),
          upper.velocity_m_s + share * (lower.velocity_m_s - upper.velocity_m_s)};
}

Moving OfTrunk(const LegPoints& points, double along_m, double across_m) {
  const SegmentMotion trunk = SegmentBetween(points[kHip], points[kTrunkTop]);
  return {points[kHip].position_m + along_m * trunk.along + across_m * trunk.across,
          points[kHip].velocity_m_s + trunk.tilt_rate_rad_s * (along_m * trunk.across - across_m * trunk.along)};
}

}  // namespace

CentreOfMass CentreOfMassOf(const LegPoints& points, const LegBody& body, double body_kg, const Vector2d& in_trunk_m) {
  const Vector2d ground_m = GroundPoint(points, body);
  const Moving foot{points[kAnkle].position_m + Vector2d(body.foot.centre_m, -body.ankle_height_m / 2),
                    Vector2d::Zero()},
      shank = OnSegment(body.shank, points[kAnkle], points[kKnee]),
      thigh = OnSegment(body.thigh, points[kKnee], points[kHip]),
      trunk = OfTrunk(points, body.trunk.centre_m + in_trunk_m.x(), in_trunk_m.y());
  const double legs_kg = 2 * (body.foot.mass_kg + body.shank.mass_kg + body.thigh.mass_kg);
  CentreOfMass centre;
  const auto add = [&](const Moving& moving, double mass_kg) {
    centre.position_m += mass_kg / body_kg * (moving.position_m - ground_m);
    centre.velocity_m_s += mass_kg / body_kg * moving.velocity_m_s;
  };
  add(foot, 2 * body.foot.mass_kg);
  add(shank, 2 * body.shank.mass_kg);
  add(thigh, 2 * body.thigh.mass_kg);
  add(trunk, body_kg - legs_kg);
  return centre;
}

RiseMomentum FindMomentum(const LegPath& path, const LegBody& body, double body_kg, const Vector2d& in_trunk_m,
                          double onset_s, double seat_off_s, double standing_s) {
  const auto at = [&](double at_s) {
    const Between b = Locate(path.time_s, at_s);
    if (!path.known[b.before] || !path.known[b.before + 1])
      return CentreOfMass{Vector2d::Constant(RiseMomentum::kUnknown), Vector2d::Constant(RiseMomentum::kUnknown)};
    const CentreOfMass before = CentreOfMassOf(path.frames[b.before], body, body_kg, in_trunk_m),
                       after = CentreOfMassOf(path.frames[b.before + 1], body, body_kg, in_trunk_m);
    return CentreOfMass{(1 - b.part) * before.position_m + b.part * after.position_m,
                        (1 - b.part) * before.velocity_m_s + b.part * after.velocity_m_s};
  };
  RiseMomentum momentum;
  for (int percent = 0; percent < kPercents; ++percent) {
    const double at_s = std::lerp(onset_s, standing_s, percent / 100.0);
    const CentreOfMass& centre = momentum.rows.emplace_back(at(at_s));
    if (const double forward_m_s = centre.velocity_m_s.x();
        forward_m_s > momentum.forward_max_m_s ||
        (std::isnan(momentum.forward_max_m_s) && std::isfinite(forward_m_s))) {
      momentum.forward_max_m_s = forward_m_s;
      momentum.forward_lead_s = seat_off_s - at_s;
    }
    momentum.upward_max_m_s = std::fmax(momentum.upward_max_m_s, centre.velocity_m_s.y());
  }
  const CentreOfMass seat_off = at(seat_off_s);
  momentum.seat_off_m = seat_off.position_m.x();
  momentum.forward_seat_off_m_s = seat_off.velocity_m_s.x();
  return momentum;
}

}  // namespace lake::loads
