#include "picture_repeat.h"

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

namespace lake::tracking {
namespace {

// The part of a picture round a place that need not be whole pixels.
cv::Mat PatchAt(const cv::Mat& picture, const Eigen::Vector2d& center, const cv::Size& size) {
  cv::Mat patch;
  cv::getRectSubPix(picture, size, {static_cast<float>(center.x()), static_cast<float>(center.y())}, patch, CV_32F);
  return patch;
}

constexpr double kLeastPictureStepPx = 0.5;

// Of the patch that shows an object and a little of what is round it; nullopt if it does not move or leaves the
// picture.
std::optional<cv::Size> PatchSize(const cv::Mat& picture, const ExpectedStep& e) {
  constexpr double kMarginPx = 2;
  if (e.step.norm() < kLeastPictureStepPx) return std::nullopt;
  const int side = 2 * static_cast<int>(std::ceil(e.radius_px + kMarginPx)) + 1;
  const cv::Rect inner(side, side, picture.cols - 2 * side, picture.rows - 2 * side);
  const Eigen::Vector2d to = e.position + e.step;
  const bool is_inside = inner.contains({static_cast<int>(e.position.x()), static_cast<int>(e.position.y())}) &&
                         inner.contains({static_cast<int>(to.x()), static_cast<int>(to.y())});
  return is_inside ? std::optional(cv::Size(side, side)) : std::nullopt;
}

}  // namespace

bool IsRepeated(const cv::Mat& before, const cv::Mat& now, const std::vector<ExpectedStep>& expected) {
  constexpr double kMuchLess = 0.35;  // of squares; of a moved picture it is above 1
  constexpr double kStill = 0.12;     // of the expected step
  // Coding leaves single blocks as they were where objects begin to move.
  constexpr int kFewest = 2;
  int moving = 0;
  double as_before = 0, as_expected = 0;
  double along = 0, slopes = 0;  // normal equation of the part of the steps that was made (Lucas & Kanade 1981)
  for (const ExpectedStep& e : expected) {
    const auto patch_size = PatchSize(now, e);
    if (!patch_size) continue;
    const cv::Size size = *patch_size;
    ++moving;
    // Shorter than the step, as a difference over more than an edge's width is no slope.
    const Eigen::Vector2d nearby = e.step / std::max(1.0, e.step.norm());
    const cv::Mat old = PatchAt(before, e.position, size), same = PatchAt(now, e.position, size),
                  moved = PatchAt(now, e.position + e.step, size),
                  slope = PatchAt(before, e.position - nearby, size) - PatchAt(before, e.position + nearby, size);
    as_before += cv::norm(same, old, cv::NORM_L2SQR);
    as_expected += cv::norm(moved, old, cv::NORM_L2SQR);
    along += (same - old).dot(0.5 * slope) * nearby.norm() / e.step.norm();
    slopes += 0.25 * slope.dot(slope);
  }
  return moving >= kFewest && as_before < kMuchLess * as_expected && std::abs(along) < kStill * slopes;
}

double Mismatch(const cv::Mat& before, const cv::Mat& now, const std::vector<ExpectedStep>& expected) {
  double difference = 0, unevenness = 0;
  for (const ExpectedStep& e : expected) {
    const auto size = PatchSize(now, e);
    if (!size) continue;
    const cv::Mat old = PatchAt(before, e.position, *size), moved = PatchAt(now, e.position + e.step, *size);
    difference += cv::norm(moved, old, cv::NORM_L2SQR);
    unevenness += cv::norm(cv::Mat(old - cv::mean(old)), cv::NORM_L2SQR);
  }
  return unevenness > 0 ? difference / unevenness : NAN;
}

}  // namespace lake::tracking
