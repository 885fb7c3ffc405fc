// Flat, textured shapes that are painted one over the other, each averaged over the shutter.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "view.h"

namespace lake::synth {

// A seeded, tileable pattern of mean 0 and standard deviation 1.
class Texture {
 public:
  // Mixes a fine grain and soft folds; sizes in texels (standard deviations of the smoothing), share of the folds 0..1.
  Texture(std::uint64_t seed, std::string_view name, double grain, double folds, double share_of_folds);

  float At(float x, float y) const;  // in texels, bilinear, repeats

 private:
  cv::Mat tile_;
};

struct Surface {
  cv::Vec3f bgr;                     // levels
  const Texture* texture = nullptr;  // not owned
  float contrast = 0;                // standard deviation of the texture as a part of the level
  float mm_per_texel = 1.5f;
  float rounding = 0;  // how much darker the sides of a limb are, 0..1
};

// A shape at one instant, in mm in the plane frame. The axis carries texture and rounding along.
struct Shape {
  Polygon outline;
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  Eigen::Vector2d axis = Eigen::Vector2d::UnitX();
  double half_width = 1e9;  // across the axis
};

struct Layer {
  Surface surface;
  std::vector<Shape> instants;  // at the middles of equal parts of the shutter
  double soft_px = 0;           // standard deviation of the blur of its edge (out of focus)
};

// A picture in work: CV_32FC1 or CV_32FC3, the part of the whole picture that starts at `corner`.
struct Canvas {
  cv::Mat image;
  cv::Point corner;
  cv::Rect Region() const { return {corner, image.size()}; }
};

// A layer as the camera sees it; its outlines are projected once.
class SeenLayer {
 public:
  SeenLayer(const View& view, Layer layer);

  // The pixels it touches.
  const cv::Rect& Region() const { return region_; }

  // Exact coverage of the pixels of `region`, averaged over its instants; with first = last one instant only.
  cv::Mat Coverage(const cv::Rect& region, std::size_t first, std::size_t last) const;

  // Paints it over the canvas, which may hold only a part of it.
  void PaintOn(Canvas& canvas) const;

 private:
  const View* view_;  // not owned
  Layer layer_;
  std::vector<Polygon> outlines_px_;  // per instant
  cv::Rect region_;
};

// Levels of a surface for a canvas of 1 or 3 channels (grey: ITU-R BT.601 luma).
float Grey(const cv::Vec3f& bgr);

// Outlines, in mm.
Polygon Capsule(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double from_radius, double to_radius);
Polygon Box(double left, double bottom, double right, double top);
Polygon EllipseOutline(const Eigen::Vector2d& centre, double half_length, double half_width, double angle_rad,
                       int corners = 48);

}  // namespace lake::synth
