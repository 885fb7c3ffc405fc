#include "lake/cuffs/cuff_course.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "lake/core/numbers.h"

namespace lake::cuffs {
namespace {

using Eigen::Vector2d;

// Of a hinge at `place` where the knee is bent by this angle; standing is the other.
LegLoad LoadAt(double flexion_deg, double standing_deg, const Vector2d& place_mm, const CuffOptions& options,
               double stiffness_n_mm) {
  const Vector2d on_thigh_mm = MisfitOf(Vector2d::Zero(), place_mm, standing_deg, 0);  // the same point, thigh's frame
  const LegState leg{
      .thigh_deg = -flexion_deg, .hinge_on_thigh_mm = on_thigh_mm, .hinge_on_shank_mm = place_mm, .held_error_deg = 0};
  CuffOptions weightless = options;
  weightless.thigh_link_kg = weightless.shank_link_kg = 0;
  return LoadOnLeg(leg, weightless, {stiffness_n_mm, stiffness_n_mm});
}

}  // namespace

CuffForce Largest(const std::vector<CuffForce>& course) {
  const auto unknown = std::ranges::find_if(course, [](const CuffForce& at) { return std::isnan(at.force_n); });
  return unknown != course.end() ? *unknown : *std::ranges::max_element(course, {}, &CuffForce::force_n);
}

CuffCourse CourseOf(const std::vector<double>& flexion_deg, const HingePlace& place, const CuffOptions& options) {
  CheckStiffnesses(options);
  const double soft = options.softest_n_mm, stiff = options.stiffest_n_mm, middle = std::sqrt(soft * stiff);
  CuffCourse course;
  for (const double flexion : flexion_deg) {
    const auto load = [&](const Vector2d& place_mm) {
      return LoadAt(flexion, flexion_deg.back(), place_mm, options, middle);
    };
    const LegLoad at_place = load(place.mm);
    // The place may be off in any direction, and in some the cuffs resist more. Forces are nearly in proportion to how
    // far the hinge is off (its levers are long against that), so that those of the error add to those of the place.
    constexpr int kDirections = 24;
    std::vector<LegLoad> of_errors;
    of_errors.reserve(kDirections);
    for (int k = 0; k < kDirections; ++k)
      of_errors.push_back(load(Eigen::Rotation2Dd(2 * M_PI * k / kDirections) * Vector2d(kEllipse95 * place.sd_mm, 0)));
    const auto force = [&](double LegLoad::*of) {
      double open_n = 0;
      for (const LegLoad& one : of_errors) open_n = LargerOrNaN(open_n, one.*of);
      const double n = at_place.*of;
      return CuffForce{n, soft / middle * LargerOrNaN(0, n - open_n), stiff / middle * (n + open_n)};
    };
    course.thigh_n.push_back(force(&LegLoad::largest_thigh_n));
    course.shank_n.push_back(force(&LegLoad::largest_shank_n));
    course.knee_shear_n.push_back(force(&LegLoad::knee_shear_n));
  }
  return course;
}

}  // namespace lake::cuffs
