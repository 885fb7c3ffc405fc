// The leg's third dimension, for trials of three: lengths and the knee angle in space. Not part of the interface.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "leg_curves.h"

namespace lake::gait {

// Gives the leg's detections their lateral places. Throws Error for a marker that `lateral` does not know.
void SetLateral(const LateralPlaces& lateral, std::array<Detections, kLegMarkers>& leg);

struct KneeAngle {
  double rad;
  Eigen::Vector3d by_ak, by_kh;  // its derivatives
};
// Between the vectors AK and KH, positive in flexion about the axis (a unit vector).
KneeAngle KneeAngleOf(const Eigen::Vector3d& ak, const Eigen::Vector3d& kh, const Eigen::Vector3d& axis);

// The knee's flexion axis of every frame, in the leg's axes: the normal of the segments' own plane where the knee bends
// so far that it can be no hyperextension, and in between what leads from one such normal to the next. Without a bend,
// and in trials of two dimensions, it is the normal of the sagittal plane. A facing that was given decides the sign.
std::vector<Eigen::Vector3d> FlexionAxes(const LegCurves& curves, const std::array<Detections, kLegMarkers>& leg,
                                         const std::vector<double>& time_s, bool is_facing_given);

// Between two vectors in space, positive in flexion about the axis (a unit vector).
double KneeInSpaceDeg(const Eigen::Vector3d& ak, const Eigen::Vector3d& kh, const Eigen::Vector3d& flexion_axis);

LateralReport ReportLateral(const std::array<Detections, kLegMarkers>& leg);

}  // namespace lake::gait
