#include "lake/review/snap.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "lake/core/error.h"

namespace lake::review {
namespace {

// I420, as a colour video's preview; of odd sides the last column or row stands twice.
cv::Mat PreviewOf(const cv::Mat& bgr) {
  cv::Mat even, preview;
  cv::copyMakeBorder(bgr, even, 0, bgr.rows % 2, 0, bgr.cols % 2, cv::BORDER_REPLICATE);
  cv::cvtColor(even, preview, cv::COLOR_BGR2YUV_I420);
  return preview;
}

}  // namespace

tracking::DetectorMaker DetectorOfPatch(const cv::Mat& luma, const Eigen::Vector2d& place) {
  constexpr std::int64_t kNoFrame = -1;  // it is looked for in others
  return [luma, seed = tracking::MarkerSeed{"patch", place, kNoFrame}](const tracking::DetectorRegion& near) {
    try {
      return tracking::MakeTemplateDetector({seed}, {luma}, near);
    } catch (const Error&) {
      throw Error(
          "the picture is even where the marker was measured last: nothing can be found "
          "again; with Alt the marker stays where it is left");
    }
  };
}

std::optional<tracking::MarkerDetection> SnapToMarker(video::VideoFrame frame, const Eigen::Vector2d& place,
                                                      double reach_px, const tracking::DetectorMaker& make_detector,
                                                      const std::function<cv::Mat()>& colours) {
  const cv::Size size = frame.luma.size();
  const auto can_reach = [&](double at, int length) { return at >= -reach_px && at <= length - 1 + reach_px; };
  if (!can_reach(place.x(), size.width) || !can_reach(place.y(), size.height)) return std::nullopt;
  constexpr int kRoundMarker = 48;  // px: a marker at the edge of the reach is seen whole, with what is round it
  const int half = static_cast<int>(std::ceil(reach_px)) + kRoundMarker;
  const cv::Rect near(static_cast<int>(std::lround(place.x())) - half, static_cast<int>(std::lround(place.y())) - half,
                      2 * half + 1, 2 * half + 1);
  const auto detector = make_detector({near & cv::Rect({0, 0}, size)});
  if (detector->NeedsColour()) frame.preview = PreviewOf(colours());
  std::optional<tracking::MarkerDetection> nearest;
  double least = reach_px;
  for (const tracking::MarkerDetection& found : detector->Detect(frame, {}, tracking::Look::kEverywhere)) {
    const double distance = (found.position - place).norm();
    if (distance <= least) {
      nearest = found;
      least = distance;
    }
  }
  return nearest;
}

}  // namespace lake::review
