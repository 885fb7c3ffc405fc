#include "lake/tracking/blob_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "lake/core/wide_vectors.h"
#include "lake/video/halve.h"

namespace lake::tracking {
namespace {

// A level of the pyramid answers to blobs of about 1.2 to 2.6 of its own pixels.
constexpr double kLevelRadius = 1.9;
constexpr int kCenterReach = 1, kSurroundReach = 4;  // half the sides of the boxes, without the middle: 3 and 9 px
constexpr int kBorder = kSurroundReach + 1;
constexpr int kSurroundPixels = 81;

// Mean of the box of 3 × 3 pixels.
double Smooth(const cv::Mat& grey, const cv::Point& place) {
  int sum = 0;
  for (int dy = -kCenterReach; dy <= kCenterReach; ++dy)
    for (int dx = -kCenterReach; dx <= kCenterReach; ++dx) sum += grey.at<uchar>(place.y + dy, place.x + dx);
  return sum / 9.0;
}

// A blob's surroundings: a ring of eight places is dark but for a neighbour or two. An edge is bright in more, a line
// in two that face each other.
bool IsDarkAllRound(const cv::Mat& grey, const cv::Point& place, bool may_be_line) {
  constexpr int kFar = 4, kNear = 3;
  constexpr std::size_t kMaxBright = 2;
  static const std::array<cv::Point, 8> kRing = {cv::Point(kFar, 0),  {kNear, kNear},   {0, kFar},  {-kNear, kNear},
                                                 cv::Point(-kFar, 0), {-kNear, -kNear}, {0, -kFar}, {kNear, -kNear}};
  std::array<double, 8> levels, sorted;
  for (std::size_t i = 0; i < kRing.size(); ++i) levels[i] = Smooth(grey, place + kRing[i]);
  sorted = levels;
  std::sort(sorted.begin(), sorted.end());
  const double dark = sorted[2];
  const double half = dark + 0.5 * (Smooth(grey, place) - dark);
  for (std::size_t i = 0; i < kRing.size() / 2 && !may_be_line; ++i)
    if (levels[i] >= half && levels[i + kRing.size() / 2] >= half) return false;
  return sorted[kRing.size() - 1 - (may_be_line ? 2 * kMaxBright : kMaxBright)] < half;
}

// The row that comes into the sums over columns, and the one that leaves them.
LAKE_WIDE_VECTORS void SlideSums(const uchar* entering, const uchar* leaving, std::size_t width, std::int16_t* sums) {
  for (std::size_t x = 0; x < width; ++x) sums[x] = static_cast<std::int16_t>(sums[x] + entering[x] - leaving[x]);
}

// Sums over three neighbours; those at the ends stay as they are.
LAKE_WIDE_VECTORS void SumThrees(const std::int16_t* sums, std::size_t width, std::int16_t* threes) {
  for (std::size_t x = 1; x + 1 < width; ++x)
    threes[x] = static_cast<std::int16_t>(sums[x - 1] + sums[x] + sums[x + 1]);
}

LAKE_WIDE_VECTORS void Subtract(const std::int16_t* center, const std::int16_t* surround3, std::size_t width,
                                std::int16_t* contrast) {
  for (std::size_t x = kSurroundReach; x + kSurroundReach < width; ++x)
    contrast[x] = static_cast<std::int16_t>(9 * (center[x - 1] + center[x] + center[x + 1]) -
                                            (surround3[x - 3] + surround3[x] + surround3[x + 3]));
}

LAKE_WIDE_VECTORS std::int16_t Greatest(const std::int16_t* values, std::size_t count) {
  std::int16_t greatest = 0;
  for (std::size_t x = 0; x < count; ++x) greatest = std::max(greatest, values[x]);
  return greatest;
}

// Centre minus surroundings, row by row from kSurroundReach on: 81 × (mean of the 3 × 3 box − mean of the 9 × 9 box),
// which fits 16 bits, so that the processor works on many pixels at once.
class ContrastRows {
 public:
  using Row = std::vector<std::int16_t>;

  // The sums stand one row before the first, with rows of zeros to leave them.
  explicit ContrastRows(const cv::Mat& grey)
      : grey_(grey), nothing_(Width()), center_(Width()), surround_(Width()), surround3_(Width()) {
    for (int y = 0; y < 2 * kSurroundReach; ++y) SlideSums(grey_.ptr(y), nothing_.data(), Width(), surround_.data());
    for (int y = kSurroundReach - kCenterReach; y < kSurroundReach + kCenterReach; ++y)
      SlideSums(grey_.ptr(y), nothing_.data(), Width(), center_.data());
  }

  // Columns nearer than kSurroundReach to the sides stay as they are.
  void Next(Row& contrast) {
    const bool is_first = y_ == kSurroundReach;
    const auto leaving = [&](int reach) { return is_first ? nothing_.data() : grey_.ptr(y_ - reach - 1); };
    SlideSums(grey_.ptr(y_ + kSurroundReach), leaving(kSurroundReach), Width(), surround_.data());
    SlideSums(grey_.ptr(y_ + kCenterReach), leaving(kCenterReach), Width(), center_.data());
    SumThrees(surround_.data(), Width(), surround3_.data());
    Subtract(center_.data(), surround3_.data(), Width(), contrast.data());
    ++y_;
  }

 private:
  std::size_t Width() const { return static_cast<std::size_t>(grey_.cols); }

  const cv::Mat& grey_;
  int y_ = kSurroundReach;
  const std::vector<uchar> nothing_;
  Row center_, surround_, surround3_;  // sums over columns of 3 and 9 pixels; of the latter, over three columns
};

// Columns of a row that reach the threshold; runs below it are skipped at once, long ones first.
void FindReaching(const ContrastRows::Row& contrast, int threshold, std::vector<int>& columns) {
  constexpr std::size_t kLong = 256, kShort = 32;
  columns.clear();
  const std::size_t end = contrast.size() - kBorder;
  for (std::size_t begin = kBorder; begin < end; begin += kLong) {
    const std::size_t stop = std::min(end, begin + kLong);
    if (Greatest(&contrast[begin], stop - begin) < threshold) continue;
    for (std::size_t x = begin; x < stop; x += kShort) {
      const std::size_t short_stop = std::min(stop, x + kShort);
      if (Greatest(&contrast[x], short_stop - x) < threshold) continue;
      for (std::size_t at = x; at < short_stop; ++at)
        if (contrast[at] >= threshold) columns.push_back(static_cast<int>(at));
    }
  }
}

bool IsHighest(const std::array<ContrastRows::Row, 3>& rows, int y, int x) {
  const auto at = static_cast<std::size_t>(x);
  const std::int16_t here = rows[static_cast<std::size_t>(y % 3)][at];
  return std::all_of(rows.begin(), rows.end(), [&](const ContrastRows::Row& row) {
    return here >= std::max({row[at - 1], row[at], row[at + 1]});
  });
}

void SearchLevel(const cv::Mat& grey, double scale, const cv::Rect& region, const BlobSearchOptions& options,
                 std::vector<BlobCandidate>& candidates) {
  if (grey.cols <= 2 * kBorder || grey.rows <= 2 * kBorder) return;
  // The centre minus surroundings of a blob of the level's radius is about 0.8 of its contrast.
  constexpr double kResponse = 0.8;
  const int threshold =
      static_cast<int>(std::ceil(kSurroundPixels * std::max(2.0, 0.75 * kResponse * options.min_contrast)));
  ContrastRows contrast(grey);
  std::array<ContrastRows::Row, 3> rows;  // y − 1, y, y + 1, each at its number modulo 3
  rows.fill(ContrastRows::Row(static_cast<std::size_t>(grey.cols)));
  const auto row = [&](int y) -> ContrastRows::Row& { return rows[static_cast<std::size_t>(y % 3)]; };
  contrast.Next(row(kBorder - 1));
  contrast.Next(row(kBorder));
  std::vector<int> columns;
  for (int y = kBorder; y < grey.rows - kBorder; ++y) {
    contrast.Next(row(y + 1));
    FindReaching(row(y), threshold, columns);
    for (const int x : columns) {
      if (!IsHighest(rows, y, x) || !IsDarkAllRound(grey, {x, y}, options.streaks)) continue;
      const Eigen::Vector2d position((x + 0.5) * scale - 0.5 + region.x, (y + 0.5) * scale - 0.5 + region.y);
      const double response = static_cast<double>(row(y)[static_cast<std::size_t>(x)]) / kSurroundPixels;
      candidates.push_back({position, kLevelRadius * scale, response / kResponse});
    }
  }
}

}  // namespace

std::vector<BlobCandidate> FindBlobs(const cv::Mat& grey, const cv::Rect& region, const BlobSearchOptions& options) {
  std::vector<BlobCandidate> found;
  cv::Mat level = grey(region);
  for (double scale = 1; 1.2 * scale <= options.max_radius_px; scale *= 2) {
    if (2.6 * scale >= options.min_radius_px) SearchLevel(level, scale, region, options, found);
    if (level.cols < 2 || level.rows < 2) break;
    cv::Mat half;
    video::Halve(level, half);
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

}  // namespace lake::tracking
