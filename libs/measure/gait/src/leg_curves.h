// The solved fit, evaluated at the frames. Not part of the interface.
#pragma once

#include <array>
#include <vector>

#include "lake/gait/sts_events.h"
#include "leg_problem.h"
#include "leg_signals.h"

namespace lake::gait {

// A marker's fitted position in every frame.
struct MarkerCurve {
  std::vector<Eigen::Vector2d> in_plane, recorded;
  std::vector<double> plane_sigma, recorded_sigma;  // per axis
  bool settled = true;                              // whether its smoothness was found
  std::vector<double> scatter;                      // deviation about the smooth path, over the detections' sigmas
  std::vector<double> lateral, lateral_rate, lateral_variance;  // of trials in three dimensions: mm, mm/s, mm²
};

struct LegCurves {
  int markers = kLegMarkers;
  std::array<MarkerCurve, kLegMarkers> marker;
  std::vector<StateVector> state, rate;  // rate: per s
  std::vector<StateMatrix> covariance;   // of the state, without slow noise; if asked for
  std::vector<double> knee_sigma_deg, knee_deg_s;
  std::vector<Eigen::Vector2d> hip_speed_in_leg;  // per s
  StsDeviations sd;                               // of what the events are read from
  std::vector<Eigen::Vector3d> flexion_axis;      // of trials in three dimensions: the leg's axes and across them
};

// Variance of θ_shank − θ_thigh, rad².
double KneeVariance(const StateMatrix& covariance);

// Smooth paths, and on them what the markers did beside them (NoiseShares).
LegCurves MakeLegCurves(const motion::MarkerRecording& recording, const LegModel& model,
                        const std::vector<double>& coefficients, double lasting_share, bool with_covariance);

// One coordinate by itself: its smooth curve, and what it did beside it.
struct SmoothCoordinate {
  std::vector<double> value, rate, variance, scatter;
  bool settled = true;
};

// Values that are NaN are gaps.
SmoothCoordinate SmoothByItself(const SplineGrid& grid, const std::vector<double>& time_s,
                                const std::vector<double>& values, const std::vector<double>& sigmas,
                                const LegFitOptions& options);

// A marker that is not the leg's, smoothed and bridged by itself.
MarkerCurve SmoothMarker(const motion::MarkerRecording& recording, const Detections& detections, const LegView& view,
                         const LegFitOptions& options);

// Tracks, trajectory, motion, events, reports. `skin` as for CollectDetections.
void FillResult(const motion::MarkerRecording& recording, const std::array<Detections, kLegMarkers>& leg,
                const LegCurves& curves, const LegModel& model, motion::Facing facing, double skin,
                const LegFitOptions& options, LegFitResult& result);

}  // namespace lake::gait
