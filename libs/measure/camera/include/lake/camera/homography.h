// From pixels to a plane without a calibrated camera, by four or more known points in the plane.
#pragma once

#include <Eigen/Core>
#include <span>

namespace lake::camera {

// A pixel and the known point of the plane that it shows.
struct PlaneCorrespondence {
  Eigen::Vector2d pixel;           // image frame
  Eigen::Vector2d point_in_plane;  // mm
};

struct HomographyFit {
  Eigen::Matrix3d plane_from_image =
      Eigen::Matrix3d::Identity();  // homogeneous; the third row is positive at the points
  double rms_px = 0;                // of the points projected back into the picture, 2-D; 0 for four points
};

// The homography that takes pixels to mm: direct linear transform on normalised points (Hartley & Zisserman 2004,
// algorithm 4.2), then least squares of the distances in the picture, where the noise is. It knows no lens distortion:
// with a calibrated camera use PlaneFromPixel. A mirrored mapping (pixel y down, plane y up) is normal. Throws Error:
// fewer than four points, values that are not finite, points of which too many lie in one line, points that no view of
// a plane can give (wrong order).
HomographyFit PlaneHomography(std::span<const PlaneCorrespondence> points);

// The point of the plane (mm) seen at a pixel. Throws Error if the pixel lies on or beyond the plane's horizon, seen
// from the points the homography was made from.
Eigen::Vector2d ApplyHomography(const HomographyFit& fit, const Eigen::Vector2d& pixel);

}  // namespace lake::camera
