// The markers' smoothed paths: each by the path model of lake::dynamics, a hidden marker of the leg also by the lengths
// of the segments that end in it. Not part of the interface.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "detections.h"
#include "lake/dynamics/path_smoother.h"
#include "lake/gait/leg_fit.h"

namespace lake::gait {

// A marker's path in every frame. Lengths in the plane's unit, z normal to the plane (0 in trials of two dimensions).
struct MarkerCurve {
  std::vector<dynamics::PathPoint> point;
  std::vector<Eigen::Vector2d> recorded;
  std::vector<double> plane_sigma, recorded_sigma;  // per axis
  std::vector<double> scatter;  // standard deviation of a detection's error, over the detection's sigma

  Eigen::Vector2d InPlane(std::size_t frame) const { return point[frame].position.head<2>(); }
};

double PlaneSigma(const dynamics::PathPoint& point);  // per axis

struct LegMarkerCurves {
  std::array<MarkerCurve, kLegMarkers> marker;
  // Of the knee, as LegFitSummary has them.
  double lasting_share = 0, noise_memory_s = 0, cutoff_hz = 0;
};

// mm to a unit of the plane; without a scale, by the size of a usual shank.
double UnitMm(const LegView& view, double shank);

// The first `markers` of the leg. Detections that contradict all others are no longer trusted, unless the curves
// without them make them likely.
LegMarkerCurves SmoothLeg(const std::vector<double>& time_s, int markers, const LegView& view,
                          const LegFitOptions& options, std::array<Detections, kLegMarkers>& leg);

// A marker that is not the leg's; `unit_mm`: mm to a unit of the plane.
MarkerCurve SmoothMarker(const std::vector<double>& time_s, const LegView& view, const LegFitOptions& options,
                         double unit_mm, Detections& detections);

}  // namespace lake::gait
