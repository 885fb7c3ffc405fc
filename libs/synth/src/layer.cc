#include "layer.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "random.h"

namespace lake::synth {
namespace {

using Eigen::Vector2d;

constexpr int kTile = 512;

cv::Mat SmoothNoise(Random& random, double sigma) {
  cv::Mat white(kTile, kTile, CV_32FC1), tiled, smooth;
  for (int i = 0; i < kTile * kTile; ++i) white.ptr<float>()[i] = static_cast<float>(random.Normal());
  const int border = std::min(kTile - 1, static_cast<int>(std::ceil(4 * sigma)));
  cv::copyMakeBorder(white, tiled, border, border, border, border, cv::BORDER_WRAP);
  cv::GaussianBlur(tiled, smooth, cv::Size(), sigma, sigma, cv::BORDER_REFLECT);
  smooth = smooth(cv::Rect(border, border, kTile, kTile)).clone();
  cv::Scalar mean, sd;
  cv::meanStdDev(smooth, mean, sd);
  return (smooth - mean[0]) / sd[0];
}

// texture place (texels) = matrix × (px, py) + offset; also the place across the axis in half widths.
struct TextureFrame {
  Eigen::Matrix2f matrix;
  Eigen::Vector2f offset;
  float across_scale;
};

TextureFrame FrameOf(const View& view, const Shape& shape, float mm_per_texel) {
  const Vector2d axis = shape.axis.normalized();
  Eigen::Matrix2d shape_from_plane;
  shape_from_plane << axis.x(), axis.y(), axis.y(), -axis.x();
  Vector2d middle = Vector2d::Zero();
  for (const Vector2d& p : shape.outline) middle += p / double(shape.outline.size());
  const Eigen::Matrix2d shape_from_px = shape_from_plane * view.Jacobian(middle).inverse();
  const Vector2d offset = shape_from_plane * (middle - shape.origin) - shape_from_px * view.Pixel(middle);
  return {(shape_from_px / mm_per_texel).cast<float>(), (offset / mm_per_texel).cast<float>(),
          static_cast<float>(mm_per_texel / shape.half_width)};
}

// The factor on the surface's level at a pixel: texture averaged over the instants, rounding at the middle one.
class Shading {
 public:
  Shading(const View& view, const Layer& layer) : surface_(layer.surface) {
    if (!IsPlain())
      for (const Shape& shape : layer.instants) frames_.push_back(FrameOf(view, shape, surface_.mm_per_texel));
  }

  bool IsPlain() const { return surface_.texture == nullptr && surface_.rounding == 0; }

  float At(int x, int y) const {
    const Eigen::Vector2f px(static_cast<float>(x), static_cast<float>(y));
    float factor = 1;
    if (surface_.texture) {
      float sum = 0;
      for (const TextureFrame& frame : frames_) {
        const Eigen::Vector2f place = frame.matrix * px + frame.offset;
        sum += surface_.texture->At(place.x(), place.y());
      }
      factor += surface_.contrast * sum / static_cast<float>(frames_.size());
    }
    if (surface_.rounding > 0) {
      const TextureFrame& middle = frames_[frames_.size() / 2];
      const float across =
          std::min(1.0f, std::abs((middle.matrix.row(1).dot(px) + middle.offset.y()) * middle.across_scale));
      factor *= 1 - surface_.rounding * across * across;
    }
    return std::max(factor, 0.0f);
  }

 private:
  const Surface& surface_;
  std::vector<TextureFrame> frames_;
};

}  // namespace

Texture::Texture(std::uint64_t seed, std::string_view name, double grain, double folds, double share_of_folds) {
  Random random(seed, name);
  tile_ = std::sqrt(1 - share_of_folds) * SmoothNoise(random, grain) +
          std::sqrt(share_of_folds) * SmoothNoise(random, folds);
}

float Texture::At(float x, float y) const {
  const float left = std::floor(x), top = std::floor(y), fx = x - left, fy = y - top;
  const int x0 = static_cast<int>(left) & (kTile - 1), x1 = (x0 + 1) & (kTile - 1);
  const int y0 = static_cast<int>(top) & (kTile - 1), y1 = (y0 + 1) & (kTile - 1);
  const float *upper = tile_.ptr<float>(y0), *lower = tile_.ptr<float>(y1);
  return (1 - fy) * ((1 - fx) * upper[x0] + fx * upper[x1]) + fy * ((1 - fx) * lower[x0] + fx * lower[x1]);
}

SeenLayer::SeenLayer(const View& view, Layer layer) : view_(&view), layer_(std::move(layer)) {
  const int margin = 1 + static_cast<int>(std::ceil(4 * layer_.soft_px));
  outlines_px_.reserve(layer_.instants.size());
  for (const Shape& shape : layer_.instants) {
    outlines_px_.push_back(view.Outline(shape.outline));
    region_ |= PixelsOf(outlines_px_.back(), margin, view.Size());
  }
}

cv::Mat SeenLayer::Coverage(const cv::Rect& region, std::size_t first, std::size_t last) const {
  const int margin = static_cast<int>(std::ceil(4 * layer_.soft_px));
  const cv::Rect grown(region.x - margin, region.y - margin, region.width + 2 * margin, region.height + 2 * margin);
  PolygonRaster raster(grown.width, grown.height);
  for (std::size_t i = first; i <= last; ++i)
    raster.Add(ToCells(outlines_px_[i], grown, 1), 1.0 / static_cast<double>(last - first + 1));
  cv::Mat coverage = raster.Coverage();
  if (layer_.soft_px > 0) cv::GaussianBlur(coverage, coverage, cv::Size(), layer_.soft_px);
  return coverage(cv::Rect(margin, margin, region.width, region.height));
}

void SeenLayer::PaintOn(Canvas& canvas) const {
  const cv::Rect region = region_ & canvas.Region();
  if (region.empty()) return;
  const cv::Mat coverage = Coverage(region, 0, layer_.instants.size() - 1);
  const Shading shading(*view_, layer_);
  const int channels = canvas.image.channels();
  const cv::Vec3f colour = channels == 1 ? cv::Vec3f::all(Grey(layer_.surface.bgr)) : layer_.surface.bgr;
  for (int row = 0; row < region.height; ++row) {
    const float* const cover = coverage.ptr<float>(row);
    float* const out =
        canvas.image.ptr<float>(region.y + row - canvas.corner.y) + (region.x - canvas.corner.x) * channels;
    for (int column = 0; column < region.width; ++column) {
      if (cover[column] < 1e-6f) continue;
      const float factor = shading.IsPlain() ? 1 : shading.At(region.x + column, region.y + row);
      for (int c = 0; c < channels; ++c)
        out[column * channels + c] += cover[column] * (factor * colour[c] - out[column * channels + c]);
    }
  }
}

float Grey(const cv::Vec3f& bgr) {
  return 0.114f * bgr[0] + 0.587f * bgr[1] + 0.299f * bgr[2];
}

Polygon Capsule(const Vector2d& from, const Vector2d& to, double from_radius, double to_radius) {
  constexpr int kHalf = 12;
  const Vector2d axis = (to - from).normalized(), across(-axis.y(), axis.x());
  Polygon outline;
  const auto arc = [&](const Vector2d& centre, double radius, double start_rad) {
    for (int i = 0; i <= kHalf; ++i) {
      const double angle = start_rad + std::numbers::pi * i / kHalf;
      outline.push_back(centre + radius * (std::cos(angle) * axis + std::sin(angle) * across));
    }
  };
  arc(to, to_radius, -0.5 * std::numbers::pi);
  arc(from, from_radius, 0.5 * std::numbers::pi);
  return outline;
}

Polygon Box(double left, double bottom, double right, double top) {
  return {{left, bottom}, {right, bottom}, {right, top}, {left, top}};
}

Polygon EllipseOutline(const Vector2d& centre, double half_length, double half_width, double angle_rad, int corners) {
  const Vector2d along(std::cos(angle_rad), std::sin(angle_rad)), across(-along.y(), along.x());
  // A polygon through slightly larger radii has exactly the area of the ellipse.
  const double step = 2 * std::numbers::pi / corners, grow = std::sqrt(step / std::sin(step));
  Polygon outline;
  for (int i = 0; i < corners; ++i)
    outline.push_back(centre +
                      grow * (half_length * std::cos(i * step) * along + half_width * std::sin(i * step) * across));
  return outline;
}

}  // namespace lake::synth
