#include "lake/linkage/wear.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "lake/core/angles.h"
#include "lake/core/cross.h"

namespace lake::linkage {
namespace {

using Eigen::Vector2d;

constexpr int kSamples = 100;  // along a part

Vector2d UnitAt(double direction_rad) {
  return {std::cos(direction_rad), std::sin(direction_rad)};
}

// Of all directions that `allowed` takes, that in which the hull of these points is farthest from the origin. The
// points are the differences of two outlines' corners, so that is how far the outlines are apart. Where the outlines
// are apart it points to a corner of the hull or stands on a side, where they overlap it stands on a side.
template <typename Allowed>
Separation FarthestFromOrigin(const std::vector<Vector2d>& points, const std::vector<double>& ends,
                              const Allowed& allowed) {
  Separation best{-std::numeric_limits<double>::infinity(), 0};
  const auto attempt = [&](double direction_rad) {
    if (!allowed(direction_rad)) return;
    const Vector2d direction = UnitAt(direction_rad);
    double least = std::numeric_limits<double>::infinity();
    for (const Vector2d& point : points) least = std::min(least, direction.dot(point));
    if (least > best.distance_mm) best = {least, direction_rad};
  };
  for (const double end : ends) attempt(end);
  for (std::size_t i = 0; i < points.size(); ++i) {
    attempt(std::atan2(points[i].y(), points[i].x()));
    for (std::size_t j = 0; j < i; ++j) {
      const Vector2d side = points[i] - points[j];
      attempt(std::atan2(side.x(), -side.y()));
      attempt(std::atan2(-side.x(), side.y()));
    }
  }
  return best;
}

struct Least {
  double distance_mm = std::numeric_limits<double>::infinity();
  double at_deg = 0;
  void Take(double distance, double theta_rad) {
    if (distance < distance_mm) {
      distance_mm = distance;
      at_deg = DegreesFromRadians(theta_rad);
    }
  }
};

// Calls with points along a part.
template <typename Use>
void Sample(const WornPart& part, const Pose& pose, const Use& use) {
  const Vector2d from = PlaceOf(part.from, pose), to = PlaceOf(part.to, pose);
  for (int i = 0; i <= kSamples; ++i) use(Vector2d(from + (to - from) * i / double{kSamples}));
}

// Knee to the front edge of a seat that would just clear the parts, 0 if none lies below its surface.
double SeatEdgeNeeded(const Pose& seated, const Seat& seat, const WearOptions& options) {
  double needed_mm = 0;
  for (const WornPart& part : WornPartsOf(options))
    Sample(part, seated, [&](const Vector2d& point) {
      const double radius = part.radius_mm, below = point.x() + radius - seat.surface_mm;
      if (below <= 0) return;
      // How far the round part reaches along the thigh where it crosses the surface, or at its widest.
      const double reach = below >= radius ? radius : std::sqrt(below * (2 * radius - below));
      needed_mm = std::max(needed_mm, point.y() + reach);
    });
  return needed_mm;
}

void CheckLimbs(const Links& links, const UsedRange& range, const Body& body, const WearOptions& options,
                WearCheck& check) {
  constexpr int kPoses = 100;
  Least thigh, shank;
  for (int i = 0; i <= kPoses; ++i) {
    const Pose pose =
        PutOnBody(RequirePose(links, range.stroke.lower_mm + range.stroke.Travel() * i / kPoses), options.placement_mm);
    thigh.Take(LimbSeparation(Limb::kThigh, pose, body, options).distance_mm, pose.theta_rad);
    shank.Take(LimbSeparation(Limb::kShank, pose, body, options).distance_mm, pose.theta_rad);
  }
  check.thigh_clearance_mm = thigh.distance_mm;
  check.thigh_clearance_deg = thigh.at_deg;
  check.shank_clearance_mm = shank.distance_mm;
  check.shank_clearance_deg = shank.at_deg;
}

}  // namespace

Pose PutOnBody(Pose pose, const std::array<double, 2>& placement_mm) {
  const double sine = std::sin(pose.theta_rad), cosine = std::cos(pose.theta_rad);
  const Vector2d anterior(-cosine, -sine), up_shank(-sine, cosine);
  const Vector2d shift = placement_mm[0] * anterior + placement_mm[1] * up_shank;
  for (Vector2d* pin : {&pose.knee, &pose.thigh_pin, &pose.tip, &pose.shank_pin, &pose.mount}) *pin += shift;
  return pose;
}

std::array<WornPart, 6> WornPartsOf(const WearOptions& options) {
  const double half_width = options.bar_width_mm / 2;
  return {{{kPinM, kPinR, options.actuator_diameter_mm / 2},
           {kPinK, kPinP, half_width},
           {kPinP, kPinM, half_width},
           {kPinP, kPinR, half_width},
           {kPinR, kPinS, half_width},
           {kPinK, kPinS, half_width}}};
}

Vector2d PlaceOf(Pin pin, const Pose& pose) {
  switch (pin) {
    case kPinK:
      return pose.knee;
    case kPinP:
      return pose.thigh_pin;
    case kPinR:
      return pose.tip;
    case kPinS:
      return pose.shank_pin;
    default:
      return pose.mount;
  }
}

Seat SeatOf(const Body& body, const WearOptions& options) {
  return {body.thigh.proximal_radius_mm, options.seat_edge_mm > 0 ? options.seat_edge_mm : body.thigh.length_mm / 2};
}

Separation SeparationFrom(const Seat& seat, const WornPart& part, const Pose& pose) {
  const Vector2d corner(seat.surface_mm, seat.edge_mm);
  constexpr double kUp_rad = -std::numbers::pi, kForward_rad = -std::numbers::pi / 2;
  Separation apart = FarthestFromOrigin(
      {PlaceOf(part.from, pose) - corner, PlaceOf(part.to, pose) - corner}, {kUp_rad, kForward_rad},
      [](double direction_rad) { return direction_rad >= kUp_rad && direction_rad <= kForward_rad; });
  apart.distance_mm -= part.radius_mm;
  apart.direction_rad += 2 * std::numbers::pi;
  return apart;
}

double SeatClearance(const Pose& pose, const Body& body, const WearOptions& options) {
  double least_mm = std::numeric_limits<double>::infinity();
  for (const WornPart& part : WornPartsOf(options))
    least_mm = std::min(least_mm, SeparationFrom(SeatOf(body, options), part, pose).distance_mm);
  return least_mm;
}

std::array<Vector2d, 4> OutlineOf(Limb limb, const Body& body) {
  const bool is_thigh = limb == Limb::kThigh;
  const person::LimbSegment& segment = is_thigh ? body.thigh : body.shank;
  const double at_knee = is_thigh ? segment.distal_radius_mm : segment.proximal_radius_mm;
  const double at_end = is_thigh ? segment.proximal_radius_mm : segment.distal_radius_mm;
  return {Vector2d(at_knee, 0), {at_end, segment.length_mm}, {-at_end, segment.length_mm}, {-at_knee, 0}};
}

Vector2d InLimb(Limb limb, const Vector2d& point, double theta_rad) {
  if (limb == Limb::kThigh) return point;
  const Vector2d posterior = UnitAt(theta_rad);
  return {point.dot(posterior), Cross(point, posterior)};
}

Separation LimbSeparation(Limb limb, const Pose& pose, const Body& body, const WearOptions& options) {
  const WornPart actuator = WornPartsOf(options)[0];
  std::vector<Vector2d> differences;
  for (const Pin pin : {actuator.from, actuator.to})
    for (const Vector2d& corner : OutlineOf(limb, body))
      differences.push_back(InLimb(limb, PlaceOf(pin, pose), pose.theta_rad) - corner);
  Separation apart = FarthestFromOrigin(differences, {}, [](double) { return true; });
  apart.distance_mm -= actuator.radius_mm;
  return apart;
}

WearCheck CheckWear(const Links& links, const UsedRange& range, const Body& body, const WearOptions& options) {
  const auto pose_at = [&](double stroke_mm) { return PutOnBody(RequirePose(links, stroke_mm), options.placement_mm); };
  const Pose lower = pose_at(range.stroke.lower_mm), upper = pose_at(range.stroke.upper_mm);
  const Pose& flexed = lower.theta_rad > upper.theta_rad ? lower : upper;
  const Pose& standing = lower.theta_rad > upper.theta_rad ? upper : lower;
  const auto at_right_angle = StrokeForAngle(links, range, kSeated_rad);
  const Pose seated = at_right_angle ? pose_at(*at_right_angle) : flexed.theta_rad < kSeated_rad ? flexed : standing;

  WearCheck check{.mount = options.mount,
                  .meets_seat = options.MeetsSeat(),
                  .meets_limbs = options.MeetsLimbs(),
                  .seated_stroke_mm = seated.stroke_mm,
                  .seated_deg = DegreesFromRadians(seated.theta_rad),
                  .standing_stroke_mm = standing.stroke_mm,
                  .standing_deg = DegreesFromRadians(standing.theta_rad),
                  .mount_below_hip_mm = body.thigh.length_mm - seated.mount.y() - options.bar_width_mm / 2,
                  .mount_behind_thigh_mm = seated.mount.x() - body.thigh.RadiusAt(seated.mount.y()),
                  .seat_clearance_mm = SeatClearance(seated, body, options),
                  .seat_edge_needed_mm = SeatEdgeNeeded(seated, SeatOf(body, options), options)};
  CheckLimbs(links, range, body, options, check);
  for (const WornPart& part : WornPartsOf(options))
    Sample(part, standing, [&](const Vector2d& point) {
      const double behind = point.x() + part.radius_mm - body.thigh.RadiusAt(point.y());
      check.reach_behind_standing_mm = std::max(check.reach_behind_standing_mm, behind);
    });
  return check;
}

}  // namespace lake::linkage
