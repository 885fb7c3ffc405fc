#include "overlay_layer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>

namespace lake::overlay {
namespace {

constexpr int kOne = 1 << 16;

// Limited range; kr, kb as in BT.601 or BT.709.
std::array<int, 3> Weights(double b, double g, double r, double range) {
  const double scale = kOne * range / 255;
  return {static_cast<int>(std::lround(b * scale)), static_cast<int>(std::lround(g * scale)),
          static_cast<int>(std::lround(r * scale))};
}

int Dot(const std::array<int, 3>& weights, int b, int g, int r) {
  return weights[0] * b + weights[1] * g + weights[2] * r;
}

// under (1 − alpha) + offset alpha + colour, rounded; alpha counts to `full`, colour is 16.16.
std::uint8_t Mix(int under, int offset, int alpha, int full, int colour) {
  const std::int64_t sum = std::int64_t{under * (full - alpha) + offset * alpha} * kOne / full + colour + kOne / 2;
  return cv::saturate_cast<std::uint8_t>(static_cast<int>(sum >> 16));
}

// Two neighbours at once: most of a tile is empty.
bool IsClear(const cv::Mat& argb, int x, int y) {
  std::uint64_t pair;
  std::memcpy(&pair, argb.ptr(y, x), sizeof pair);
  return pair == 0;
}

}  // namespace

OverlayLayer::OverlayLayer(cv::Size size, bool bt709)
    : size_(size),
      tiles_((size.width + kTile_px - 1) / kTile_px, (size.height + kTile_px - 1) / kTile_px),
      argb_(size, CV_8UC4, cv::Scalar::all(0)),
      surface_(cairo_image_surface_create_for_data(argb_.data, CAIRO_FORMAT_ARGB32, size.width, size.height,
                                                   static_cast<int>(argb_.step))),
      context_(cairo_create(surface_.get())),
      touched_(static_cast<std::size_t>(tiles_.area())) {
  if (cairo_status(context_.get()) != CAIRO_STATUS_SUCCESS) throw std::bad_alloc();
  const double kr = bt709 ? 0.2126 : 0.299, kb = bt709 ? 0.0722 : 0.114, kg = 1 - kr - kb;
  matrix_.y = Weights(kb, kg, kr, 219);
  matrix_.u = Weights(0.5, -kg / (2 * (1 - kb)), -kr / (2 * (1 - kb)), 224);
  matrix_.v = Weights(-kb / (2 * (1 - kr)), -kg / (2 * (1 - kr)), 0.5, 224);
}

void OverlayLayer::Touch(const cv::Rect2d& area) {
  const auto tile = [](double px, int tiles) {
    return static_cast<int>(std::clamp(std::floor(px / kTile_px), 0.0, static_cast<double>(tiles)));
  };
  if (!(area.width > 0 && area.height > 0)) return;
  const int right = std::min(tile(area.x + area.width, tiles_.width), tiles_.width - 1);
  const int bottom = std::min(tile(area.y + area.height, tiles_.height), tiles_.height - 1);
  for (int y = tile(area.y, tiles_.height); y <= bottom; ++y)
    for (int x = tile(area.x, tiles_.width); x <= right; ++x)
      touched_[static_cast<std::size_t>(y * tiles_.width + x)] = true;
}

void OverlayLayer::BlendOnto(cv::Mat& i420) {
  cairo_surface_flush(surface_.get());
  for (int y = 0; y < tiles_.height; ++y)
    for (int x = 0; x < tiles_.width; ++x) {
      const auto index = static_cast<std::size_t>(y * tiles_.width + x);
      if (!touched_[index]) continue;
      const cv::Rect tile = cv::Rect(x * kTile_px, y * kTile_px, kTile_px, kTile_px) & cv::Rect({}, size_);
      BlendTile(tile, i420);
      argb_(tile).setTo(cv::Scalar::all(0));
      touched_[index] = false;
    }
  cairo_surface_mark_dirty(surface_.get());
}

void OverlayLayer::BlendTile(const cv::Rect& tile, cv::Mat& i420) const {
  const std::size_t chroma_width = static_cast<std::size_t>(size_.width) / 2;
  std::uint8_t* const u_plane = i420.data + static_cast<std::size_t>(size_.area());
  std::uint8_t* const v_plane = u_plane + static_cast<std::size_t>(size_.area()) / 4;
  for (int y = tile.y; y < tile.y + tile.height; y += 2)
    for (int x = tile.x; x < tile.x + tile.width; x += 2) {
      if (IsClear(argb_, x, y) && IsClear(argb_, x, y + 1)) continue;
      int sum[4] = {};
      for (const int dy : {0, 1})
        for (const int dx : {0, 1}) {
          const cv::Vec4b& p = argb_.at<cv::Vec4b>(y + dy, x + dx);
          std::uint8_t& luma = i420.at<std::uint8_t>(y + dy, x + dx);
          luma = Mix(luma, 16, p[3], 255, Dot(matrix_.y, p[0], p[1], p[2]));
          for (int c = 0; c < 4; ++c) sum[c] += p[c];
        }
      const std::size_t at = static_cast<std::size_t>(y / 2) * chroma_width + static_cast<std::size_t>(x / 2);
      u_plane[at] = Mix(u_plane[at], 128, sum[3], 4 * 255, Dot(matrix_.u, sum[0], sum[1], sum[2]) / 4);
      v_plane[at] = Mix(v_plane[at], 128, sum[3], 4 * 255, Dot(matrix_.v, sum[0], sum[1], sum[2]) / 4);
    }
}

}  // namespace lake::overlay
