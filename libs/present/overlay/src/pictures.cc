#include "lake/overlay/pictures.h"

#include <cairo.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <utility>

#include "lake/core/error.h"
#include "overlay_labels.h"

namespace lake::overlay {
namespace {

using Eigen::Vector2d;

struct Colour {
  double red, green, blue, alpha = 1;
};

// A page of RGB pixels that cairo draws on.
class Page {
 public:
  Page(int width, int height, double text_px)
      : text_px_(text_px),
        surface_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height), cairo_surface_destroy),
        cairo_(cairo_create(surface_.get()), cairo_destroy),
        labels_({width, height}) {
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
  void Circle(cv::Point2d centre, double radius, const Colour& colour, bool thick) {
    SetColour(colour);
    cairo_new_path(cairo_.get());
    cairo_arc(cairo_.get(), centre.x, centre.y, radius, 0, 2 * std::numbers::pi);
    Stroke(thick);
  }

  void Line(const std::vector<cv::Point2d>& points, const Colour& colour) {
    SetColour(colour);
    cairo_new_path(cairo_.get());
    for (const cv::Point2d& point : points) cairo_line_to(cairo_.get(), point.x, point.y);
    Stroke(true);
  }

  // What labels keep off; and a label beside a disc, within the picture.
  void Avoid(cv::Point2d centre, double radius) {
    labels_.Avoid({centre.x - radius, centre.y - radius, 2 * radius, 2 * radius});
  }
  void Label(const std::string& text, cv::Point2d centre, double radius, const Colour& colour) {
    constexpr double kBeside = 3;
    const cv::Size2d size(WidthOf(text) + 2 * kBeside, text_px_ + kBeside);
    const cv::Point2d corner = labels_.Place(text, centre, radius, size);
    WriteOver(text, corner.x + kBeside, corner.y + text_px_ - 1, colour);
  }

  // A grey picture, enlarged, in the upper left corner, where labels are to stay.
  void Paint(const cv::Mat& grey, double scale) {
    labels_ = OverlayLabels({static_cast<int>(grey.cols * scale), static_cast<int>(grey.rows * scale)});
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

  void SetColour(const Colour& c) { cairo_set_source_rgba(cairo_.get(), c.red, c.green, c.blue, c.alpha); }

  double text_px_;
  std::unique_ptr<cairo_surface_t, decltype(&cairo_surface_destroy)> surface_;
  std::unique_ptr<cairo_t, decltype(&cairo_destroy)> cairo_;
  OverlayLabels labels_;
};

constexpr std::array<Colour, 8> kSpotColours = {Colour{1, 0.85, 0.2}, {0.3, 0.9, 1}, {1, 0.5, 0.75}, {0.5, 1, 0.45},
                                                {1, 0.6, 0.25},       {0.7, 0.7, 1}, {0.3, 1, 0.8},  {1, 0.45, 0.4}};
constexpr Colour kResting = {0.72, 0.72, 0.72};

Colour ColourOf(const NumberedSpot& spot) {
  return spot.moves ? kSpotColours[static_cast<std::size_t>(spot.id) % kSpotColours.size()] : kResting;
}

constexpr double kFrameWidth = 960, kAdviceWidth = 640, kMargin = 16, kLineHeight = 20, kTextSize = 15;

// Of good, poor, unfit and not judged: distinct also to those who see no red and green, and a sign of its own each.
constexpr std::array<Colour, 4> kGrades = {Colour{0, 0.45, 0.32}, Colour{0.65, 0.4, 0}, Colour{0.8, 0.1, 0.2},
                                           Colour{0.4, 0.4, 0.4}};
constexpr std::array<const char*, 4> kSigns = {"✓", "!", "✗", "?"};
constexpr Colour kNamedSpot = {0.35, 0.9, 0.65}, kOtherSpot = {0.95, 0.75, 0.3};  // over a dark picture
constexpr Colour kInk = {0.15, 0.15, 0.15}, kAdvice = {0.1, 0.27, 0.45};

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
  constexpr double kIndent = 22;
  double y = kMargin + 2 * kLineHeight;
  for (const CheckPicture::Line& line : lines) {
    const auto grade = static_cast<std::size_t>(line.grade);
    if (draws) page.Write(kSigns.at(grade), left, y, kGrades.at(grade));
    for (const auto& [text, colour] : {std::pair(line.text, kInk), {line.advice, kAdvice}})
      for (const std::string& part : Wrapped(page, text, kAdviceWidth - 2 * kMargin - kIndent)) {
        if (draws) page.Write(part, left + kIndent, y, colour);
        y += kLineHeight;
      }
    y += kLineHeight / 4;
  }
  return y;
}

constexpr double kKneesWidth = 640, kKneesHeight = 480, kKneesText = 20;
constexpr Colour kKneeRing = {1, 0.75, 0.25}, kJointRing = {0.95, 0.6, 0.8}, kWay = {1, 1, 1};

// The leg with some room, of the page's proportions, within the frame.
cv::Rect PartWithLeg(const KneesPicture& picture) {
  Vector2d low = picture.knee.cwiseMin(picture.joint), high = picture.knee.cwiseMax(picture.joint);
  for (const Vector2d& marker : picture.leg) {
    low = low.cwiseMin(marker);
    high = high.cwiseMax(marker);
  }
  constexpr double kRoom = 1.3;
  const Vector2d size = kRoom * (high - low), middle = (low + high) / 2;
  const double width =
                   std::min({std::max(size.x(), size.y() * kKneesWidth / kKneesHeight),
                             static_cast<double>(picture.frame.cols), picture.frame.rows * kKneesWidth / kKneesHeight}),
               height = width * kKneesHeight / kKneesWidth;
  const auto from = [](double centre, double length, int limit) {
    return static_cast<int>(std::clamp(centre - length / 2, 0.0, limit - length));
  };
  return {from(middle.x(), width, picture.frame.cols), from(middle.y(), height, picture.frame.rows),
          static_cast<int>(width), static_cast<int>(height)};
}

}  // namespace

cv::Mat DrawNumberedSpots(const cv::Mat& luma, const std::vector<NumberedSpot>& spots) {
  constexpr int kLeastWidth = 1280;
  constexpr double kDark = 0.6, kText_px = 17, kBeside_px = 4, kPathAlpha = 0.55;
  const int scale = std::max(1, (kLeastWidth + luma.cols - 1) / luma.cols);
  Page page(scale * luma.cols, scale * luma.rows, kText_px);
  page.Paint(kDark * luma, scale);  // what is drawn on it stands out
  // The centre of the top-left pixel is (0, 0) in the recording, and half a pixel from the corner here.
  const auto place = [&](const Vector2d& px) { return cv::Point2d(scale * (px.x() + 0.5), scale * (px.y() + 0.5)); };
  const auto radius = [&](const NumberedSpot& spot) { return scale * spot.radius_px + kBeside_px; };
  for (const NumberedSpot& spot : spots) {
    page.Avoid(place(spot.position), radius(spot));
    if (!spot.moves) continue;
    std::vector<cv::Point2d> path;
    for (const Vector2d& px : spot.path) path.push_back(place(px));
    Colour faint = ColourOf(spot);
    faint.alpha = kPathAlpha;
    page.Line(path, faint);
  }
  for (const NumberedSpot& spot : spots) page.Circle(place(spot.position), radius(spot), ColourOf(spot), spot.in_frame);
  for (const NumberedSpot& spot : spots)
    page.Label(std::to_string(spot.id), place(spot.position), radius(spot), ColourOf(spot));
  return page.Picture();
}

cv::Mat DrawCheckPicture(const CheckPicture& picture) {
  const double scale = kFrameWidth / picture.frame.cols, frame_height = std::ceil(picture.frame.rows * scale);
  Page measure(1, 1, kTextSize);
  const double height =
      std::max(frame_height + 2 * kLineHeight + kMargin, WriteLines(picture.lines, 0, false, measure) + kMargin);
  Page page(static_cast<int>(kFrameWidth + kAdviceWidth), static_cast<int>(std::ceil(height)), kTextSize);
  page.Paint(picture.frame, scale);
  const auto place = [&](const Vector2d& px) { return cv::Point2d((px.x() + 0.5) * scale, (px.y() + 0.5) * scale); };
  const auto radius = [&](const CheckPicture::Spot& spot) { return std::max(9.0, 1.8 * spot.radius_px * scale); };
  for (const CheckPicture::Spot& spot : picture.spots) {
    page.Circle(place(spot.position), radius(spot), spot.name.empty() ? kOtherSpot : kNamedSpot, !spot.name.empty());
    page.Avoid(place(spot.position), radius(spot));
  }
  for (const CheckPicture::Spot& spot : picture.spots)
    if (!spot.name.empty()) page.Label(spot.name, place(spot.position), radius(spot), kNamedSpot);
  const double left = kFrameWidth + kMargin, legend = frame_height + kLineHeight + kMargin / 2;
  page.Write(picture.title, left, kMargin + kLineHeight / 2, kInk);
  WriteLines(picture.lines, left, true, page);
  page.Write(picture.legend, kMargin, legend, kInk);
  return page.Picture();
}

cv::Mat DrawKnees(const KneesPicture& picture) {
  const cv::Rect part = PartWithLeg(picture);
  const double scale = kKneesWidth / part.width;
  Page page(static_cast<int>(kKneesWidth), static_cast<int>(std::floor(part.height * scale)), kKneesText);
  page.Paint(picture.frame(part), scale);
  const auto place = [&](const Vector2d& px) {
    return cv::Point2d(scale * (px.x() + 0.5 - part.x), scale * (px.y() + 0.5 - part.y));
  };
  const cv::Point2d knee = place(picture.knee), joint = place(picture.joint);
  constexpr double kRing = 11, kGap = 16;
  page.Line({knee, joint}, kWay);
  page.Circle(knee, kRing, kKneeRing, true);
  page.Circle(joint, kRing, kJointRing, true);
  // Names on the sides that look away from each other, the distance beside the middle.
  const bool knee_is_left = knee.x < joint.x;
  const auto write = [&](const std::string& text, cv::Point2d at, bool left, const Colour& colour) {
    page.WriteOver(text, left ? at.x - kGap - page.WidthOf(text) : at.x + kGap, at.y + kKneesText / 3, colour);
  };
  const bool are_apart = std::abs(knee.y - joint.y) > kKneesText;
  write("knee", knee, knee_is_left, kKneeRing);
  write("exoskeleton", joint, !knee_is_left, kJointRing);
  const cv::Point2d beside = (knee + joint) / 2 + cv::Point2d(0, are_apart ? 0 : -2 * kKneesText);
  write(picture.distance, beside, !knee_is_left, kWay);
  return page.Picture();
}

}  // namespace lake::overlay
