#include "lake/linkage/body.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "lake/core/angles.h"
#include "lake/core/cross.h"
#include "lake/core/error.h"
#include "lake/core/plausible.h"

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

constexpr int kSamples = 100;  // along a part

Vector2d AtHeading(double heading_rad) {
  return {std::cos(heading_rad), std::sin(heading_rad)};
}

// Of all directions that `allowed` takes, that in which the hull of these points is farthest from the origin. The
// points are the differences of two outlines' corners, so that is how far the outlines are apart. Where the outlines
// are apart it points to a corner of the hull or stands on a side, where they overlap it stands on a side.
template <typename Allowed>
Separation FarthestFromOrigin(const std::vector<Vector2d>& points, const std::vector<double>& ends,
                              const Allowed& allowed) {
  Separation best{-std::numeric_limits<double>::infinity(), 0};
  const auto attempt = [&](double heading_rad) {
    if (!allowed(heading_rad)) return;
    const Vector2d direction = AtHeading(heading_rad);
    double least = std::numeric_limits<double>::infinity();
    for (const Vector2d& point : points) least = std::min(least, direction.dot(point));
    if (least > best.distance_mm) best = {least, heading_rad};
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

double LimbSegment::RadiusAt(double from_distal_mm) const {
  const double fraction = std::clamp(from_distal_mm / length_mm, 0.0, 1.0);
  return distal_radius_mm + fraction * (proximal_radius_mm - distal_radius_mm);
}

Body BodyOf(double height_mm, double mass_kg) {
  for (const auto& [value, range] : {std::pair{height_mm, kPlausibleStature}, {mass_kg, kPlausibleMass}})
    if (!range.Holds(value))
      throw Fail("a body of {} {} is outside {}..{} {}", value, range.unit, range.low, range.high, range.unit);
  Body body{.height_mm = height_mm,
            .mass_kg = mass_kg,
            .thigh = SegmentOf(kThigh, kThigh.length * height_mm, mass_kg),
            .shank = SegmentOf(kShank, kShank.length * height_mm, mass_kg),
            .foot_length_mm = kFootLength * height_mm,
            .ankle_height_mm = kAnkleHeight * height_mm,
            .trunk_length_mm = kTrunk.length * height_mm};
  // An ellipse of area pi / 4 x breadth x depth over the trunk's length.
  body.trunk_depth_mm =
      VolumeOf(kTrunk, mass_kg) / (std::numbers::pi / 4 * kShoulderBreadth * height_mm * body.trunk_length_mm);
  body.head_height_mm = kHeadHeight * height_mm;
  body.neck_length_mm = kNeckLength * height_mm;
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
    if (!kPlausibleSegment.Holds(length_mm))
      throw Fail("a thigh of {} mm and a shank of {} mm: both must be within {}..{} mm", leg.thigh_mm, leg.shank_mm,
                 kPlausibleSegment.low, kPlausibleSegment.high);
  body.thigh = SegmentOf(kThigh, leg.thigh_mm, body.mass_kg);
  body.shank = SegmentOf(kShank, leg.shank_mm, body.mass_kg);
  return body;
}

Body BodyOf(const BodySize& size) {
  constexpr double kAverageHeight_mm = 1800, kAverageMass_kg = 80;
  const double height_mm = size.height_mm.value_or(size.leg ? HeightOf_mm(*size.leg) : kAverageHeight_mm);
  const double mass_kg = size.mass_kg.value_or(MassAtHeight_kg(height_mm, kAverageHeight_mm, kAverageMass_kg));
  const Body body = BodyOf(height_mm, mass_kg);
  return size.leg ? WithLeg(body, *size.leg) : body;
}

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
  Separation apart =
      FarthestFromOrigin({PlaceOf(part.from, pose) - corner, PlaceOf(part.to, pose) - corner}, {kUp_rad, kForward_rad},
                         [](double heading_rad) { return heading_rad >= kUp_rad && heading_rad <= kForward_rad; });
  apart.distance_mm -= part.radius_mm;
  apart.heading_rad += 2 * std::numbers::pi;
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
  const LimbSegment& segment = is_thigh ? body.thigh : body.shank;
  const double at_knee = is_thigh ? segment.distal_radius_mm : segment.proximal_radius_mm;
  const double at_end = is_thigh ? segment.proximal_radius_mm : segment.distal_radius_mm;
  return {Vector2d(at_knee, 0), {at_end, segment.length_mm}, {-at_end, segment.length_mm}, {-at_knee, 0}};
}

Vector2d InLimb(Limb limb, const Vector2d& point, double theta_rad) {
  if (limb == Limb::kThigh) return point;
  const Vector2d posterior = AtHeading(theta_rad);
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
