#include "stitch.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace lake::tracking {
namespace {

constexpr double kLongest_s = 0.25;
constexpr std::size_t kSlopeSamples = 5;

// How a thing moved beside an end of its tracklet: mean velocity over the last few samples, px/s, and their span.
struct EndMotion {
  Eigen::Vector2d velocity;
  double span_s;
};

EndMotion MotionOver(const TrackletSample& from, const TrackletSample& to) {
  const double span_s = to.time_s - from.time_s;
  if (from.frame == to.frame) return {Eigen::Vector2d::Zero(), 0};
  return {(to.position - from.position) / span_s, span_s};
}

EndMotion MotionAtEnd(const Tracklet& tracklet) {
  const std::size_t n = tracklet.samples.size();
  return MotionOver(tracklet.samples[n - std::min(n, kSlopeSamples)], tracklet.samples[n - 1]);
}

EndMotion MotionAtStart(const Tracklet& tracklet) {
  return MotionOver(tracklet.samples.front(), tracklet.samples[std::min(tracklet.samples.size(), kSlopeSamples) - 1]);
}

// Whether what ended may be what begins: of the same size, each met half-way from its own side, and no faster or slower
// than it can have become: a lamp does not go on as the marker that appears beside it.
bool MayGoOnAs(const Tracklet& ended, const Tracklet& begun, const MarkerPhysics& physics) {
  const TrackletSample &last = ended.samples.back(), &first = begun.samples.front();
  const double gap_s = first.time_s - last.time_s;
  if (first.frame <= last.frame || gap_s > kLongest_s) return false;
  if (ended.identity != begun.identity) return false;
  const double ratio = first.radius_px / last.radius_px, radius = std::max(first.radius_px, last.radius_px);
  if (ratio < 0.7 || ratio > 1.4) return false;
  const EndMotion before = MotionAtEnd(ended), after = MotionAtStart(begun);
  const double between_s = gap_s + 0.5 * (before.span_s + after.span_s);
  if ((after.velocity - before.velocity).norm() > physics.AccelerationRadii() * radius * between_s) return false;
  const double half_s = 0.5 * gap_s;
  const Eigen::Vector2d apart = (last.position + half_s * before.velocity) - (first.position - half_s * after.velocity);
  const double reach = 2 + std::min(physics.AccelerationRadii() * half_s * half_s, 6.0);  // radii
  return apart.norm() < reach * radius;
}

}  // namespace

std::vector<Tracklet> StitchPieces(const std::vector<Tracklet>& tracklets, const MarkerPhysics& physics) {
  const std::size_t n = tracklets.size();
  std::vector<std::vector<std::size_t>> next(n), before(n);
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b < n; ++b)
      if (a != b && MayGoOnAs(tracklets[a], tracklets[b], physics)) next[a].push_back(b), before[b].push_back(a);
  const auto goes_on = [&](std::size_t a) -> std::optional<std::size_t> {
    if (next[a].size() != 1 || before[next[a].front()].size() != 1) return std::nullopt;
    return next[a].front();
  };
  std::vector<Tracklet> whole;
  for (std::size_t a = 0; a < n; ++a) {
    const bool is_continued = before[a].size() == 1 && goes_on(before[a].front()) == a;
    if (is_continued) continue;
    whole.push_back(tracklets[a]);
    for (auto b = goes_on(a); b; b = goes_on(*b))
      whole.back().samples.insert(whole.back().samples.end(), tracklets[*b].samples.begin(),
                                  tracklets[*b].samples.end());
  }
  return whole;
}

}  // namespace lake::tracking
