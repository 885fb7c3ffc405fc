// A rigid segment that carries markers, posed on them in each frame (Procrustes; Kabsch 1976).
//
// Lengths in the caller's unit (mm). Points in a plane have z = 0, or any z that does not matter, and its normal is
// given.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <vector>

namespace lake::dynamics {

// The pose of a segment in the outer axes: x_outer = turn · x_segment + origin.
struct Pose {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());  // NaN: not seen

  bool IsSeen() const { return origin.allFinite(); }
};

// Of the plane in which all markers turn; nullopt: in space.
using TurnNormal = std::optional<Eigen::Vector3d>;

// A rigid segment and how its markers move against it. The segment's frame has its origin at the mean of the markers'
// mean shape, and the outer axes of the first frame that shows all markers.
struct RigidSegment {
  std::vector<Pose> poses;                    // one per frame; not seen with fewer than two markers, in space three
  Eigen::Matrix3Xd shape;                     // a column per marker: mean place in the segment's frame
  std::vector<Eigen::Matrix3Xd> deformation;  // per frame: places minus `shape`, segment's frame; 0 where not seen
  double freedom = 0;       // coordinates of the deformation: 3 markers - 6, of planar markers 2 markers - 3
  double marker_sd_mm = 0;  // of each marker along each axis, if the markers' errors are independent

  // What such errors leave in a point of the segment at this distance from its origin, along each axis, mm.
  double PointSdMm(double distance_mm) const;
};

// The pose of a shape (a column per marker) on the markers' places in one frame, NaN where not seen; not seen itself
// with fewer than two of them, in space three.
Pose PoseOf(const Eigen::Matrix3Xd& shape, const Eigen::Matrix3Xd& places, const TurnNormal& normal);

// From the places of its markers in each frame, a column per marker, NaN where not seen. The mean shape is that of the
// frames that show all; nullopt where none does.
std::optional<RigidSegment> FitRigidSegment(const std::vector<Eigen::Matrix3Xd>& places, const TurnNormal& normal);

}  // namespace lake::dynamics
