// Names for what was followed, out of what has been seen so far.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/tracking/live_tracker.h"
#include "lake/tracking/naming.h"

namespace lake::tracking {

using Eigen::Vector2d;

namespace {

// The last place of each marker that was measured.
std::vector<MarkerSeed> LastPlaces(const motion::MarkerRecording& named) {
  std::vector<MarkerSeed> places;
  for (const motion::MarkerTrack& track : named.markers)
    for (std::size_t i = named.Frames(); i-- > 0;)
      if (track.samples[i].IsKnown()) {
        places.push_back({.name = track.name, .position = track.samples[i].position, .frame = named.frame[i]});
        break;
      }
  return places;
}

// Where an object is in the shank's frame, metric units of length, in each frame that shows it with ankle and knee: x
// across, y along it from the knee; and how the shank stands, rad.
struct InShank {
  std::vector<double> across, along, shank, direction_rad;
};

InShank PlacesInShank(const Tracklet& tracklet, const motion::MarkerRecording& leg, const LiveTrackOptions& options) {
  const motion::MarkerTrack &ankle = *leg.Find("ankle"), &knee = *leg.Find("knee");
  InShank places;
  for (const TrackletSample& sample : tracklet.samples) {
    const auto found = std::ranges::lower_bound(leg.frame, sample.frame);
    if (sample.frame < options.others_since || found == leg.frame.end() || *found != sample.frame) continue;
    const auto row = static_cast<std::size_t>(found - leg.frame.begin());
    if (!ankle.samples[row].IsKnown() || !knee.samples[row].IsKnown()) continue;
    const Vector2d foot = options.metric_from_px(ankle.samples[row].position),
                   joint = options.metric_from_px(knee.samples[row].position),
                   place = options.metric_from_px(sample.position);
    const Vector2d up = (joint - foot).normalized();
    places.along.push_back((place - joint).dot(up));
    places.across.push_back((place - joint).dot(Vector2d(up.y(), -up.x())));
    places.shank.push_back((joint - foot).norm());
    places.direction_rad.push_back(std::atan2(up.x(), up.y()));
  }
  return places;
}

// The one object beside the knee that moves with the shank and is none of the leg's markers: where it was seen last, as
// it may have been lost and found.
MarkerSeed BesideKnee(const LiveSnapshot& snapshot, const motion::MarkerRecording& leg, const std::string& name,
                      const LiveTrackOptions& options) {
  // A joint that is strapped to the leg slips by some millimetres of a shank of 400; a lamp moves by a third of it.
  constexpr double kFarthest = 0.4, kSteady = 0.02;
  constexpr double kTurned_rad = 0.1;  // in a rise it turns by 0.3 and more; while it rests, a lamp is steady as well
  constexpr std::size_t kFewest = 20;  // frames
  std::vector<const Tracklet*> found;
  bool is_one = true;
  for (const Tracklet& tracklet : snapshot.tracklets) {
    const InShank in_shank = PlacesInShank(tracklet, leg, options);
    if (in_shank.along.size() < kFewest) continue;
    const auto [least, most] = std::ranges::minmax(in_shank.direction_rad);
    if (most - least < kTurned_rad) continue;
    const double shank = Median(in_shank.shank), along = Median(in_shank.along), across = Median(in_shank.across);
    const double away = std::hypot(along, across);
    const bool is_knee = away < 1e-3 * shank;
    const bool is_steady =
        std::max(RobustDeviation(in_shank.along), RobustDeviation(in_shank.across)) < kSteady * shank;
    if (is_knee || !is_steady || away >= kFarthest * shank) continue;
    for (const Tracklet* other : found) is_one = is_one && other->LastFrame() < tracklet.FirstFrame();
    found.push_back(&tracklet);
  }
  if (found.empty() || !is_one)
    throw Fail("{}: {} detections beside the knee move with the shank; click the right one", name,
               found.empty() ? "no" : std::to_string(found.size()));
  const TrackletSample& last = found.back()->samples.back();
  return {.name = name, .position = last.position, .frame = last.frame};
}

// Whoever has not moved yet may be anything.
void CheckHasMoved(const motion::MarkerRecording& leg, const LiveTrackOptions& options) {
  constexpr double kEnough = 0.4;  // of the thigh, by which a hip rises
  Eigen::AlignedBox2d reach;
  double thigh = 0;
  const motion::MarkerTrack &knee = *leg.Find("knee"), &hip = *leg.Find("hip");
  for (std::size_t i = 0; i < leg.Frames(); ++i) {
    if (!hip.samples[i].IsKnown()) continue;
    const Vector2d place = options.metric_from_px(hip.samples[i].position);
    reach.extend(place);
    if (knee.samples[i].IsKnown()) thigh = (place - options.metric_from_px(knee.samples[i].position)).norm();
  }
  if (reach.isEmpty() || reach.diagonal().norm() < kEnough * thigh)
    throw Error("the subject has hardly moved yet: stand up and sit down once");
}

}  // namespace

std::vector<MarkerSeed> FindNames(const LiveSnapshot& snapshot, const LiveTrackOptions& options) {
  NamingOptions naming{.names = {},
                       .seeds = {},
                       .identities = {},
                       .metric_from_px = options.metric_from_px,
                       .up_px = options.up_px,
                       .physics = options.physics,
                       .discontinuities = snapshot.discontinuities,
                       .repeated = snapshot.repeated};
  std::vector<std::string> others;
  for (const std::string& name : options.names) {
    const bool is_leg = std::ranges::find(kLegMarkers, name) != kLegMarkers.end();
    const auto seed = std::ranges::find(options.seeds, name, &MarkerSeed::name);
    if (is_leg || seed != options.seeds.end())
      naming.names.push_back(name);
    else
      others.push_back(name);
    if (seed != options.seeds.end()) naming.seeds.push_back(*seed);
  }
  if (others.size() > 1) throw Fail("it is not clear which detections are {}; click them", fmt::join(others, ", "));
  motion::MarkerRecording named = snapshot.frames;
  NameTracklets(snapshot.tracklets, naming, named);
  CheckHasMoved(named, options);
  std::vector<MarkerSeed> places = LastPlaces(named);
  if (!others.empty()) places.push_back(BesideKnee(snapshot, named, others.front(), options));
  return places;
}

}  // namespace lake::tracking
