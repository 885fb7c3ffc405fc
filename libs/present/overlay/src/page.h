// Pictures that are drawn with cairo: a grey frame, with circles, lines and text over it and beside it.
#pragma once

#include <cairo.h>

#include <array>
#include <cstdint>
#include <memory>
#include <numbers>
#include <opencv2/core.hpp>
#include <string>

#include "lake/core/error.h"

namespace lake::overlay {

struct Colour {
  double red, green, blue;
};
// A page of RGB pixels that cairo draws on.
class Page {
 public:
  Page(int width, int height, double text_px)
      : surface_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height), cairo_surface_destroy),
        cairo_(cairo_create(surface_.get()), cairo_destroy) {
    if (cairo_status(cairo_.get()) != CAIRO_STATUS_SUCCESS)
      throw Fail("a page of {}x{} px cannot be drawn", width, height);
    cairo_set_source_rgb(cairo_.get(), 1, 1, 1);
    cairo_paint(cairo_.get());
    cairo_select_font_face(cairo_.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(cairo_.get(), text_px);
  }

  double WidthOf(const std::string& text) const {
    cairo_text_extents_t extents;
    cairo_text_extents(cairo_.get(), text.c_str(), &extents);
    return extents.x_advance;
  }

  void Write(const std::string& text, double x, double y, const Colour& colour) {
    SetColour(colour);
    cairo_move_to(cairo_.get(), x, y);
    cairo_show_text(cairo_.get(), text.c_str());
  }

  // Readable over any picture.
  void WriteOver(const std::string& text, double x, double y, const Colour& colour) {
    constexpr double kEdge = 4;
    cairo_new_path(cairo_.get());
    cairo_move_to(cairo_.get(), x, y);
    cairo_text_path(cairo_.get(), text.c_str());
    SetColour({0, 0, 0});
    cairo_set_line_width(cairo_.get(), kEdge);
    cairo_set_line_join(cairo_.get(), CAIRO_LINE_JOIN_ROUND);
    cairo_stroke_preserve(cairo_.get());
    SetColour(colour);
    cairo_fill(cairo_.get());
  }

  // Thick where it is what one looks for, else dashed.
  void Circle(double x, double y, double radius, const Colour& colour, bool thick) {
    SetColour(colour);
    cairo_new_path(cairo_.get());
    cairo_arc(cairo_.get(), x, y, radius, 0, 2 * std::numbers::pi);
    Stroke(thick);
  }

  void Line(double x1, double y1, double x2, double y2, const Colour& colour) {
    SetColour(colour);
    cairo_new_path(cairo_.get());
    cairo_move_to(cairo_.get(), x1, y1);
    cairo_line_to(cairo_.get(), x2, y2);
    Stroke(true);
  }

  // A grey picture, enlarged, in the upper left corner.
  void Paint(const cv::Mat& grey, double scale) {
    const std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> picture(
        cairo_image_surface_create(CAIRO_FORMAT_RGB24, grey.cols, grey.rows), cairo_surface_destroy);
    unsigned char* data = cairo_image_surface_get_data(picture.get());
    if (!data) throw Fail("a picture of {}x{} px cannot be drawn", grey.cols, grey.rows);
    const int stride = cairo_image_surface_get_stride(picture.get());
    for (int y = 0; y < grey.rows; ++y) {
      auto* row = reinterpret_cast<std::uint32_t*>(data + static_cast<std::ptrdiff_t>(y) * stride);
      for (int x = 0; x < grey.cols; ++x) row[x] = grey.at<unsigned char>(y, x) * 0x010101u;
    }
    cairo_surface_mark_dirty(picture.get());
    cairo_save(cairo_.get());
    cairo_scale(cairo_.get(), scale, scale);
    cairo_set_source_surface(cairo_.get(), picture.get(), 0, 0);
    cairo_paint(cairo_.get());
    cairo_restore(cairo_.get());
  }

  cv::Mat Picture() const {
    cairo_surface_flush(surface_.get());
    const int width = cairo_image_surface_get_width(surface_.get()),
              height = cairo_image_surface_get_height(surface_.get());
    const cv::Mat bgrx(height, width, CV_8UC4, cairo_image_surface_get_data(surface_.get()),
                       static_cast<std::size_t>(cairo_image_surface_get_stride(surface_.get())));
    cv::Mat bgr(height, width, CV_8UC3);
    const std::array<int, 6> channels = {0, 0, 1, 1, 2, 2};
    cv::mixChannels(&bgrx, 1, &bgr, 1, channels.data(), 3);
    return bgr;
  }

 private:
  void Stroke(bool thick) {
    constexpr std::array<double, 2> kDashes = {4, 3};
    cairo_set_line_width(cairo_.get(), thick ? 2.5 : 1.5);
    cairo_set_dash(cairo_.get(), kDashes.data(), thick ? 0 : static_cast<int>(kDashes.size()), 0);
    cairo_stroke(cairo_.get());
    cairo_set_dash(cairo_.get(), kDashes.data(), 0, 0);
  }

  void SetColour(const Colour& c) { cairo_set_source_rgb(cairo_.get(), c.red, c.green, c.blue); }

  std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> surface_;
  std::unique_ptr<cairo_t, decltype(&cairo_destroy)> cairo_;
};

}  // namespace lake::overlay
