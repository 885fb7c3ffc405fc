// The markers as the camera sees them.
#pragma once

#include "sprite.h"

namespace lake::synth {

class MarkerSprites {
 public:
  // Holds references to the options and the view, which must outlive it.
  MarkerSprites(const SceneOptions& options, const View& view, const MarkerMotion& motion);

  // Projected centres of all markers.
  std::vector<Eigen::Vector2d> Centres(const std::vector<Eigen::Vector3d>& mm) const;

  // Where a marker is seen in the plane, mm: moved by its distance from it, but for what marker_depth_mm says of it.
  Eigen::Vector2d PlaceShown(std::size_t marker, const Eigen::Vector3d& mm) const;

  // The sprite of one marker; positions[instant][marker] in mm.
  Sprite At(std::size_t marker, const std::vector<std::vector<Eigen::Vector3d>>& positions) const;

  // Of a disc in the picture's middle.
  double RadiusPx() const { return radius_px_; }

  // From an ArUco marker's centre to its corners; 0 for discs.
  double ArucoReachPx() const { return aruco_reach_px_; }

 private:
  Eigen::Vector2d PixelOf(std::size_t marker, const Eigen::Vector3d& mm) const;
  SpriteInstant DiscAt(std::size_t marker, const Eigen::Vector3d& mm) const;
  SpriteInstant ArucoAt(std::size_t marker, const std::vector<Eigen::Vector3d>& mm) const;

  const SceneOptions& options_;
  const View& view_;
  std::vector<double> depth_mm_;
  std::vector<cv::Vec3f> bgr_;
  std::vector<int> partner_;  // the marker that an ArUco marker's upper edge turns with, or −1
  std::vector<double> partner_sign_;
  std::vector<std::vector<Polygon>> dark_;  // black cells of the ArUco marker, in its own frame, mm
  double radius_px_ = 0, aruco_reach_px_ = 0;
};

}  // namespace lake::synth
