#include "leg_curves.h"

#include <cmath>

#include "lake/core/angles.h"
#include "leg_space.h"

namespace lake::gait {
namespace {

double DegreesOfVariance(double variance) {
  return DegreesFromRadians(std::sqrt(variance));
}

// Appends a frame's.
void AddDeviations(const LegCurves& curves, std::size_t i, StsDeviations& sd) {
  const MarkerGradient knee = KneeGradient(curves, i), shank = AngleGradient(curves, kShank, i),
                       thigh = AngleGradient(curves, kThigh, i), up = HipHeightGradient(curves);
  sd.hip_height.push_back(std::sqrt(up.Variance(curves, i)));
  sd.hip_up_speed.push_back(std::sqrt(up.RateVariance(curves, i)));
  const auto add = [&](bool known, const MarkerGradient& gradient, std::vector<double>& deg,
                       std::vector<double>& deg_s) {
    deg.push_back(known ? DegreesOfVariance(gradient.Variance(curves, i)) : NAN);
    deg_s.push_back(known ? DegreesOfVariance(gradient.RateVariance(curves, i)) : NAN);
  };
  add(true, knee, sd.knee_deg, sd.knee_deg_s);
  add(true, shank, sd.shank_deg, sd.shank_deg_s);
  const MarkerGradient trunk = curves.HasTrunk() ? AngleGradient(curves, kTrunk, i) : MarkerGradient();
  add(curves.HasTrunk(), trunk, sd.trunk_deg, sd.trunk_deg_s);
  add(curves.HasTrunk(), trunk - thigh, sd.hip_deg, sd.hip_deg_s);
}

// Of a segment's upper marker `gradient`, of its lower one the opposite; in the leg's axes.
MarkerGradient BetweenEnds(const LegCurves& curves, LegSegmentIndex segment, const Eigen::Vector3d& gradient) {
  MarkerGradient result;
  const Eigen::Vector3d in_plane = curves.leg_from_plane.transpose() * gradient;
  result.by_marker[motion::kSegments[segment].upper] = in_plane;
  result.by_marker[motion::kSegments[segment].lower] = -in_plane;
  return result;
}

}  // namespace

Eigen::Vector3d LegCurves::Vector(LegSegmentIndex segment, std::size_t frame) const {
  const auto place = [&](motion::LegMarker m) { return marker[m].point[frame].position; };
  return leg_from_plane * (place(motion::kSegments[segment].upper) - place(motion::kSegments[segment].lower));
}

double LegCurves::AngleRad(LegSegmentIndex segment, std::size_t frame) const {
  const Eigen::Vector3d vector = Vector(segment, frame);
  return std::atan2(vector.x(), vector.y());
}

double LegCurves::Length(LegSegmentIndex segment, std::size_t frame) const {
  return Vector(segment, frame).norm();
}

double MarkerGradient::Rate(const LegCurves& curves, std::size_t frame) const {
  double rate = 0;
  for (std::size_t m = 0; m < static_cast<std::size_t>(curves.markers); ++m)
    rate += by_marker[m].dot(curves.marker[m].point[frame].velocity);
  return rate;
}

double MarkerGradient::Variance(const LegCurves& curves, std::size_t frame) const {
  double variance = 0;
  for (std::size_t m = 0; m < static_cast<std::size_t>(curves.markers); ++m)
    variance += by_marker[m].dot(curves.marker[m].point[frame].position_covariance * by_marker[m]);
  return variance;
}

double MarkerGradient::RateVariance(const LegCurves& curves, std::size_t frame) const {
  double variance = 0;
  for (std::size_t m = 0; m < static_cast<std::size_t>(curves.markers); ++m)
    variance += by_marker[m].squaredNorm() * curves.marker[m].point[frame].velocity_variance;
  return variance;
}

MarkerGradient MarkerGradient::operator-(const MarkerGradient& other) const {
  MarkerGradient difference;
  for (std::size_t m = 0; m < by_marker.size(); ++m) difference.by_marker[m] = by_marker[m] - other.by_marker[m];
  return difference;
}

MarkerGradient AngleGradient(const LegCurves& curves, LegSegmentIndex segment, std::size_t frame) {
  const Eigen::Vector3d vector = curves.Vector(segment, frame);
  return BetweenEnds(curves, segment, Eigen::Vector3d(vector.y(), -vector.x(), 0) / vector.head<2>().squaredNorm());
}

MarkerGradient LengthGradient(const LegCurves& curves, LegSegmentIndex segment, std::size_t frame) {
  return BetweenEnds(curves, segment, curves.Vector(segment, frame).normalized());
}

MarkerGradient KneeGradient(const LegCurves& curves, std::size_t frame) {
  const KneeAngle knee =
      KneeAngleOf(curves.Vector(kShank, frame), curves.Vector(kThigh, frame), curves.flexion_axis[frame]);
  const MarkerGradient shank = BetweenEnds(curves, kShank, knee.by_ak),
                       from_thigh = BetweenEnds(curves, kThigh, -knee.by_kh);
  return shank - from_thigh;
}

MarkerGradient HipHeightGradient(const LegCurves& curves) {
  MarkerGradient gradient;
  gradient.by_marker[kHip] = curves.leg_from_plane.transpose() * Eigen::Vector3d::UnitY();
  return gradient;
}

LegCurves MakeLegCurves(const std::vector<double>& time_s, LegMarkerCurves markers, int count,
                        const Eigen::Matrix2d& leg_from_plane, const std::array<Detections, kLegMarkers>& leg,
                        bool is_facing_given) {
  LegCurves curves;
  curves.markers = count;
  curves.marker = std::move(markers.marker);
  curves.leg_from_plane.topLeftCorner<2, 2>() = leg_from_plane;
  curves.flexion_axis = FlexionAxes(curves, leg, time_s, is_facing_given);
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    AddDeviations(curves, i, curves.sd);
    curves.knee_deg_s.push_back(DegreesFromRadians(KneeGradient(curves, i).Rate(curves, i)));
  }
  curves.knee_sigma_deg = curves.sd.knee_deg;
  return curves;
}

}  // namespace lake::gait
