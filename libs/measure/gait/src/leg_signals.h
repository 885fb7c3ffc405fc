// What the fit starts from: the leg's components frame by frame, and how smooth each of them is. Not part of the
// interface.
#pragma once

#include <array>
#include <set>
#include <string>
#include <vector>

#include "lake/gait/leg_fit.h"
#include "leg_problem.h"

namespace lake::gait {

// A marker's detections: as recorded, and in the leg's axes.
struct Detections {
  std::string name;
  const motion::MarkerTrack* track = nullptr;  // nullptr: the recording has no such marker
  double depth_mm = 0;
  std::vector<char> seen;     // 0 or 1 per frame
  std::vector<char> trusted;  // seen, and neither on an excursion of a few frames nor alone within a gap
  std::vector<double> sigma;  // recorded unit; where it was given as 0, the estimate
  std::vector<double> jolt;   // recorded unit: how far off a smooth path a person's marker may be, noise apart
  std::vector<Eigen::Vector2d> in_plane;
  std::vector<double> plane_sigma;  // unit of the plane
  std::vector<double> lateral;      // mm, normal to the plane, NaN where missing; empty for a trial of two dimensions
};

// `skin` (recorded unit) is what a marker on skin may jump from frame to frame. Throws Error for a sample that is not
// finite or lies where the camera cannot see it, naming marker and frame.
Detections CollectDetections(const motion::MarkerRecording& recording, const motion::MarkerTrack& track,
                             const LegView& view, double skin);

// Mistrusts what is seen for too few frames for a curve, and for less time than the marker is hidden before and after
// it: nothing beside it tells what it is of. Where most of a marker's samples are such, nothing is known better.
void MistrustTheLone(Detections& detections, const std::vector<double>& time_s);

// The components' values and sigmas of every frame, NaN where a marker is not trusted; angles continuous, in rad.
struct LegSignals {
  std::array<std::vector<double>, kLegStates> value, sigma;
};
LegSignals MakeLegSignals(const std::array<Detections, kLegMarkers>& leg, const Eigen::Matrix2d& leg_from_plane,
                          int states);

// Where a knee or hip is hidden and the markers at the far ends of its segments are seen, the segments' usual lengths
// leave two places for it, mirror images in the line between the ends. Puts the angles there of the one on the side to
// which the joint bends; returns the angles of which there are such values.
std::set<int> BendHiddenJoints(const std::array<Detections, kLegMarkers>& leg, const Eigen::Matrix2d& leg_from_plane,
                               int states, LegSignals& signals);

// Throws Error if ankle, knee and hip are not seen together often enough.
void CheckIsSeen(const LegSignals& signals, const std::array<Detections, kLegMarkers>& leg);

// The grid, the priors and the first coefficients, from each component smoothed by itself.
struct LegStart {
  SplineGrid grid;
  std::array<LegPrior, kLegStates> priors;
  std::vector<double> coefficients;  // grid.count × states
  double knee_cutoff_hz = 0;         // the geometric mean of shank and thigh
  double sigma_scale = 1;  // ≥ 1: of the detections' sigmas, where a given cutoff leaves motion to the noise
  std::vector<std::string> unsettled;  // the components whose smoothness was still changing when the search ended
};
// Says that what a smoothing found is not final, and what to do.
std::string UnsettledWarning(const std::string& what);

LegStart SmoothSignals(const LegSignals& signals, const std::vector<double>& time_s, int states,
                       const LegFitOptions& options);

// Makes the first coefficients of some components those of other signals; the priors stay.
void StartFrom(const LegSignals& signals, const std::set<int>& components, const std::vector<double>& time_s,
               int states, LegStart& start);

}  // namespace lake::gait
