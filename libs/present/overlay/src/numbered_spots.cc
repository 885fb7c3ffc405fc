#include "lake/overlay/numbered_spots.h"

#include <cairo.h>

#include <algorithm>
#include <array>
#include <memory>
#include <numbers>
#include <string>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "overlay_labels.h"

namespace lake::overlay {
namespace {

struct DeleteCairo {
  void operator()(cairo_t* context) const { cairo_destroy(context); }
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
};
using Surface = std::unique_ptr<cairo_surface_t, DeleteCairo>;
using Context = std::unique_ptr<cairo_t, DeleteCairo>;

constexpr std::array<std::array<double, 3>, 8> kColours = {{{1, 0.85, 0.2},
                                                            {0.3, 0.9, 1},
                                                            {1, 0.5, 0.75},
                                                            {0.5, 1, 0.45},
                                                            {1, 0.6, 0.25},
                                                            {0.7, 0.7, 1},
                                                            {0.3, 1, 0.8},
                                                            {1, 0.45, 0.4}}};
constexpr std::array<double, 3> kResting = {0.72, 0.72, 0.72};
constexpr double kFontPx = 17;

// The picture, enlarged and darkened so that what is drawn on it stands out.
Surface MakeSurface(const cv::Mat& luma, int scale) {
  constexpr double kDark = 0.6;
  Surface surface(cairo_image_surface_create(CAIRO_FORMAT_RGB24, scale * luma.cols, scale * luma.rows));
  unsigned char* data = cairo_image_surface_get_data(surface.get());
  if (!data) throw Fail("a picture of {}x{} px is too large to draw on", scale * luma.cols, scale * luma.rows);
  const int stride = cairo_image_surface_get_stride(surface.get());
  for (int y = 0; y < scale * luma.rows; ++y)
    for (int x = 0; x < scale * luma.cols; ++x) {
      const auto level = static_cast<unsigned char>(kDark * luma.at<unsigned char>(y / scale, x / scale));
      std::fill_n(data + y * stride + 4 * x, 4, level);
    }
  cairo_surface_mark_dirty(surface.get());
  return surface;
}

class SpotPainter {
 public:
  SpotPainter(cairo_t* context, cv::Size size, int scale) : context_(context), labels_(size), scale_(scale) {
    cairo_select_font_face(context_, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_BOLD);
    cairo_set_font_size(context_, kFontPx);
  }

  void Paint(const std::vector<NumberedSpot>& spots) {
    for (const NumberedSpot& spot : spots) {
      const double radius = RingPx(spot);
      const cv::Point2d centre = Place(spot.position);
      labels_.Avoid({centre.x - radius, centre.y - radius, 2 * radius, 2 * radius});
    }
    for (const NumberedSpot& spot : spots) PaintPath(spot);
    for (const NumberedSpot& spot : spots) PaintRing(spot);
    for (const NumberedSpot& spot : spots) PaintNumber(spot);
  }

 private:
  // The centre of the top-left pixel is (0, 0) in the recording, and half a pixel from the corner here.
  cv::Point2d Place(const Eigen::Vector2d& px) const { return {scale_ * (px.x() + 0.5), scale_ * (px.y() + 0.5)}; }
  double RingPx(const NumberedSpot& spot) const { return scale_ * spot.radius_px + 4; }

  void SetColour(const NumberedSpot& spot, double opacity) {
    const auto& c = spot.moves ? kColours[static_cast<std::size_t>(spot.id) % kColours.size()] : kResting;
    cairo_set_source_rgba(context_, c[0], c[1], c[2], opacity);
  }

  void PaintPath(const NumberedSpot& spot) {
    if (!spot.moves) return;
    SetColour(spot, 0.55);
    cairo_set_line_width(context_, 1.5);
    for (const Eigen::Vector2d& px : spot.path) cairo_line_to(context_, Place(px).x, Place(px).y);
    cairo_stroke(context_);
  }

  void PaintRing(const NumberedSpot& spot) {
    constexpr std::array<double, 2> kDashes = {4, 3};
    SetColour(spot, 1);
    cairo_set_line_width(context_, spot.moves ? 2 : 1.2);
    cairo_set_dash(context_, kDashes.data(), spot.in_frame ? 0 : static_cast<int>(kDashes.size()), 0);
    const cv::Point2d centre = Place(spot.position);
    cairo_new_sub_path(context_);
    cairo_arc(context_, centre.x, centre.y, RingPx(spot), 0, 2 * std::numbers::pi);
    cairo_stroke(context_);
    cairo_set_dash(context_, kDashes.data(), 0, 0);
  }

  void PaintNumber(const NumberedSpot& spot) {
    const std::string text = std::to_string(spot.id);
    cairo_text_extents_t extents;
    cairo_text_extents(context_, text.c_str(), &extents);
    const cv::Size2d size(extents.x_advance + 6, kFontPx + 3);
    const cv::Point2d corner = labels_.Place(text, Place(spot.position), RingPx(spot), size);
    cairo_set_source_rgba(context_, 0, 0, 0, 0.7);
    cairo_rectangle(context_, corner.x, corner.y, size.width, size.height);
    cairo_fill(context_);
    SetColour(spot, 1);
    cairo_move_to(context_, corner.x + 3, corner.y + kFontPx - 1);
    cairo_show_text(context_, text.c_str());
  }

  cairo_t* context_;
  OverlayLabels labels_;
  int scale_;
};

}  // namespace

void DrawNumberedSpots(const cv::Mat& luma, const std::vector<NumberedSpot>& spots, const std::filesystem::path& out) {
  constexpr int kLeastWidth = 1280;
  const int scale = std::max(1, (kLeastWidth + luma.cols - 1) / luma.cols);
  const Surface surface = MakeSurface(luma, scale);
  const Context context(cairo_create(surface.get()));
  SpotPainter(context.get(), {scale * luma.cols, scale * luma.rows}, scale).Paint(spots);
  AtomicFile file(out);
  if (const cairo_status_t status = cairo_surface_write_to_png(surface.get(), file.TemporaryPath().c_str());
      status != CAIRO_STATUS_SUCCESS)
    throw Fail("{}: cannot be written: {}", out.string(), cairo_status_to_string(status));
  file.Commit();
}

}  // namespace lake::overlay
