// Markers followed, named and filtered while the frames come: what is known of each frame at its own time, from it and
// those before it.
//
// Detection and following are TrackMarkers' own. A position is that of a Kalman filter under white jerk
// (lake::dynamics) and has the filter's standard deviation; nothing later changes it. Names are given once, by a place
// or by FindNames; a marker that was lost gets its name back where its distances to the others, and the way that it can
// have come, leave one tracklet alone for it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lake/dynamics/marker_path.h"
#include "lake/motion/marker_recording.h"
#include "lake/tracking/marker_detector.h"
#include "lake/tracking/marker_physics.h"
#include "lake/tracking/tracklet.h"
#include "lake/video/video_reader.h"

namespace lake::tracking {

struct LiveTrackOptions {
  std::vector<std::string> names;
  std::vector<MarkerSeed> seeds;  // places; numbers of candidates are not known yet
  Polarity polarity = Polarity::kBright;
  cv::Rect crop;  // px; empty: the whole picture
  // May throw Error for a place that has none there; what is seen at such a place is followed, and its distances to
  // others are not known.
  std::function<Eigen::Vector2d(const Eigen::Vector2d&)> metric_from_px = [](const Eigen::Vector2d& px) { return px; };
  Eigen::Vector2d up_px = {0, -1};
  double mm_per_px = 1;  // about; how quickly the filter follows rests on it
  MarkerPhysics physics;
  std::int64_t others_since = 0;  // frame: what is no marker of the leg may have been put elsewhere before it
};

// Something bright in the last frame.
struct LiveSpot {
  std::int64_t number = 0;  // its own as long as it is followed
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double radius_px = 0;
  std::string name;  // empty: none
};

// All that was followed so far, for FindNames.
struct LiveSnapshot {
  std::vector<Tracklet> tracklets;
  motion::MarkerRecording frames;  // numbers and times, without markers
  std::vector<std::int64_t> discontinuities, repeated;
};

class LiveTracker {
 public:
  LiveTracker(LiveTrackOptions options, const video::VideoInfo& video);

  // In order; time stamps increase. A seed that points at nothing gives no name: WhyNoSeed.
  void Add(const video::VideoFrame& frame);

  std::vector<LiveSpot> Spots() const;
  bool HasAllNames() const;  // every name was given once
  bool IsAnyLost() const;  // a name has had no tracklet for so long that Rejoining has no way back to it, or never one

  // Of a name that no tracklet has had yet: why its seed gave it none; else empty.
  std::string WhyNoSeed() const;

  // The tracklet at a place of the last frame. Throws Error where there is none, or no such name.
  void Name(std::string_view name, const Eigen::Vector2d& place_px);
  // Those at the places that FindNames found, for names that have no tracklet; one that has ended meanwhile only for a
  // name that no tracklet has had yet.
  void TakeNames(const std::vector<MarkerSeed>& found);

  // Until the next frame. One sample per frame and name, in px: what was reported at each frame's own time (detected:
  // from a measurement; filled: foretold, for a tenth of a second at most), and the measurements alone with the fits'
  // sigmas, also those from before a tracklet had its name.
  const motion::MarkerRecording& Reported() const { return reported_; }
  const motion::MarkerRecording& Measured() const { return measured_; }

  LiveSnapshot Snapshot() const;
  // Of what is named and the last `samples` of each.
  std::vector<Tracklet> Named(std::size_t samples) const;
  std::optional<ImageFigures> Figures() const { return detector_->Figures(); }
  std::size_t RepeatedFrames() const { return builder_->RepeatedFrames().size(); }

 private:
  // Of the distance between two markers.
  struct Distance {
    int count = 0;
    double mean = 0, squares = 0;
    bool IsRigid() const;
  };
  struct Filter {
    std::optional<dynamics::PathState> state;
    double time_s = 0, seen_s = 0;
  };
  struct Rejoining;

  const Tracklet* TrackletOf(std::size_t name) const;
  const TrackletSample* SeenNow(std::size_t name) const;
  std::optional<Eigen::Vector2d> MetricOf(const Eigen::Vector2d& px) const;
  std::optional<TrackletBuilder::Followed> FollowedAt(const MarkerSeed& place, bool may_have_ended) const;
  void Give(std::size_t name, const TrackletBuilder::Followed& followed);
  void ForgetDistances(std::size_t name);
  void TakeSeeds(std::int64_t frame);
  void Rejoin();
  void LearnDistances();
  void FilterAll(double time_s);
  std::size_t IndexOf(std::string_view name) const;

  LiveTrackOptions options_;
  double sigma_factor_ = 1;  // of the fits' sigmas, for what the codec does
  std::unique_ptr<MarkerDetector> detector_;
  std::unique_ptr<TrackletBuilder> builder_;
  std::vector<std::optional<std::int64_t>> number_;  // number, by name
  std::vector<std::string> why_no_seed_;             // by name
  std::vector<std::optional<Eigen::Vector2d>> last_place_px_;
  std::map<std::pair<std::size_t, std::size_t>, Distance> distances_;  // by names, the lesser first
  std::vector<Filter> filters_;
  motion::MarkerRecording reported_, measured_;
};

// Where each marker is, in a frame in which it was seen: the leg's by NameTracklets, others by their seeds, and one
// more as the tracklet beside the knee that moves with the shank. Long enough to be done in another thread. Throws
// Error saying what is missing.
std::vector<MarkerSeed> FindNames(const LiveSnapshot& snapshot, const LiveTrackOptions& options);

}  // namespace lake::tracking
