#include <charconv>
#include <cmath>
#include <opencv2/core.hpp>

#include "chroma_planes.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/tracking/marker_detector.h"

namespace lake::tracking {
namespace {

// Chroma (Cr, Cb) of a colour in the levels of video.
cv::Vec2d ChromaOf(const cv::Vec3b& bgr, bool bt709) {
  const double red = bt709 ? 0.2126 : 0.299, blue = bt709 ? 0.0722 : 0.114;
  const double luma = blue * bgr[0] + (1 - blue - red) * bgr[1] + red * bgr[2];
  constexpr double kRange = 224.0 / 255;
  return {kRange * (bgr[2] - luma) / (2 * (1 - red)), kRange * (bgr[0] - luma) / (2 * (1 - blue))};
}

}  // namespace

MarkerColor ParseMarkerColor(const std::string& text) {
  MarkerColor color{text};
  if (text.starts_with('@')) {
    std::string place = text.substr(1);
    const std::string what = fmt::format("--color '{}'", text);
    if (const auto at = place.find('@'); at != std::string::npos) {
      constexpr double kMostFrames = 1e12;
      const double frame = ParseNumbers(place.substr(at + 1), 1, what + ": frame").front();
      if (!(frame >= 0 && frame <= kMostFrames) || frame != std::floor(frame))
        throw UsageError("{}: a frame is a whole number from 0", what);
      color.frame = static_cast<std::int64_t>(frame);
      place.resize(at);
    }
    const std::vector<double> xy = ParseNumbers(place, 2, what);
    color.position = {xy[0], xy[1]};
    return color;
  }
  unsigned value = 0;
  const char* end = text.data() + text.size();
  if (text.size() != 7 || text[0] != '#' || std::from_chars(text.data() + 1, end, value, 16).ptr != end)
    throw UsageError(
        "--color '{}': write a colour as \"#RRGGBB\", or as @X,Y[@FRAME], the place in px where a marker is", text);
  color.bgr = {static_cast<uchar>(value & 255), static_cast<uchar>(value >> 8 & 255), static_cast<uchar>(value >> 16)};
  return color;
}

MarkerHue HueOfColor(const MarkerColor& color, bool bt709) {
  constexpr double kMinChroma = 20;
  const cv::Vec2d chroma = ChromaOf(*color.bgr, bt709);
  const double length = cv::norm(chroma);
  if (length < kMinChroma)
    throw UsageError("--color '{}' is a grey: use --detector reflective, with --polarity dark for black", color.text);
  // Names of colours are vague: "blue" lamps are 50° away from #0000ff, and lamps have a chroma of about 100.
  return {chroma / length, 2, 0.5};
}

MarkerHue HueAt(const video::VideoFrame& frame, const MarkerColor& color) {
  const auto [x, y] = std::tuple(color.position.x(), color.position.y());
  if (!(x >= 0 && y >= 0 && x <= frame.luma.cols - 1 && y <= frame.luma.rows - 1))
    throw Fail("--color {}: outside the picture of {}x{} px", color.text, frame.luma.cols, frame.luma.rows);
  const ChromaPlanes chroma = ChromaPlanes::Of(frame.preview);
  // The strongest colour near the place that was pointed at: a lamp's middle has none, a hand is not exact.
  constexpr int kReach = 2;
  const cv::Point middle(static_cast<int>(x / 2), static_cast<int>(y / 2));
  const cv::Rect near =
      cv::Rect(middle.x - kReach, middle.y - kReach, 2 * kReach + 1, 2 * kReach + 1) & cv::Rect({}, chroma.Size());
  cv::Vec2d strongest;
  for (int row = near.y; row < near.br().y; ++row)
    for (int column = near.x; column < near.br().x; ++column)
      if (const cv::Vec2d here = chroma.At(row, column); cv::norm(here) > cv::norm(strongest)) strongest = here;
  constexpr double kMinChroma = 12, kStrength = 170, kMostGain = 5, kMinGain = 1.2;
  const double length = cv::norm(strongest);
  if (length < kMinChroma)
    throw Fail(
        "--color {}: nothing there has a colour (chroma {:.0f} of 128, {:.0f} are needed): point at the middle of "
        "a marker, or use --detector reflective",
        color.text, length, kMinChroma);
  return {strongest / length, std::clamp(kStrength / length, kMinGain, kMostGain), 1};
}

}  // namespace lake::tracking
