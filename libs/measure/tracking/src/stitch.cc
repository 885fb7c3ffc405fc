#include "stitch.h"

#include <algorithm>
#include <optional>
#include <span>

#include "path_join.h"

namespace lake::tracking {
namespace {

constexpr double kLongest_s = 0.25;
constexpr double kRival_s = 1;  // what has been lost for so long may still be what begins

// Whether what ended may be what begins: of the same size, and where and as fast as a quick movement can bring it: a
// lamp does not go on as the marker that appears beside it.
bool MayGoOnAs(const Tracklet& ended, double ended_px, const Tracklet& begun, double begun_px,
               const MarkerPhysics& physics) {
  const TrackletSample &last = ended.samples.back(), &first = begun.samples.front();
  const double gap_s = first.time_s - last.time_s;
  if (first.frame <= last.frame || gap_s > kRival_s) return false;
  if (ended.identity != begun.identity) return false;
  const double ratio = begun_px / ended_px;
  if (ratio < 0.7 || ratio > 1.4) return false;
  constexpr double kFarthest = 22.5;
  const PathEnd before = LastSamples(ended), after = FirstSamples(begun);
  return JoinPaths(before, after, GapBetween(before, after), std::max(ended_px, begun_px), physics).squares < kFarthest;
}

// Which tracklets go on as which.
class Continuations {
 public:
  Continuations(const std::vector<Tracklet>& tracklets, const MarkerPhysics& physics)
      : tracklets_(tracklets), after_(tracklets.size()), before_(tracklets.size()) {
    std::vector<double> radii_px;
    radii_px.reserve(tracklets.size());
    for (const Tracklet& tracklet : tracklets) radii_px.push_back(tracklet.RadiusPx());
    for (std::size_t a = 0; a < tracklets.size(); ++a)
      for (std::size_t b = 0; b < tracklets.size(); ++b)
        if (a != b && MayGoOnAs(tracklets[a], radii_px[a], tracklets[b], radii_px[b], physics)) {
          after_[a].push_back(b);
          before_[b].push_back(a);
        }
  }

  // The tracklet that this one certainly goes on as.
  std::optional<std::size_t> After(std::size_t a) const {
    if (after_[a].empty()) return std::nullopt;
    const std::size_t b =
        *std::ranges::min_element(after_[a], {}, [&](std::size_t next) { return tracklets_[next].FirstFrame(); });
    if (tracklets_[b].samples.front().time_s - tracklets_[a].samples.back().time_s > kLongest_s) return std::nullopt;
    return HasRival(a, before_[b]) || HasRival(b, after_[a]) ? std::nullopt : std::optional(b);
  }

  // The tracklet that certainly goes on as this one.
  std::optional<std::size_t> Before(std::size_t b) const {
    const auto found = std::ranges::find_if(before_[b], [&](std::size_t a) { return After(a) == b; });
    return found == before_[b].end() ? std::nullopt : std::optional(*found);
  }

 private:
  // Whether another could be it as well: one that was seen at the same time, so that they are two objects.
  bool HasRival(std::size_t tracklet, const std::vector<std::size_t>& others) const {
    return std::ranges::any_of(others, [&](std::size_t other) {
      return other != tracklet && tracklets_[other].FirstFrame() <= tracklets_[tracklet].LastFrame() &&
             tracklets_[tracklet].FirstFrame() <= tracklets_[other].LastFrame();
    });
  }

  const std::vector<Tracklet>& tracklets_;
  std::vector<std::vector<std::size_t>> after_, before_;
};

}  // namespace

std::vector<Tracklet> StitchPieces(std::vector<Tracklet> tracklets, const MarkerPhysics& physics) {
  std::vector<std::vector<std::size_t>> chains;
  {
    const Continuations continuations(tracklets, physics);
    for (std::size_t first = 0; first < tracklets.size(); ++first) {
      if (continuations.Before(first)) continue;
      chains.emplace_back();
      for (std::optional tracklet(first); tracklet; tracklet = continuations.After(*tracklet))
        chains.back().push_back(*tracklet);
    }
  }
  std::vector<Tracklet> whole;
  for (const std::vector<std::size_t>& chain : chains) {
    whole.push_back(std::move(tracklets[chain.front()]));
    for (const std::size_t tracklet : std::span(chain).subspan(1))
      whole.back().samples.insert(whole.back().samples.end(), tracklets[tracklet].samples.begin(),
                                  tracklets[tracklet].samples.end());
  }
  return whole;
}

}  // namespace lake::tracking
