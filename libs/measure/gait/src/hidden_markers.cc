#include "hidden_markers.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>

#include "lake/core/cross.h"
#include "lake/core/statistics.h"
#include "sizes.h"

namespace lake::gait {
namespace {

using dynamics::DistancePrior, dynamics::PathPoint, dynamics::SeenPath;
using Curves = std::array<MarkerCurve, kLegMarkers>;

// Frames [begin, end).
struct Range {
  std::size_t begin, end;
};

// The frames in which a marker is hidden between frames in which it is seen, with as much to each side as the path
// needs to be known there.
std::vector<Range> HiddenRanges(const SeenPath& seen) {
  constexpr double kMargin_s = 0.5;
  constexpr std::size_t kMargin = 8;  // frames, at least
  std::vector<Range> ranges;
  const std::size_t n = seen.sigma.size();
  std::size_t last = n;
  for (std::size_t i = 0; i < n; ++i) {
    if (!seen.IsSeen(i)) continue;
    if (last < n && i > last + 1) {
      std::size_t begin = last - std::min(last, kMargin), end = std::min(n, i + kMargin + 1);
      while (begin > 0 && seen.time_s[begin] > seen.time_s[last] - kMargin_s) --begin;
      while (end < n && seen.time_s[end - 1] < seen.time_s[i] + kMargin_s) ++end;
      if (!ranges.empty() && begin < ranges.back().end)
        ranges.back().end = end;
      else
        ranges.push_back({begin, end});
    }
    last = i;
  }
  return ranges;
}

// The distance between two markers, where both are seen; nullopt in fewer frames than a curve needs.
std::optional<DistancePrior> DistanceBetween(const SeenPath& own_seen, const MarkerCurve& own,
                                             const SeenPath& other_seen, const MarkerCurve& other) {
  constexpr double kLeastVariation = 1e-3;  // of the length
  constexpr double kLeastMemory_s = 0.05, kMostMemory_s = 10;
  const std::size_t n = own.point.size();
  std::vector<double> lengths, rates;
  DistancePrior distance;
  distance.deviation.assign(n, NAN);
  distance.deviation_sigma.assign(n, NAN);
  for (std::size_t i = 0; i < n; ++i) {
    // A hidden neighbour errs alike for many frames, so it says little.
    distance.other.push_back(other_seen.IsSeen(i) ? other.point[i].position : Eigen::Vector3d::Constant(NAN));
    distance.other_covariance.push_back(other.point[i].position_covariance);
    if (!own_seen.IsSeen(i) || !other_seen.IsSeen(i)) continue;
    const Eigen::Vector3d apart = own.point[i].position - other.point[i].position,
                          speed = own.point[i].velocity - other.point[i].velocity;
    lengths.push_back(distance.deviation[i] = apart.norm());
    const Eigen::Vector3d along = apart.normalized();
    distance.deviation_sigma[i] =
        std::sqrt(along.dot((own.point[i].position_covariance + other.point[i].position_covariance) * along));
    rates.push_back(speed.dot(along));
  }
  if (lengths.size() < kLeastFrames) return std::nullopt;
  distance.length = Mean(lengths);
  for (double& deviation : distance.deviation) deviation -= distance.length;
  distance.sigma = std::max(StandardDeviation(lengths), kLeastVariation * distance.length);
  distance.memory_s = std::clamp(std::sqrt(3) * distance.sigma / RootMeanSquare(rates), kLeastMemory_s, kMostMemory_s);
  // Few changes of the length were seen: the hidden one may be larger.
  const double seen_s = static_cast<double>(lengths.size()) * MedianInterval(own_seen.time_s);
  distance.sigma *= std::sqrt(1 + 12 * distance.memory_s / seen_s);
  return distance;
}

// The two places with the given distances to two points are mirror images; that on the given side of the line from the
// first to the second.
Eigen::Vector3d BetweenTwo(const Eigen::Vector3d& first, const Eigen::Vector3d& second, double to_first,
                           double to_second, double side, double z) {
  const Eigen::Vector2d line = (second - first).head<2>();
  const double length = std::max(line.norm(), 1e-9),
               along = (to_first * to_first - to_second * to_second + length * length) / (2 * length),
               across = std::sqrt(std::max(0.0, to_first * to_first - along * along));
  const Eigen::Vector2d unit = line / length, normal(-unit.y(), unit.x());
  const Eigen::Vector2d place = first.head<2>() + along * unit - std::copysign(across, side) * normal;
  return {place.x(), place.y(), z};
}

class Bridge {
 public:
  Bridge(std::span<const SeenPath> seen, std::size_t marker, const Curves& curves)
      : seen_(seen), marker_(marker), curves_(curves) {
    for (const motion::Segment& segment : motion::kSegments) {
      if (segment.lower != marker && segment.upper != marker) continue;
      const std::size_t other = segment.lower == marker ? segment.upper : segment.lower;
      if (other >= seen.size()) continue;
      if (auto distance = DistanceBetween(seen[marker], curves[marker], seen[other], curves[other])) {
        distances_.push_back(*std::move(distance));
        others_.push_back(other);
      }
    }
    if (distances_.size() < 2) return;
    for (std::size_t i = 0; i < seen[marker].sigma.size(); ++i)
      if (seen[marker].IsSeen(i) && seen[others_[0]].IsSeen(i) && seen[others_[1]].IsSeen(i))
        side_ += Cross((curves[marker].point[i].position - distances_[0].other[i]).head<2>(),
                       (distances_[1].other[i] - distances_[0].other[i]).head<2>());
  }

  std::span<const DistancePrior> Distances() const { return distances_; }

  // Where the marker's place is looked for first. Its own bridge may lead over a gap of seconds to either side.
  PathPoint NearPlace(std::size_t frame) const {
    constexpr double kCertain = 0.05;  // of a segment's length
    const PathPoint& point = curves_[marker_].point[frame];
    if (distances_.size() < 2 || seen_[marker_].IsSeen(frame) || !seen_[others_[0]].IsSeen(frame) ||
        !seen_[others_[1]].IsSeen(frame) ||
        curves_[marker_].plane_sigma[frame] < kCertain * std::min(distances_[0].length, distances_[1].length))
      return point;
    PathPoint between;
    between.position = BetweenTwo(distances_[0].other[frame], distances_[1].other[frame], distances_[0].length,
                                  distances_[1].length, side_, point.position.z());
    return between;
  }

 private:
  std::span<const SeenPath> seen_;
  std::size_t marker_;
  const Curves& curves_;
  std::vector<DistancePrior> distances_;
  std::vector<std::size_t> others_;
  double side_ = 0;
};

}  // namespace

void BridgeHiddenMarkers(std::span<const SeenPath> seen, std::span<const dynamics::PathModel> models,
                         const dynamics::MotionPrior& prior, Curves& curves) {
  constexpr int kIterations = 4;  // of the linearised distances
  for (std::size_t m = 0; m < seen.size(); ++m) {
    const std::vector<Range> ranges = HiddenRanges(seen[m]);
    if (ranges.empty()) continue;
    const Bridge bridge(seen, m, curves);
    if (bridge.Distances().empty()) continue;
    for (const Range& range : ranges) {
      std::vector<PathPoint> near;
      for (std::size_t i = range.begin; i < range.end; ++i) near.push_back(bridge.NearPlace(i));
      dynamics::SmoothedPath path;
      for (int iteration = 0; iteration < kIterations; ++iteration) {
        path = dynamics::BridgePath(seen[m], models[m], prior, bridge.Distances(), near, range.begin, range.end);
        for (std::size_t k = 0; k < near.size(); ++k) near[k] = path.point[k];
      }
      for (std::size_t i = range.begin; i < range.end; ++i)
        if (!seen[m].IsSeen(i)) {
          curves[m].point[i] = path.point[i - range.begin];
          curves[m].plane_sigma[i] = PlaneSigma(curves[m].point[i]);
        }
    }
  }
}

}  // namespace lake::gait
