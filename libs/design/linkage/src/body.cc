#include "lake/linkage/body.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "lake/core/angles.h"
#include "lake/core/error.h"

namespace lake::linkage {
namespace {

using Eigen::Vector2d;

// Ratios of one segment: length / height, mass / body mass, centre of mass from the proximal end / length, density.
struct SegmentRatios {
  double length, mass, centre, density_kg_m3;
};
constexpr SegmentRatios kThigh{0.245, 0.100, 0.433, 1050};
constexpr SegmentRatios kShank{0.246, 0.0465, 0.433, 1090};
constexpr SegmentRatios kTrunk{0.288, 0.497, 0.50, 1030};
constexpr double kFootLength = 0.152, kAnkleHeight = 0.039, kShoulderBreadth = 0.259, kNeckLength = 0.052,
                 kHeadHeight = 0.130;

double VolumeOf(const SegmentRatios& ratios, double mass_kg) {
  constexpr double kCubicMillimetresPerCubicMetre = 1e9;
  return ratios.mass * mass_kg / ratios.density_kg_m3 * kCubicMillimetresPerCubicMetre;
}

// Distal over proximal radius k of the frustum with centre of mass c: c = (1 + 2k + 3k^2) / (4 (1 + k + k^2)).
double TaperOf(double centre) {
  const double a = 3 - 4 * centre, b = 2 - 4 * centre, c = 1 - 4 * centre;
  return (-b + std::sqrt(b * b - 4 * a * c)) / (2 * a);
}

LimbSegment SegmentOf(const SegmentRatios& ratios, double length_mm, double mass_kg) {
  const double k = TaperOf(ratios.centre);
  const double radius = std::sqrt(3 * VolumeOf(ratios, mass_kg) / (std::numbers::pi * length_mm * (1 + k + k * k)));
  return {length_mm, radius, k * radius};
}

// A straight part of the linkage with rounded ends.
struct Bar {
  Vector2d from, to;
  double radius;
};

constexpr int kSamples = 100;  // along a bar; distances are convex or nearly so between them, far below a millimetre
Vector2d PointOf(const Bar& bar, int sample) {
  return bar.from + (bar.to - bar.from) * sample / double{kSamples};
}

Bar ActuatorOf(const Pose& pose, const WearOptions& options) {
  return {pose.mount, pose.tip, options.actuator_diameter_mm / 2};
}

std::vector<Bar> PartsOf(const Pose& pose, const WearOptions& options) {
  const double half_width = options.bar_width_mm / 2;
  return {ActuatorOf(pose, options),
          {pose.knee, pose.thigh_pin, half_width},
          {pose.thigh_pin, pose.mount, half_width},
          {pose.thigh_pin, pose.tip, half_width},
          {pose.tip, pose.shank_pin, half_width},
          {pose.knee, pose.shank_pin, half_width}};
}

// From a point to a limb's side view; `along` from its distal end, `across` its axis. Negative inside.
double DistanceToLimb(const LimbSegment& limb, double along, double across) {
  const double slope = (limb.proximal_radius_mm - limb.distal_radius_mm) / limb.length_mm;
  const double to_side = (std::abs(across) - limb.RadiusAt(along)) / std::hypot(1, slope);
  const double to_end = std::max(-along, along - limb.length_mm);
  if (to_end <= 0) return to_side <= 0 ? std::max(to_side, to_end) : to_side;
  return std::hypot(to_end, std::max(0.0, std::abs(across) - limb.RadiusAt(along)));
}

// The seat is all that lies below its surface and behind its front edge; thigh frame, thigh level.
double DistanceToSeat(const Vector2d& point, double surface_mm, double edge_mm) {
  const double above = surface_mm - point.x(), before = edge_mm - point.y();
  if (above <= 0 && before <= 0) return std::max(above, before);
  return std::hypot(std::max(0.0, above), std::max(0.0, before));
}

struct Least {
  double distance_mm = std::numeric_limits<double>::infinity();
  double at_deg = 0;
  void Take(double distance, double theta_rad) {
    if (distance < distance_mm) distance_mm = distance, at_deg = DegreesFromRadians(theta_rad);
  }
};

void CheckSeat(const std::vector<Bar>& parts, double surface_mm, double edge_mm, WearCheck& check) {
  check.seat_clearance_mm = std::numeric_limits<double>::infinity();
  for (const Bar& part : parts)
    for (int i = 0; i <= kSamples; ++i) {
      const Vector2d point = PointOf(part, i);
      check.seat_clearance_mm =
          std::min(check.seat_clearance_mm, DistanceToSeat(point, surface_mm, edge_mm) - part.radius);
      const double below = point.x() + part.radius - surface_mm;
      if (below <= 0) continue;
      // How far the round part reaches along the thigh where it crosses the surface, or at its widest.
      const double reach = below >= part.radius ? part.radius : std::sqrt(below * (2 * part.radius - below));
      check.seat_edge_needed_mm = std::max(check.seat_edge_needed_mm, point.y() + reach);
    }
}

void CheckLimb(const Links& links, const UsedRange& range, const Body& body, const WearOptions& options,
               WearCheck& check) {
  constexpr int kPoses = 100;
  Least thigh, shank;
  for (int i = 0; i <= kPoses; ++i) {
    const Pose pose = RequirePose(links, range.stroke.lower_mm + range.stroke.Travel() * i / kPoses);
    const Vector2d down_shank(std::sin(pose.theta_rad), -std::cos(pose.theta_rad));
    const Bar actuator = ActuatorOf(pose, options);
    for (int j = 0; j <= kSamples; ++j) {
      const Vector2d point = PointOf(actuator, j);
      thigh.Take(DistanceToLimb(body.thigh, point.y(), point.x()) - actuator.radius, pose.theta_rad);
      const double across = point.x() * down_shank.y() - point.y() * down_shank.x();
      const double from_ankle = body.shank.length_mm - point.dot(down_shank);
      shank.Take(DistanceToLimb(body.shank, from_ankle, across) - actuator.radius, pose.theta_rad);
    }
  }
  check.thigh_clearance_mm = thigh.distance_mm, check.thigh_clearance_deg = thigh.at_deg;
  check.shank_clearance_mm = shank.distance_mm, check.shank_clearance_deg = shank.at_deg;
}

}  // namespace

double LimbSegment::RadiusAt(double from_distal_mm) const {
  const double fraction = std::clamp(from_distal_mm / length_mm, 0.0, 1.0);
  return distal_radius_mm + fraction * (proximal_radius_mm - distal_radius_mm);
}

Body BodyOf(double height_mm, double mass_kg) {
  if (!(height_mm >= 500 && height_mm <= 2500)) throw Fail("a body of {} cm is outside 50..250 cm", height_mm / 10);
  if (!(mass_kg >= 10 && mass_kg <= 400)) throw Fail("a body of {} kg is outside 10..400 kg", mass_kg);
  Body body;
  body.height_mm = height_mm, body.mass_kg = mass_kg;
  body.thigh = SegmentOf(kThigh, kThigh.length * height_mm, mass_kg);
  body.shank = SegmentOf(kShank, kShank.length * height_mm, mass_kg);
  body.foot_length_mm = kFootLength * height_mm, body.ankle_height_mm = kAnkleHeight * height_mm;
  body.trunk_length_mm = kTrunk.length * height_mm;
  // An ellipse of area pi / 4 x breadth x depth over the trunk's length.
  body.trunk_depth_mm =
      VolumeOf(kTrunk, mass_kg) / (std::numbers::pi / 4 * kShoulderBreadth * height_mm * body.trunk_length_mm);
  body.head_height_mm = kHeadHeight * height_mm, body.neck_length_mm = kNeckLength * height_mm;
  return body;
}

double HeightOf_mm(const LegLengths& leg) {
  return (leg.thigh_mm + leg.shank_mm) / (kThigh.length + kShank.length);
}

double MassAtHeight_kg(double height_mm, double other_height_mm, double other_mass_kg) {
  const double ratio = height_mm / other_height_mm;
  return other_mass_kg * ratio * ratio;
}

Body WithLeg(Body body, const LegLengths& leg) {
  for (const double length_mm : {leg.thigh_mm, leg.shank_mm})
    if (!(length_mm >= 100 && length_mm <= 1000))
      throw Fail("a thigh of {} mm and a shank of {} mm: both must be within 100..1000 mm", leg.thigh_mm, leg.shank_mm);
  body.thigh = SegmentOf(kThigh, leg.thigh_mm, body.mass_kg);
  body.shank = SegmentOf(kShank, leg.shank_mm, body.mass_kg);
  return body;
}

WearCheck CheckWear(const Links& links, const UsedRange& range, const Body& body, const WearOptions& options) {
  constexpr double kSeated_rad = std::numbers::pi / 2;
  const double seat_edge = options.seat_edge_mm > 0 ? options.seat_edge_mm : body.thigh.length_mm / 2;
  const Pose lower = RequirePose(links, range.stroke.lower_mm), upper = RequirePose(links, range.stroke.upper_mm);
  const Pose& flexed = lower.theta_rad > upper.theta_rad ? lower : upper;
  const Pose& standing = lower.theta_rad > upper.theta_rad ? upper : lower;
  const auto at_right_angle = StrokeForAngle(links, range, kSeated_rad);
  const Pose seated = at_right_angle                   ? RequirePose(links, *at_right_angle)
                      : flexed.theta_rad < kSeated_rad ? flexed
                                                       : standing;

  WearCheck check;
  check.seated_stroke_mm = seated.stroke_mm, check.seated_deg = DegreesFromRadians(seated.theta_rad);
  check.standing_stroke_mm = standing.stroke_mm, check.standing_deg = DegreesFromRadians(standing.theta_rad);
  check.mount_below_hip_mm = body.thigh.length_mm - seated.mount.y() - options.bar_width_mm / 2;
  check.mount_behind_thigh_mm = seated.mount.x() - body.thigh.RadiusAt(seated.mount.y());
  CheckSeat(PartsOf(seated, options), body.thigh.proximal_radius_mm, seat_edge, check);
  CheckLimb(links, range, body, options, check);
  for (const Bar& part : PartsOf(standing, options))
    for (int i = 0; i <= kSamples; ++i) {
      const Vector2d point = PointOf(part, i);
      const double behind = point.x() + part.radius - body.thigh.RadiusAt(point.y());
      check.reach_behind_standing_mm = std::max(check.reach_behind_standing_mm, behind);
    }
  return check;
}

}  // namespace lake::linkage
