#include "lake/overlay/check_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "page.h"

namespace lake::overlay {
namespace {

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

}  // namespace

cv::Mat DrawCheckPicture(const CheckPicture& picture) {
  const double scale = kFrameWidth / picture.frame.cols, frame_height = std::ceil(picture.frame.rows * scale);
  Page measure(1, 1, kTextSize);
  const double height =
      std::max(frame_height + 2 * kLineHeight + kMargin, WriteLines(picture.lines, 0, false, measure) + kMargin);
  Page page(static_cast<int>(kFrameWidth + kAdviceWidth), static_cast<int>(std::ceil(height)), kTextSize);
  constexpr double kBeside_px = 4;
  page.Paint(picture.frame, scale);
  for (const CheckPicture::Spot& spot : picture.spots) {
    const double x = (spot.position.x() + 0.5) * scale, y = (spot.position.y() + 0.5) * scale,
                 radius = std::max(9.0, 1.8 * spot.radius_px * scale);
    page.Circle(x, y, radius, spot.name.empty() ? kOtherSpot : kNamedSpot, !spot.name.empty());
    if (spot.name.empty()) continue;
    const double right = x + radius + kBeside_px, width = page.WidthOf(spot.name);
    page.WriteOver(spot.name, right + width < kFrameWidth ? right : x - radius - kBeside_px - width, y + 5, kNamedSpot);
  }
  const double left = kFrameWidth + kMargin, legend = frame_height + kLineHeight + kMargin / 2;
  page.Write(picture.title, left, kMargin + kLineHeight / 2, kInk);
  WriteLines(picture.lines, left, true, page);
  page.Write(picture.legend, kMargin, legend, kInk);
  return page.Picture();
}

}  // namespace lake::overlay
