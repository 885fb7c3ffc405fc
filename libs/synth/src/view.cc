#include "view.h"

#include <algorithm>
#include <cmath>

#include "lake/core/angles.h"

namespace lake::synth {

using Eigen::Vector2d;

camera::CameraProfile MakeCameraProfile(const SceneOptions& options, const Vector2d& centre_mm) {
  camera::CameraProfile profile;
  camera::Camera& camera = profile.camera;
  camera.image_width = options.width_px;
  camera.image_height = options.height_px;
  camera.fx = camera.fy = options.marker_radius_px / options.marker_radius_mm * options.distance_mm;
  camera.cx = 0.5 * (options.width_px - 1);
  camera.cy = 0.5 * (options.height_px - 1);
  camera.distortion = options.distortion;
  using Eigen::AngleAxisd, Eigen::Vector3d;
  const Eigen::Matrix3d flip = Vector3d(1, -1, -1).asDiagonal();  // the plane's y is up and its z towards the camera
  camera::PlanePose pose = camera::PlanePose::Identity();
  pose.linear() = AngleAxisd(RadiansFromDegrees(options.roll_deg), Vector3d::UnitZ()).toRotationMatrix() *
                  AngleAxisd(RadiansFromDegrees(options.pitch_deg), Vector3d::UnitX()).toRotationMatrix() *
                  AngleAxisd(RadiansFromDegrees(options.yaw_deg), Vector3d::UnitY()).toRotationMatrix() * flip;
  pose.translation() = Vector3d(0, 0, options.distance_mm) - pose.linear() * Vector3d(centre_mm.x(), centre_mm.y(), 0);
  profile.camera_from_plane = pose;
  return profile;
}

Eigen::Matrix2d View::Jacobian(const Vector2d& mm, double depth_mm) const {
  constexpr double kStep = 0.5;  // mm; the projection is as good as straight over it
  Eigen::Matrix2d jacobian;
  for (int axis = 0; axis < 2; ++axis) {
    const Vector2d step = kStep * Vector2d::Unit(axis);
    jacobian.col(axis) = (Pixel(mm + step, depth_mm) - Pixel(mm - step, depth_mm)) / (2 * kStep);
  }
  return jacobian;
}

Polygon View::Outline(const Polygon& mm, double depth_mm) const {
  constexpr double kLongestEdge = 60;  // mm; distortion bends this much by less than 0.1 px
  Polygon px;
  for (std::size_t i = 0; i < mm.size(); ++i) {
    const Vector2d &from = mm[i], &to = mm[(i + 1) % mm.size()];
    const int parts = std::max(1, static_cast<int>(std::ceil((to - from).norm() / kLongestEdge)));
    for (int k = 0; k < parts; ++k) px.push_back(Pixel(from + (to - from) * (double(k) / parts), depth_mm));
  }
  return px;
}

cv::Rect PixelsOf(const Polygon& px, int margin, const cv::Size& picture) {
  const cv::Rect all({}, picture);
  if (px.empty()) return {};
  Vector2d low = px.front(), high = px.front();
  for (const Vector2d& p : px) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  constexpr double kFar = 1e6;
  low = low.cwiseMax(-kFar);
  high = high.cwiseMin(kFar);
  const int left = static_cast<int>(std::floor(low.x() + 0.5)) - margin,
            top = static_cast<int>(std::floor(low.y() + 0.5)) - margin;
  const int right = static_cast<int>(std::floor(high.x() + 0.5)) + margin;
  const int bottom = static_cast<int>(std::floor(high.y() + 0.5)) + margin;
  if (right < left || bottom < top) return {};
  return cv::Rect(left, top, right - left + 1, bottom - top + 1) & all;
}

Polygon ToCells(const Polygon& px, const cv::Rect& region, int cells) {
  Polygon out;
  out.reserve(px.size());
  for (const Vector2d& p : px) out.push_back(cells * (p + Vector2d(0.5 - region.x, 0.5 - region.y)));
  return out;
}

}  // namespace lake::synth
