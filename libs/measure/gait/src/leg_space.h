// The leg's third dimension, for trials of three: lengths and the knee angle in space. Not part of the interface.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "leg_curves.h"

namespace lake::gait {

// Gives the leg's detections their lateral places. Throws Error for a marker that `lateral` does not know.
void SetLateral(const LateralPlaces& lateral, std::array<Detections, kLegMarkers>& leg);

// Smooths the leg's lateral places, finds the knee's flexion axis, and makes the knee angle's sigma and speed
// those of the angle in space.
void AddAcross(const motion::MarkerRecording& recording, const std::array<Detections, kLegMarkers>& leg,
               const LegModel& model, const LegFitOptions& options, LegCurves& curves);

// Between two vectors in space, positive in flexion about the axis (a unit vector).
double KneeInSpaceDeg(const Eigen::Vector3d& ak, const Eigen::Vector3d& kh, const Eigen::Vector3d& flexion_axis);

LateralReport ReportLateral(const std::array<Detections, kLegMarkers>& leg);

}  // namespace lake::gait
