#include "lake/tracking/blob_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace lake {
namespace {

// A level of the pyramid answers to blobs of about 1.2 to 2.6 of its own pixels.
constexpr double kLevelRadius = 1.9;
constexpr int kCenterBox = 3, kSurroundBox = 9;
constexpr int kBorder = kSurroundBox / 2 + 1;

// A blob's surroundings: a ring of eight places is dark but for a neighbour or two. An edge is bright in more, a line
// in two that face each other.
bool IsDarkAllRound(const cv::Mat& smooth, const cv::Point& place) {
  constexpr int kFar = 4, kNear = 3;
  constexpr int kMaxBright = 2;
  static const std::array<cv::Point, 8> kRing = {cv::Point(kFar, 0),  {kNear, kNear},   {0, kFar},  {-kNear, kNear},
                                                 cv::Point(-kFar, 0), {-kNear, -kNear}, {0, -kFar}, {kNear, -kNear}};
  std::array<int, 8> levels, sorted;
  for (std::size_t i = 0; i < kRing.size(); ++i) levels[i] = smooth.at<uchar>(place + kRing[i]);
  sorted = levels;
  std::sort(sorted.begin(), sorted.end());
  const double dark = sorted[2];
  const double half = dark + 0.5 * (smooth.at<uchar>(place) - dark);
  for (std::size_t i = 0; i < kRing.size() / 2; ++i)
    if (levels[i] >= half && levels[i + kRing.size() / 2] >= half) return false;
  return sorted[kRing.size() - 1 - kMaxBright] < half;
}

void SearchLevel(const cv::Mat& grey, double scale, const cv::Rect& region, double min_contrast,
                 std::vector<BlobCandidate>& candidates) {
  if (grey.cols <= 2 * kBorder || grey.rows <= 2 * kBorder) return;
  cv::Mat smooth, surround, contrast, highest, bright;
  cv::boxFilter(grey, smooth, CV_8U, {kCenterBox, kCenterBox});
  cv::boxFilter(grey, surround, CV_8U, {kSurroundBox, kSurroundBox});
  cv::subtract(smooth, surround, contrast);
  // The centre minus surroundings of a blob of the level's radius is about 0.8 of its contrast.
  constexpr double kResponse = 0.8;
  cv::compare(contrast, std::max(2.0, 0.75 * kResponse * min_contrast), bright, cv::CMP_GE);
  std::vector<cv::Point> places;
  cv::findNonZero(bright, places);
  if (places.empty()) return;
  cv::dilate(contrast, highest, cv::Mat());
  for (const cv::Point& place : places) {
    const bool inside =
        place.x >= kBorder && place.y >= kBorder && place.x < grey.cols - kBorder && place.y < grey.rows - kBorder;
    const uchar here = contrast.at<uchar>(place);
    if (!inside || here != highest.at<uchar>(place) || !IsDarkAllRound(smooth, place)) continue;
    const Eigen::Vector2d position((place.x + 0.5) * scale - 0.5 + region.x, (place.y + 0.5) * scale - 0.5 + region.y);
    candidates.push_back({position, kLevelRadius * scale, here / kResponse});
  }
}

}  // namespace

std::vector<BlobCandidate> FindBlobs(const cv::Mat& grey, const cv::Rect& region, const BlobSearchOptions& options) {
  std::vector<BlobCandidate> found;
  cv::Mat level = grey(region);
  for (double scale = 1; 1.2 * scale <= options.max_radius_px; scale *= 2) {
    if (2.6 * scale >= options.min_radius_px) SearchLevel(level, scale, region, options.min_contrast, found);
    if (level.cols < 2 || level.rows < 2) break;
    cv::Mat half;
    cv::resize(level(cv::Rect(0, 0, level.cols / 2 * 2, level.rows / 2 * 2)), half, {}, 0.5, 0.5, cv::INTER_AREA);
    level = half;
  }
  std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.contrast > b.contrast; });
  std::vector<BlobCandidate> kept;
  for (const BlobCandidate& candidate : found) {
    if (kept.size() >= options.max_count) break;
    const bool is_new = std::none_of(kept.begin(), kept.end(), [&](const BlobCandidate& other) {
      return (other.position - candidate.position).norm() < 1.5 * std::max(other.radius_px, candidate.radius_px);
    });
    if (is_new) kept.push_back(candidate);
  }
  return kept;
}

}  // namespace lake
