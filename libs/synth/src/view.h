// The camera as the renderer uses it.
#pragma once

#include <Eigen/Core>
#include <opencv2/core/types.hpp>

#include "lake/camera/camera.h"
#include "lake/synth/polygon_raster.h"
#include "lake/synth/scene_options.h"

namespace lake::synth {

// A picture whose plane frame has marker_radius_px for marker_radius_mm at `centre_mm`, which is seen in the middle of
// the picture.
camera::CameraProfile MakeCameraProfile(const SceneOptions& options, const Eigen::Vector2d& centre_mm);

class View {
 public:
  explicit View(const camera::CameraProfile& profile) : camera_(profile.camera), pose_(*profile.camera_from_plane) {}

  cv::Size Size() const { return {camera_.image_width, camera_.image_height}; }
  Eigen::Vector2d Pixel(const Eigen::Vector2d& mm, double depth_mm = 0) const {
    return camera::PixelFromPlane(camera_, pose_, mm, depth_mm);
  }
  Eigen::Vector2d Plane(const Eigen::Vector2d& px, double depth_mm = 0) const {
    return camera::PlaneFromPixel(camera_, pose_, px, depth_mm);
  }

  // d pixel / d plane, px per mm.
  Eigen::Matrix2d Jacobian(const Eigen::Vector2d& mm, double depth_mm = 0) const;

  // Outline in pixels; long edges are divided, so that distortion bends them.
  Polygon Outline(const Polygon& mm, double depth_mm = 0) const;

 private:
  camera::Camera camera_;
  camera::PlanePose pose_;
};

// The pixels that hold the polygon, grown by `margin` and cut to the picture; empty if it lies outside.
cv::Rect PixelsOf(const Polygon& px, int margin, const cv::Size& picture);

// Polygon coordinates for a raster whose cell (0, 0) is the corner of `region`, `cells` per pixel.
Polygon ToCells(const Polygon& px, const cv::Rect& region, int cells);

}  // namespace lake::synth
