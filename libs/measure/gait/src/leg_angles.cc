#include "lake/gait/leg_angles.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/cross.h"
#include "lake/core/statistics.h"

namespace lake::gait {
namespace {

// The plane's direction that is anterior in the leg.
Eigen::Vector2d Anterior(motion::Facing facing, const Eigen::Vector2d& up) {
  const Eigen::Vector2d right(up.y(), -up.x());
  return facing == motion::Facing::kRight ? right : Eigen::Vector2d(-right);
}

constexpr std::array kNames = {&LegMarkers::ankle, &LegMarkers::knee, &LegMarkers::hip, &LegMarkers::waist};
constexpr std::array kPoints = {&LegPoints::ankle, &LegPoints::knee, &LegPoints::hip, &LegPoints::waist};

}  // namespace

std::string LegMarkers::Of(motion::LegMarker marker) const {
  return marker < kNames.size() ? this->*kNames[marker] : motion::kMarkerNames.at(marker);
}

std::optional<Eigen::Vector2d> LegPoints::Of(motion::LegMarker marker) const {
  return marker < kPoints.size() ? this->*kPoints[marker] : std::nullopt;
}

Eigen::Vector2d LegFromPlane(const Eigen::Vector2d& in_plane, motion::Facing facing, const Eigen::Vector2d& up) {
  return {in_plane.dot(Anterior(facing, up)), in_plane.dot(up)};
}

Eigen::Vector2d PlaneFromLeg(const Eigen::Vector2d& in_leg, motion::Facing facing, const Eigen::Vector2d& up) {
  return in_leg.x() * Anterior(facing, up) + in_leg.y() * up;
}

double SegmentAngleDeg(const Eigen::Vector2d& in_leg) {
  return DegreesFromRadians(std::atan2(in_leg.x(), in_leg.y()));
}

void SetSegment(const motion::Segment& segment, const Eigen::Vector2d& in_leg, motion::LegSample& sample) {
  sample.*segment.vector = in_leg;
  sample.*segment.angle.deg =
      segment.Lies() ? DegreesFromRadians(std::atan2(in_leg.y(), in_leg.x())) : SegmentAngleDeg(in_leg);
}

double KneeAngleDeg(const Eigen::Vector2d& ak_in_leg, const Eigen::Vector2d& kh_in_leg) {
  return DegreesFromRadians(std::atan2(Cross(ak_in_leg, kh_in_leg), ak_in_leg.dot(kh_in_leg)));
}

motion::LegSample MakeLegSample(const LegPoints& points, motion::Facing facing, const Eigen::Vector2d& up) {
  motion::LegSample sample;
  for (const motion::Segment& segment : motion::kSegments)
    if (const auto lower = points.Of(segment.lower), upper = points.Of(segment.upper); lower && upper)
      SetSegment(segment, LegFromPlane(*upper - *lower, facing, up), sample);
  if (points.ankle && points.knee && points.hip) sample.knee_deg = KneeAngleDeg(sample.ak, sample.kh);
  return sample;
}

FacingFound FindFacing(const std::vector<LegPoints>& frames) {
  const Eigen::Vector2d up = Eigen::Vector2d::UnitY();  // the side of a fold does not depend on it
  std::vector<double> knee_deg;
  for (const LegPoints& points : frames) {
    const motion::LegSample sample = MakeLegSample(points, motion::Facing::kRight, up);
    if (std::isfinite(sample.knee_deg)) knee_deg.push_back(sample.knee_deg);
  }
  if (knee_deg.empty()) return {};
  // Quantiles rather than extremes: a few wrong detections must not decide.
  const double to_right = Quantile(knee_deg, 0.98), to_left = -Quantile(knee_deg, 0.02);
  return {to_right >= to_left ? motion::Facing::kRight : motion::Facing::kLeft, std::max(to_right, to_left)};
}

}  // namespace lake::gait
