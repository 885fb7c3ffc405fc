#include "snap.h"

#include <cmath>

namespace lake::review {

std::optional<tracking::MarkerDetection> SnapToMarker(const cv::Mat& luma, const Eigen::Vector2d& place,
                                                      double reach_px, tracking::Polarity polarity) {
  const auto can_reach = [&](double at, int size) { return at >= -reach_px && at <= size - 1 + reach_px; };
  if (!can_reach(place.x(), luma.cols) || !can_reach(place.y(), luma.rows)) return std::nullopt;
  constexpr int kRoundMarker = 48;  // px: a marker at the edge of the reach is seen whole, with what is round it
  const int half = static_cast<int>(std::ceil(reach_px)) + kRoundMarker;
  const cv::Rect near(static_cast<int>(std::lround(place.x())) - half, static_cast<int>(std::lround(place.y())) - half,
                      2 * half + 1, 2 * half + 1);
  const tracking::DetectorRegion region{near & cv::Rect(0, 0, luma.cols, luma.rows)};
  video::VideoFrame frame;
  frame.luma = luma;
  std::optional<tracking::MarkerDetection> nearest;
  double least = reach_px;
  for (const tracking::MarkerDetection& found :
       tracking::MakeReflectiveDetector(polarity, region)->Detect(frame, {}, true)) {
    const double distance = (found.position - place).norm();
    if (distance <= least) nearest = found, least = distance;
  }
  return nearest;
}

}  // namespace lake::review
