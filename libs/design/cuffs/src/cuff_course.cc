#include "lake/cuffs/cuff_course.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lake/core/error.h"

namespace lake::cuffs {
namespace {

using Eigen::Vector2d;

constexpr double kNormal95 = 1.959964;

// Of a hinge at `place` where the knee is bent by this angle; standing is the other.
LegLoad LoadAt(double flexion_deg, double standing_deg, const Vector2d& place_mm, const CuffOptions& options,
               double stiffness_n_mm) {
  const Vector2d on_thigh_mm = MisfitOf(Vector2d::Zero(), place_mm, standing_deg, 0);  // the same point, thigh's frame
  const LegState leg{-flexion_deg, 0, MisfitOf(place_mm, on_thigh_mm, -flexion_deg, 0), 0, 0};
  CuffOptions weightless = options;
  weightless.thigh_link_kg = weightless.shank_link_kg = 0;
  return LoadOnLeg(leg, weightless, {stiffness_n_mm, stiffness_n_mm});
}

}  // namespace

CuffForce Largest(const std::vector<CuffForce>& course) {
  return *std::ranges::max_element(course, {}, &CuffForce::force_n);
}

CuffCourse CourseOf(const std::vector<double>& flexion_deg, const HingePlace& place, const CuffOptions& options) {
  if (!(options.softest_n_mm <= options.stiffest_n_mm))
    throw UsageError(fmt::format("cuffs of {} N/mm at the softest and {} at the stiffest: give them in this order",
                                 options.softest_n_mm, options.stiffest_n_mm));
  // In proportion to the distance: of 1 mm along the way there, forward where there is none.
  const double distance_mm = place.mm.norm();
  const Vector2d along = distance_mm > 0 ? Vector2d(place.mm / distance_mm) : Vector2d::UnitX();
  const double soft = options.softest_n_mm, stiff = options.stiffest_n_mm, middle = std::sqrt(soft * stiff);
  const double least_mm = std::max(0.0, distance_mm - kNormal95 * place.sd_mm),
               most_mm = distance_mm + kNormal95 * place.sd_mm;
  CuffCourse course;
  for (const double flexion : flexion_deg) {
    const LegLoad load = LoadAt(flexion, flexion_deg.back(), along, options, middle);
    const auto force = [&](double n) {
      return CuffForce{n * distance_mm, n * soft / middle * least_mm, n * stiff / middle * most_mm};
    };
    course.thigh_n.push_back(force(load.largest_thigh_n));
    course.shank_n.push_back(force(load.largest_shank_n));
    course.knee_shear_n.push_back(force(load.knee_shear_n));
  }
  return course;
}

}  // namespace lake::cuffs
