#include "leg_space.h"

#include <ceres/jet.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/error.h"

namespace lake::gait {
namespace {

// θ_shank, θ_thigh, |AK|, |KH| in the plane, and both vectors' parts across it.
constexpr int kParts = 6;
using PartsJet = ceres::Jet<double, kParts>;
using Vector3Jet = Eigen::Matrix<PartsJet, 3, 1>;
constexpr std::array<LegState, 4> kPlaneParts = {kShankAngle, kThighAngle, kShankLength, kThighLength};

// The angle between the vectors, signed about the flexion axis. Signed as it is it would jump where a knee that also
// bends to the side passes through straight; there the bend to the side counts less, so that it passes through 0.
template <typename T>
T KneeAngleAbout(const Eigen::Matrix<T, 3, 1>& ak, const Eigen::Matrix<T, 3, 1>& kh, const Eigen::Vector3d& axis) {
  using std::atan2, std::sqrt;
  constexpr double kAside = 0.4;    // the angle passes through 0 with at most 1/0.4 times the speed about the axis
  constexpr double kLeast = 1e-12;  // the roots have no derivative where the leg is exactly straight
  const T lengths = sqrt(ak.squaredNorm() * kh.squaredNorm());
  const Eigen::Matrix<T, 3, 1> normal(ak[1] * kh[2] - ak[2] * kh[1], ak[2] * kh[0] - ak[0] * kh[2],
                                      ak[0] * kh[1] - ak[1] * kh[0]);
  const T about = (normal[0] * axis[0] + normal[1] * axis[1] + normal[2] * axis[2]) / lengths;
  T aside2(0.0);
  for (int i = 0; i < 3; ++i) {
    const T aside = normal[i] / lengths - about * axis[i];
    aside2 += aside * aside;
  }
  const T sine = about * sqrt((about * about + aside2 + kLeast) / (about * about + kAside * kAside * aside2 + kLeast));
  return atan2(sine, (ak[0] * kh[0] + ak[1] * kh[1] + ak[2] * kh[2]) / lengths);
}

struct KneeAngle {
  double value_rad;
  Eigen::Matrix<double, kParts, 1> by_parts;
};

KneeAngle KneeAngleOf(const StateVector& state, double ak_across, double kh_across, const Eigen::Vector3d& axis) {
  std::array<PartsJet, kParts> part;
  for (std::size_t k = 0; k < kPlaneParts.size(); ++k) part[k] = PartsJet(state[kPlaneParts[k]], static_cast<int>(k));
  part[4] = PartsJet(ak_across, 4);
  part[5] = PartsJet(kh_across, 5);
  const Vector3Jet ak(part[2] * sin(part[0]), part[2] * cos(part[0]), part[4]),
      kh(part[3] * sin(part[1]), part[3] * cos(part[1]), part[5]);
  const PartsJet angle = KneeAngleAbout(ak, kh, axis);
  return {angle.a, angle.v};
}

// The knee's flexion axis of every frame, in the leg's axes and across them: the normal of the segments' own plane
// where the knee bends so far that it can be no hyperextension, and in between what leads from one such normal to the
// next. Without a bend it is the normal of the sagittal plane. A facing that was given decides the sign of all.
std::vector<Eigen::Vector3d> FlexionAxes(const LegCurves& curves, const std::array<Detections, kLegMarkers>& leg,
                                         const std::vector<double>& time_s, bool is_facing_given) {
  constexpr double kBent_deg = 30;
  constexpr double kAgainstFacing = -0.5;  // mean of the normals' parts along that of the sagittal plane
  const std::size_t n = curves.state.size();
  const MarkerCurve &a = curves.marker[kAnkle], &k = curves.marker[kKnee], &h = curves.marker[kHip];
  std::vector<Eigen::Vector3d> axes(n, Eigen::Vector3d::UnitZ());
  std::vector<std::size_t> bent;
  double along = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const StateVector& s = curves.state[i];
    const Eigen::Vector3d ak(s[kShankLength] * std::sin(s[kShankAngle]), s[kShankLength] * std::cos(s[kShankAngle]),
                             k.lateral[i] - a.lateral[i]),
        kh(s[kThighLength] * std::sin(s[kThighAngle]), s[kThighLength] * std::cos(s[kThighAngle]),
           h.lateral[i] - k.lateral[i]);
    const bool is_seen = leg[kAnkle].trusted[i] && leg[kKnee].trusted[i] && leg[kHip].trusted[i];
    if (!is_seen || DegreesFromRadians(std::atan2(ak.cross(kh).norm(), ak.dot(kh))) < kBent_deg) continue;
    axes[i] = ak.cross(kh).normalized();
    along += axes[i].z();
    bent.push_back(i);
  }
  if (bent.empty()) return axes;
  for (std::size_t i = 0, next = 0; i < n; ++i) {
    while (next < bent.size() && bent[next] < i) ++next;
    const std::size_t after = bent[std::min(next, bent.size() - 1)], before = bent[next == 0 ? 0 : next - 1];
    if (after == i) continue;
    const double share =
        after > before && after > i ? (time_s[i] - time_s[before]) / (time_s[after] - time_s[before]) : 0;
    axes[i] = ((1 - share) * axes[before] + share * axes[after]).normalized();
  }
  if (is_facing_given && along < kAgainstFacing * static_cast<double>(bent.size()))
    for (Eigen::Vector3d& axis : axes) axis = -axis;
  return axes;
}

void SmoothAcross(const motion::MarkerRecording& recording, const Detections& d, const SplineGrid& grid,
                  const LegFitOptions& options, MarkerCurve& curve) {
  std::vector<double> values = d.lateral;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!d.trusted[i]) values[i] = motion::LegSample::kUnknown;
  SmoothCoordinate smooth = SmoothByItself(grid, recording.time_s, values, d.plane_sigma, options);
  curve.lateral = std::move(smooth.value);
  curve.lateral_rate = std::move(smooth.rate);
  curve.lateral_variance = std::move(smooth.variance);
}

double LargestAngleDeg(const Detections& below, const Detections& above) {
  double largest = 0;
  for (std::size_t i = 0; i < below.trusted.size(); ++i)
    if (below.trusted[i] && above.trusted[i])
      largest = std::max(largest, std::atan2(std::abs(above.lateral[i] - below.lateral[i]),
                                             (above.in_plane[i] - below.in_plane[i]).norm()));
  return DegreesFromRadians(largest);
}

}  // namespace

void SetLateral(const LateralPlaces& lateral, std::array<Detections, kLegMarkers>& leg) {
  for (Detections& d : leg) {
    if (!d.track) continue;
    const auto found = lateral.find(d.name);
    if (found == lateral.end() || found->second.size() != d.seen.size())
      throw Fail("leg fit: marker '{}' has no lateral places", d.name);
    d.lateral = found->second;
  }
}

void AddAcross(const motion::MarkerRecording& recording, const std::array<Detections, kLegMarkers>& leg,
               const LegModel& model, const LegFitOptions& options, LegCurves& curves) {
  for (std::size_t m = 0; m < static_cast<std::size_t>(curves.markers); ++m)
    SmoothAcross(recording, leg[m], model.grid, options, curves.marker[m]);
  curves.flexion_axis = FlexionAxes(curves, leg, recording.time_s, options.facing.has_value());
  const MarkerCurve &a = curves.marker[kAnkle], &k = curves.marker[kKnee], &h = curves.marker[kHip];
  for (std::size_t i = 0; i < recording.Frames(); ++i) {
    const KneeAngle knee =
        KneeAngleOf(curves.state[i], k.lateral[i] - a.lateral[i], h.lateral[i] - k.lateral[i], curves.flexion_axis[i]);
    Eigen::Matrix4d covariance;
    Eigen::Vector4d rate;
    for (int r = 0; r < 4; ++r) {
      rate[r] = curves.rate[i][kPlaneParts[static_cast<std::size_t>(r)]];
      for (int c = 0; c < 4; ++c)
        covariance(r, c) =
            curves.covariance[i](kPlaneParts[static_cast<std::size_t>(r)], kPlaneParts[static_cast<std::size_t>(c)]);
    }
    const Eigen::Vector4d by_plane = knee.by_parts.head<4>();
    const double by_ak = knee.by_parts[4], by_kh = knee.by_parts[5];
    const double lateral_variance = by_ak * by_ak * a.lateral_variance[i] +
                                    (by_ak - by_kh) * (by_ak - by_kh) * k.lateral_variance[i] +
                                    by_kh * by_kh * h.lateral_variance[i];
    // What slow noise adds in the plane, it adds in space.
    const double slow_rad2 =
        std::max(0.0, std::pow(RadiansFromDegrees(curves.knee_sigma_deg[i]), 2) - KneeVariance(curves.covariance[i]));
    curves.knee_sigma_deg[i] =
        DegreesFromRadians(std::sqrt(by_plane.dot(covariance * by_plane) + lateral_variance + slow_rad2));
    curves.knee_deg_s[i] = DegreesFromRadians(by_plane.dot(rate) + by_ak * (k.lateral_rate[i] - a.lateral_rate[i]) +
                                              by_kh * (h.lateral_rate[i] - k.lateral_rate[i]));
  }
}

double KneeInSpaceDeg(const Eigen::Vector3d& ak, const Eigen::Vector3d& kh, const Eigen::Vector3d& flexion_axis) {
  return DegreesFromRadians(KneeAngleAbout<double>(ak, kh, flexion_axis));
}

LateralReport ReportLateral(const std::array<Detections, kLegMarkers>& leg) {
  LateralReport report;
  double square = 0;
  std::size_t count = 0;
  for (const LegMarker m : {kAnkle, kKnee, kHip}) {
    double sum = 0, sum2 = 0;
    std::size_t n = 0;
    for (std::size_t i = 0; i < leg[m].lateral.size(); ++i)
      if (leg[m].trusted[i]) {
        sum += leg[m].lateral[i];
        sum2 += leg[m].lateral[i] * leg[m].lateral[i];
        ++n;
      }
    if (n > 0) {
      square += sum2 - sum * sum / static_cast<double>(n);
      count += n;
    }
  }
  report.rms_mm = std::sqrt(std::max(0.0, square / static_cast<double>(std::max<std::size_t>(count, 1))));
  report.largest_shank_deg = LargestAngleDeg(leg[kAnkle], leg[kKnee]);
  report.largest_thigh_deg = LargestAngleDeg(leg[kKnee], leg[kHip]);
  return report;
}

}  // namespace lake::gait
