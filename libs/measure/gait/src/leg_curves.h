// The leg's angles from the markers' curves, with their standard deviations. Not part of the interface.
#pragma once

#include <array>
#include <vector>

#include "lake/gait/sts_events.h"
#include "marker_curves.h"

namespace lake::gait {

struct LegCurves {
  int markers = kLegMarkers;
  std::array<MarkerCurve, kLegMarkers> marker;
  Eigen::Matrix3d leg_from_plane = Eigen::Matrix3d::Identity();  // x anterior, y up, z across, to make it right-handed
  std::vector<Eigen::Vector3d> flexion_axis;                     // per frame, in the leg's axes
  std::vector<double> knee_sigma_deg, knee_deg_s;
  StsDeviations sd;  // of what the events are read from

  bool HasTrunk() const { return markers == kLegMarkers; }
  // From a segment's lower to its upper marker, in the leg's axes.
  Eigen::Vector3d Vector(LegSegmentIndex segment, std::size_t frame) const;
  double AngleRad(LegSegmentIndex segment, std::size_t frame) const;  // from the vertical, in the plane
  double Length(LegSegmentIndex segment, std::size_t frame) const;
};

// How a quantity changes with the markers' places, in the plane's axes. Markers err independently of each other.
struct MarkerGradient {
  std::array<Eigen::Vector3d, kLegMarkers> by_marker;

  MarkerGradient() { by_marker.fill(Eigen::Vector3d::Zero()); }
  double Rate(const LegCurves& curves, std::size_t frame) const;
  double Variance(const LegCurves& curves, std::size_t frame) const;
  double RateVariance(const LegCurves& curves, std::size_t frame) const;  // the gradient's own change left out
  MarkerGradient operator-(const MarkerGradient& other) const;
};

MarkerGradient AngleGradient(const LegCurves& curves, LegSegmentIndex segment, std::size_t frame);  // rad
MarkerGradient LengthGradient(const LegCurves& curves, LegSegmentIndex segment, std::size_t frame);
MarkerGradient KneeGradient(const LegCurves& curves, std::size_t frame);  // rad
MarkerGradient HipHeightGradient(const LegCurves& curves);

// `leg_from_plane` takes the plane's axes to the leg's.
LegCurves MakeLegCurves(const std::vector<double>& time_s, LegMarkerCurves markers, int count,
                        const Eigen::Matrix2d& leg_from_plane, const std::array<Detections, kLegMarkers>& leg,
                        bool is_facing_given);

// Tracks, trajectory, motion, events, reports. `skin` as for CollectDetections.
void FillResult(const motion::MarkerRecording& recording, const std::array<Detections, kLegMarkers>& leg,
                const LegCurves& curves, const LegView& view, motion::Facing facing, double skin,
                const LegFitOptions& options, LegFitResult& result);

}  // namespace lake::gait
