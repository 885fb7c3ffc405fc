#include "lake/overlay/check_picture.h"

#include <cairo.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <opencv2/core.hpp>
#include <utility>

#include "lake/core/error.h"

namespace lake::overlay {
namespace {

constexpr double kFrameWidth = 960, kAdviceWidth = 640, kMargin = 16, kLineHeight = 20, kTextSize = 15, kRingWidth = 2;

struct Colour {
  double red, green, blue;
};
// Of good, poor, unfit: distinct also to those who see no red and green.
constexpr std::array<Colour, 3> kGrades = {Colour{0, 0.62, 0.45}, Colour{0.9, 0.6, 0}, Colour{0.8, 0.1, 0.2}};
constexpr Colour kInk = {0.15, 0.15, 0.15}, kAdvice = {0.1, 0.27, 0.45};

// A page of RGB pixels that cairo draws on.
class Page {
 public:
  Page(int width, int height)
      : surface_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height), cairo_surface_destroy),
        cairo_(cairo_create(surface_.get()), cairo_destroy) {
    if (cairo_status(cairo_.get()) != CAIRO_STATUS_SUCCESS)
      throw Fail("a page of {}x{} px cannot be drawn", width, height);
    cairo_set_source_rgb(cairo_.get(), 1, 1, 1);
    cairo_paint(cairo_.get());
    cairo_select_font_face(cairo_.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(cairo_.get(), kTextSize);
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

  void Circle(double x, double y, double radius, const Colour& colour, bool filled) {
    SetColour(colour);
    cairo_new_path(cairo_.get());
    cairo_arc(cairo_.get(), x, y, radius, 0, 2 * std::numbers::pi);
    cairo_set_line_width(cairo_.get(), kRingWidth);
    if (filled)
      cairo_fill(cairo_.get());
    else
      cairo_stroke(cairo_.get());
  }

  // A grey picture in the upper left corner.
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
  void SetColour(const Colour& c) { cairo_set_source_rgb(cairo_.get(), c.red, c.green, c.blue); }

  std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> surface_;
  std::unique_ptr<cairo_t, decltype(&cairo_destroy)> cairo_;
};

// Broken between words, so that each line fits the width.
std::vector<std::string> Wrapped(const Page& page, const std::string& text, double width) {
  std::vector<std::string> lines;
  std::string line;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin), longer = line.empty() ? word : line + " " + word;
    if (!line.empty() && page.WidthOf(longer) > width)
      lines.push_back(std::exchange(line, word));
    else
      line = longer;
    begin = end + 1;
  }
  if (!line.empty()) lines.push_back(line);
  return lines;
}

// Writes the lines where `draws`, else only measures them; the height they take.
double WriteLines(const std::vector<CheckPicture::Line>& lines, double left, bool draws, Page& page) {
  constexpr double kDot = 5, kIndent = 22;
  double y = kMargin + 2 * kLineHeight;
  for (const CheckPicture::Line& line : lines) {
    if (draws) page.Circle(left + kDot, y - kDot, kDot, kGrades.at(static_cast<std::size_t>(line.grade)), true);
    for (const auto& [text, colour] : {std::pair(line.text, kInk), {line.advice, kAdvice}})
      for (const std::string& part : Wrapped(page, text, kAdviceWidth - 2 * kMargin - kIndent)) {
        if (draws) page.Write(part, left + kIndent, y, colour);
        y += kLineHeight;
      }
    y += kLineHeight / 4;
  }
  return y;
}

}  // namespace

cv::Mat DrawCheckPicture(const CheckPicture& picture) {
  const double scale = kFrameWidth / picture.frame.cols, frame_height = std::ceil(picture.frame.rows * scale);
  Page measure(1, 1);
  const double height =
      std::max(frame_height + 2 * kLineHeight + kMargin, WriteLines(picture.lines, 0, false, measure) + kMargin);
  Page page(static_cast<int>(kFrameWidth + kAdviceWidth), static_cast<int>(std::ceil(height)));
  page.Paint(picture.frame, scale);
  for (const CheckPicture::Spot& spot : picture.spots)
    page.Circle((spot.position.x() + 0.5) * scale, (spot.position.y() + 0.5) * scale,
                std::max(9.0, 1.8 * spot.radius_px * scale), kGrades[spot.is_marker ? 0 : 1], false);
  const double left = kFrameWidth + kMargin, legend = frame_height + kLineHeight + kMargin / 2;
  page.Write(picture.title, left, kMargin + kLineHeight / 2, kInk);
  WriteLines(picture.lines, left, true, page);
  page.Circle(kMargin, legend - 5, 8, kGrades[0], false);
  page.Write("taken for a marker", 2.2 * kMargin, legend, kInk);
  page.Circle(kMargin + 200, legend - 5, 8, kGrades[1], false);
  page.Write("another bright spot", 2.2 * kMargin + 200, legend, kInk);
  return page.Picture();
}

}  // namespace lake::overlay
