// Renders a scene frame by frame, in any order, with exact truth.
//
// Image formation, in this order: everything is drawn with exact area coverage (PolygonRaster) and averaged over
// sub-exposures of the shutter; the Gaussian point-spread; flicker; noise; 8 bits. Markers are drawn on a grid of 4 × 4
// cells per pixel from their outline projected through the full camera.
#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "lake/synth/marker_motion.h"
#include "lake/synth/scene_options.h"

namespace lake::synth {

struct MarkerTruth {
  Eigen::Vector2d px;   // the projected centre at mid-exposure, image frame
  Eigen::Vector2d mm;   // plane frame: where the plane shows it
  double covered = 0;   // the part of the marker's light that a hand or the picture's border takes away, 0..1
  bool visible = true;  // covered < kVisibleLimit
};

// A marker counts as hidden from here on.
inline constexpr double kVisibleLimit = 0.1;

struct FrameTruth {
  double time_s = 0;
  std::vector<MarkerTruth> markers;  // in the order of Scene::Motion().Names()
  double knee_deg = 0;               // of the marker vectors; NaN without ankle, knee and hip
};

// A piece of an image: `image` (CV_32F) with its top-left pixel at `corner`.
struct ImagePatch {
  cv::Point corner;
  cv::Mat image;
};

class Scene {
 public:
  // Throws UsageError for bad options, Error for an unreadable motion table.
  explicit Scene(const SceneOptions& options);
  // With a motion made elsewhere.
  Scene(const SceneOptions& options, std::shared_ptr<const MarkerMotion> motion);
  Scene(Scene&&) noexcept;
  ~Scene();

  const SceneOptions& Options() const;
  const MarkerMotion& Motion() const;
  const camera::CameraProfile& Profile() const;
  int Frames() const;
  double TimeS(int frame) const;  // of the frame's time stamp

  FrameTruth Truth(int frame) const;

  // The noise-free picture in grey values, not clipped: CV_32FC1, or CV_32FC3 (BGR) for a colour scene.
  cv::Mat RenderIdeal(int frame) const;

  // As recorded: CV_8UC1 or CV_8UC3.
  cv::Mat Render(int frame) const;

  // What the marker adds to the noise-free picture (flicker included), with the marker shifted in the picture.
  ImagePatch RenderMarker(int frame, const std::string& marker, const Eigen::Vector2d& shift_px) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lake::synth
