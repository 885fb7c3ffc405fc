#include "lake/cuffs/cuff_course.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/numbers.h"

namespace lake::cuffs {
namespace {

using Eigen::Vector2d;

// N, of a hinge at `place_mm`.
struct Forces {
  double thigh_n = 0, shank_n = 0, knee_shear_n = 0;
};
Forces ForcesAt(double flexion_deg, double standing_deg, const Vector2d& place_mm, const CuffOptions& options,
                double stiffness_n_mm) {
  const std::vector<PlacedCuff> cuffs = CuffsOf(options);
  const auto slips =
      SlipsOf(options, RadiansFromDegrees(flexion_deg), RadiansFromDegrees(standing_deg), place_mm.x(), place_mm.y());
  Forces forces;
  double across_n = 0;
  for (std::size_t i = 0; i < cuffs.size(); ++i) {
    const auto [x_mm, y_mm] = slips[i];
    double& largest_n = cuffs[i].on_thigh ? forces.thigh_n : forces.shank_n;
    largest_n = LargerOrNaN(largest_n, stiffness_n_mm * std::hypot(x_mm, y_mm));
    if (!cuffs[i].on_thigh) across_n += stiffness_n_mm * x_mm;
  }
  forces.knee_shear_n = std::abs(across_n);
  return forces;
}

}  // namespace

CuffForce Largest(const std::vector<CuffForce>& course) {
  const auto unknown = std::ranges::find_if(course, [](const CuffForce& at) { return std::isnan(at.force_n); });
  return unknown != course.end() ? *unknown : *std::ranges::max_element(course, {}, &CuffForce::force_n);
}

CuffCourse CourseOf(const std::vector<double>& flexion_deg, const HingePlace& place, const CuffOptions& options) {
  CheckCuffs(options);
  CheckStiffnesses(options);
  const double soft = options.softest_n_mm, stiff = options.stiffest_n_mm, middle = std::sqrt(soft * stiff);
  CuffCourse course;
  for (const double flexion : flexion_deg) {
    const auto load = [&](const Vector2d& place_mm) {
      return ForcesAt(flexion, flexion_deg.back(), place_mm, options, middle);
    };
    const Forces at_place = load(place.mm);
    // The place may be off in any direction, and in some the cuffs resist more. Forces are nearly in proportion to how
    // far the hinge is off (its levers are long against that), so that those of the error add to those of the place.
    constexpr int kDirections = 24;
    std::vector<Forces> of_errors;
    of_errors.reserve(kDirections);
    for (int k = 0; k < kDirections; ++k)
      of_errors.push_back(load(Eigen::Rotation2Dd(2 * M_PI * k / kDirections) * Vector2d(kEllipse95 * place.sd_mm, 0)));
    const auto force = [&](double Forces::*of) {
      double open_n = 0;
      for (const Forces& one : of_errors) open_n = LargerOrNaN(open_n, one.*of);
      const double n = at_place.*of;
      return CuffForce{n, soft / middle * LargerOrNaN(0, n - open_n), stiff / middle * (n + open_n)};
    };
    course.thigh_n.push_back(force(&Forces::thigh_n));
    course.shank_n.push_back(force(&Forces::shank_n));
    course.knee_shear_n.push_back(force(&Forces::knee_shear_n));
  }
  return course;
}

}  // namespace lake::cuffs
