#include "lake/tracking/candidates.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "lake/core/statistics.h"

namespace lake::tracking {
namespace {

constexpr std::size_t kLeastSamples = 12, kMost = 99;

// More than noise, and than what a lamp's flicker or a person who leans on the tripod makes of it.
bool Moves(const Tracklet& tracklet) {
  return TrimmedExtentPx(tracklet) > std::max(2.0, 0.5 * tracklet.RadiusPx());
}

// The frame in which most of these are seen; the first of several.
std::int64_t FrameOfMost(const std::vector<const Tracklet*>& tracklets) {
  std::map<std::int64_t, int> seen;
  for (const Tracklet* tracklet : tracklets)
    for (const TrackletSample& sample : tracklet->samples) ++seen[sample.frame];
  const auto most = std::max_element(seen.begin(), seen.end(), [](const auto& a, const auto& b) {
    return std::tuple(a.second, -a.first) < std::tuple(b.second, -b.first);
  });
  return most == seen.end() ? 0 : most->first;
}

Candidate MakeCandidate(const Tracklet& tracklet, int id, std::int64_t frame) {
  const auto nearest = std::min_element(
      tracklet.samples.begin(), tracklet.samples.end(), [&](const TrackletSample& a, const TrackletSample& b) {
        return std::tuple(std::abs(a.frame - frame), a.frame) < std::tuple(std::abs(b.frame - frame), b.frame);
      });
  Candidate candidate{id,
                      nearest->frame,
                      nearest->position,
                      nearest->radius_px,
                      tracklet.FirstFrame(),
                      tracklet.LastFrame(),
                      Moves(tracklet),
                      {}};
  for (const TrackletSample& sample : tracklet.samples) candidate.path.push_back(sample.position);
  return candidate;
}

}  // namespace

double TrimmedExtentPx(const Tracklet& tracklet) {
  constexpr double kEnd = 0.02;
  std::vector<double> x, y;
  for (const TrackletSample& sample : tracklet.samples) {
    x.push_back(sample.position.x());
    y.push_back(sample.position.y());
  }
  const auto range = [](const std::vector<double>& values) {
    return Quantile(values, 1 - kEnd) - Quantile(values, kEnd);
  };
  return std::hypot(range(x), range(y));
}

CandidateList ListCandidates(const std::vector<Tracklet>& tracklets) {
  struct Entry {
    const Tracklet* tracklet;
    bool moves;
  };
  std::vector<Entry> entries;
  for (const Tracklet& tracklet : tracklets)
    if (tracklet.samples.size() >= kLeastSamples) entries.push_back({&tracklet, Moves(tracklet)});
  std::stable_sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return std::tuple(b.moves, b.tracklet->samples.size()) < std::tuple(a.moves, a.tracklet->samples.size());
  });
  entries.resize(std::min(entries.size(), kMost));
  std::vector<const Tracklet*> moving, all;
  for (const Entry& entry : entries) {
    all.push_back(entry.tracklet);
    if (entry.moves) moving.push_back(entry.tracklet);
  }
  CandidateList list;
  list.frame = FrameOfMost(moving.empty() ? all : moving);
  for (const Tracklet* tracklet : all)
    list.candidates.push_back(MakeCandidate(*tracklet, static_cast<int>(list.candidates.size()) + 1, list.frame));
  return list;
}

}  // namespace lake::tracking
