#include "leg_space.h"

#include <ceres/jet.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/error.h"

namespace lake::gait {
namespace {

constexpr int kParts = 6;  // of both vectors
using PartsJet = ceres::Jet<double, kParts>;
using Vector3Jet = Eigen::Matrix<PartsJet, 3, 1>;

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

KneeAngle KneeAngleOf(const Eigen::Vector3d& ak, const Eigen::Vector3d& kh, const Eigen::Vector3d& axis) {
  Vector3Jet ak_jet, kh_jet;
  for (int i = 0; i < 3; ++i) {
    ak_jet[i] = PartsJet(ak[i], i);
    kh_jet[i] = PartsJet(kh[i], 3 + i);
  }
  const PartsJet angle = KneeAngleAbout(ak_jet, kh_jet, axis);
  return {angle.a, angle.v.head<3>(), angle.v.tail<3>()};
}

std::vector<Eigen::Vector3d> FlexionAxes(const LegCurves& curves, const std::array<Detections, kLegMarkers>& leg,
                                         const std::vector<double>& time_s, bool is_facing_given) {
  constexpr double kBent_deg = 30;
  constexpr double kAgainstFacing = -0.5;  // mean of the normals' parts along that of the sagittal plane
  const std::size_t n = time_s.size();
  std::vector<Eigen::Vector3d> axes(n, Eigen::Vector3d::UnitZ());
  if (leg[kAnkle].lateral.empty()) return axes;
  std::vector<std::size_t> bent;
  double along = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3d ak = curves.Vector(kShank, i), kh = curves.Vector(kThigh, i);
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
