#include "rigidity.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace lake::tracking {
namespace {

// Whether the first and last frames leave room for one that both have.
bool AreAtOneTime(const Tracklet& a, const Tracklet& b) {
  return !a.samples.empty() && !b.samples.empty() && a.samples.front().frame <= b.samples.back().frame &&
         b.samples.front().frame <= a.samples.back().frame;
}

std::size_t FirstFrom(const Tracklet& tracklet, std::int64_t frame) {
  const auto before = [](const TrackletSample& sample, std::int64_t wanted) { return sample.frame < wanted; };
  return static_cast<std::size_t>(std::lower_bound(tracklet.samples.begin(), tracklet.samples.end(), frame, before) -
                                  tracklet.samples.begin());
}

// Calls f(sample of a, sample of b) for each frame in which both have one.
template <typename F>
void ForCommonFrames(const Tracklet& a, const Tracklet& b, F f) {
  if (!AreAtOneTime(a, b)) return;
  std::size_t i = FirstFrom(a, b.samples.front().frame), j = FirstFrom(b, a.samples.front().frame);
  while (i < a.samples.size() && j < b.samples.size()) {
    const auto fa = a.samples[i].frame, fb = b.samples[j].frame;
    if (fa == fb) f(i, j);
    i += fa <= fb;
    j += fb <= fa;
  }
}

}  // namespace

int CommonFrames(const Tracklet& a, const Tracklet& b) {
  int frames = 0;
  ForCommonFrames(a, b, [&](std::size_t, std::size_t) { ++frames; });
  return frames;
}

MetricTracklets::MetricTracklets(const std::vector<Tracklet>& tracklets,
                                 const std::function<Eigen::Vector2d(const Eigen::Vector2d&)>& metric_from_px)
    : tracklets_(&tracklets) {
  for (const Tracklet& tracklet : tracklets) {
    auto& positions = metric_.emplace_back();
    positions.reserve(tracklet.samples.size());
    for (const TrackletSample& sample : tracklet.samples) positions.push_back(metric_from_px(sample.position));
  }
}

double MetricTracklets::Extent(std::size_t i) const {
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& position : metric_[i]) box.extend(position);
  return box.diagonal().norm();
}

double MetricTracklets::Range(std::size_t i, const Eigen::Vector2d& along) const {
  Eigen::AlignedBox<double, 1> range;
  for (const Eigen::Vector2d& position : metric_[i]) range.extend(Eigen::Matrix<double, 1, 1>(along.dot(position)));
  return range.isEmpty() ? 0 : range.sizes()[0];
}

double MetricTracklets::ExtentIn(std::size_t i, double from_s, double to_s) const {
  const std::vector<TrackletSample>& samples = (*this)[i].samples;
  const auto before = [](const TrackletSample& sample, double t) { return sample.time_s < t; };
  const auto begin = std::lower_bound(samples.begin(), samples.end(), from_s, before) - samples.begin(),
             end = std::lower_bound(samples.begin(), samples.end(), to_s, before) - samples.begin();
  Eigen::AlignedBox2d box;
  for (auto k = begin; k < end; ++k) box.extend(metric_[i][static_cast<std::size_t>(k)]);
  return box.isEmpty() ? 0 : box.diagonal().norm();
}

double MetricTracklets::WayRange(std::size_t from, std::size_t to, const Eigen::Vector2d& along) const {
  Eigen::AlignedBox<double, 1> range;
  ForCommonFrames((*this)[from], (*this)[to], [&](std::size_t a, std::size_t b) {
    range.extend(Eigen::Matrix<double, 1, 1>(along.dot(metric_[to][b] - metric_[from][a])));
  });
  return range.isEmpty() ? 0 : range.sizes()[0];
}

const PairDistance& MetricTracklets::Distance(std::size_t i, std::size_t j) const {
  // Most pairs of a long recording are never seen together, and they grow with the square of its length: not kept.
  static const PairDistance kNeverTogether;
  if (!AreAtOneTime((*this)[i], (*this)[j])) return kNeverTogether;
  const auto key = std::minmax(i, j);
  const auto found = distances_.find(key);
  if (found != distances_.end()) return found->second;
  return distances_.emplace(key, Measure(key.first, key.second)).first->second;
}

Eigen::Vector2d MetricTracklets::MeanWay(std::size_t from, std::size_t to) const {
  return from < to ? Distance(from, to).mean_way : -Distance(from, to).mean_way;
}

PairDistance MetricTracklets::Measure(std::size_t i, std::size_t j) const {
  PairDistance pair;
  double sum = 0, square_sum = 0;
  ForCommonFrames((*this)[i], (*this)[j], [&](std::size_t a, std::size_t b) {
    const Eigen::Vector2d way = metric_[j][b] - metric_[i][a];
    const double distance = way.norm();
    ++pair.frames;
    pair.mean_way += way;
    sum += distance;
    square_sum += distance * distance;
  });
  if (pair.frames == 0) return pair;
  pair.mean = sum / pair.frames;
  pair.mean_way /= pair.frames;
  pair.deviation =
      std::sqrt(std::max(0.0, square_sum / pair.frames - pair.mean * pair.mean)) / std::max(pair.mean, 1e-9);
  return pair;
}

}  // namespace lake::tracking
