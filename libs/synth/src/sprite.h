// Small bright objects (markers, reflections, a glint), drawn finely: 4 × 4 cells per pixel, point-spread in the cells.
#pragma once

#include <functional>
#include <opencv2/core.hpp>
#include <vector>

#include "lake/synth/scene.h"
#include "layer.h"

namespace lake::synth {

inline constexpr int kCells = 4;  // per pixel and axis

// Outlines in pixels at one instant; the dark parts lie inside the outline.
struct SpriteInstant {
  Polygon outline;
  std::vector<Polygon> dark;
};

struct Sprite {
  cv::Vec3f light_bgr, dark_bgr;
  std::vector<SpriteInstant> instants;
};

// What stands in front of a sprite at one instant: coverage of the pixels of a region, empty if nothing.
using Cover = std::function<cv::Mat(const cv::Rect& region, std::size_t instant)>;

// The light of a sprite on the fine grid of `region`'s pixels.
struct SpriteCoverage {
  cv::Rect region;     // pixels
  cv::Mat area, dark;  // CV_32FC1, kCells times as large
  double covered = 0;  // the part that `cover` or the picture's border takes away
};

// The pixels that a sprite's light reaches; empty outside the picture.
cv::Rect SpriteRegion(const Sprite& sprite, const cv::Size& picture, double psf_sigma_px);

SpriteCoverage CoverageOf(const Sprite& sprite, const cv::Size& picture, double psf_sigma_px, const Cover& cover);

// What the sprite adds to a picture: point-spread of coverage × (its level − what lies under it).
cv::Mat LightOf(const Sprite& sprite, const SpriteCoverage& coverage, const Canvas& under, double psf_sigma_px);

// Puts the sprite into the picture before the point-spread, so that the next one lies over it.
void PaintUnder(const Sprite& sprite, const SpriteCoverage& coverage, Canvas& under);

// The point-spread for whole pixels: what the fine one does to a picture of even pixels. One row of a separable kernel.
cv::Mat PixelKernel(double psf_sigma_px);

}  // namespace lake::synth
