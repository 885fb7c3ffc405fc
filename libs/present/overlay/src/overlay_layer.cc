#include "overlay_layer.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <new>

#include "lake/core/wide_vectors.h"

namespace lake::overlay {
namespace {

constexpr int kOne = 1 << 16;

// Limited range; kr, kb as in BT.601 or BT.709.
std::array<int, 3> Weights(double b, double g, double r, double range) {
  const double scale = kOne * range / 255;
  return {static_cast<int>(std::lround(b * scale)), static_cast<int>(std::lround(g * scale)),
          static_cast<int>(std::lround(r * scale))};
}

// A plane's own and what is laid over it: (under (full − alpha) + offset alpha) / full + colour, rounded; colour is
// 16.16. `full` is 255 or its fourfold, 2^shift of it. 65536 / 255 is 257 + 1/255, to which 1/256 is near enough.
inline std::uint8_t Mix(int under, int offset, int alpha, int shift, int colour) {
  const int sum = under * ((255 << shift) - alpha) + offset * alpha;
  const int mixed = ((sum * 257 + (sum >> 8)) >> shift) + colour + kOne / 2;
  return static_cast<std::uint8_t>(std::clamp(mixed >> 16, 0, 255));
}

// Pixels as cairo has them: alpha in the upper eight bits, then red, green, blue.
LAKE_WIDE_VECTORS void BlendLuma(const std::uint32_t* over, int width, int b, int g, int r, std::uint8_t* luma) {
  for (int x = 0; x < width; ++x) {
    const auto p = static_cast<int>(over[x] & 0xFFFFFF);
    const int colour = b * (p & 0xFF) + g * (p >> 8 & 0xFF) + r * (p >> 16);
    luma[x] = Mix(luma[x], 16, static_cast<int>(over[x] >> 24), 0, colour);
  }
}

// Of the same pixels, two rows of them, for one row of Cb or Cr.
LAKE_WIDE_VECTORS void BlendChroma(const std::uint32_t* above, const std::uint32_t* below, int width, int b, int g,
                                   int r, std::uint8_t* chroma) {
  constexpr std::uint32_t kEveryOther = 0x00FF00FF;  // two channels' sums in one number
  for (int x = 0; x < width; ++x) {
    const std::uint32_t p = above[2 * x], q = above[2 * x + 1], s = below[2 * x], t = below[2 * x + 1];
    const std::uint32_t red_blue = (p & kEveryOther) + (q & kEveryOther) + (s & kEveryOther) + (t & kEveryOther);
    const std::uint32_t alpha_green =
        (p >> 8 & kEveryOther) + (q >> 8 & kEveryOther) + (s >> 8 & kEveryOther) + (t >> 8 & kEveryOther);
    const int colour = b * static_cast<int>(red_blue & 0xFFFF) + g * static_cast<int>(alpha_green & 0xFFFF) +
                       r * static_cast<int>(red_blue >> 16);
    chroma[x] = Mix(chroma[x], 128, static_cast<int>(alpha_green >> 16), 2, colour >> 2);
  }
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
  for (int y = 0; y < tiles_.height; ++y) {
    const auto row = touched_.begin() + std::ptrdiff_t{y} * tiles_.width, end = row + tiles_.width;
    for (auto first = std::find(row, end, true); first != end; first = std::find(first, end, true)) {
      const auto last = std::find(first, end, false);
      const cv::Rect run(static_cast<int>(first - row) * kTile_px, y * kTile_px,
                         static_cast<int>(last - first) * kTile_px, kTile_px);
      Blend(run & cv::Rect({}, size_), i420);
      first = last;
    }
    std::fill(row, end, false);
  }
  cairo_surface_mark_dirty(surface_.get());
}

void OverlayLayer::Blend(const cv::Rect& area, cv::Mat& i420) {
  const std::ptrdiff_t chroma_width = size_.width / 2;
  std::uint8_t* const cb = i420.data + size_.area();
  std::uint8_t* const cr = cb + size_.area() / 4;
  for (int y = area.y; y < area.y + area.height; y += 2) {
    auto *above = argb_.ptr<std::uint32_t>(y) + area.x, *below = argb_.ptr<std::uint32_t>(y + 1) + area.x;
    const auto& [yb, yg, yr] = matrix_.y;
    BlendLuma(above, area.width, yb, yg, yr, i420.ptr(y) + area.x);
    BlendLuma(below, area.width, yb, yg, yr, i420.ptr(y + 1) + area.x);
    const std::ptrdiff_t at = y / 2 * chroma_width + area.x / 2;
    const auto& [ub, ug, ur] = matrix_.u;
    BlendChroma(above, below, area.width / 2, ub, ug, ur, cb + at);
    const auto& [vb, vg, vr] = matrix_.v;
    BlendChroma(above, below, area.width / 2, vb, vg, vr, cr + at);
    std::fill_n(above, area.width, 0);
    std::fill_n(below, area.width, 0);
  }
}

}  // namespace lake::overlay
