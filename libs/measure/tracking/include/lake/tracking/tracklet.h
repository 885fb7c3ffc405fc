// Detections of one object over successive frames, as far as that is certain: when it is lost for long, the tracklet
// ends, and what appears later is another until naming joins them.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "lake/tracking/marker_detector.h"
#include "lake/tracking/marker_physics.h"

namespace lake::tracking {

struct TrackletSample {
  std::int64_t frame = 0;
  double time_s = 0;                                   // as stamped, less what time stood still before
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  // px
  double sigma_px = 0;
  double radius_px = 0;                  // apparent
  double amplitude = 0, background = 0;  // grey levels, as in MarkerDetection
  double quality = 0;                    // likewise
  bool repeated = false;                 // in a picture that is the one before it once more: no measurement of its own
};

struct Tracklet {
  std::vector<TrackletSample> samples;  // frames increase; gaps of a few frames are possible
  std::optional<int> identity;

  std::int64_t FirstFrame() const { return samples.front().frame; }
  std::int64_t LastFrame() const { return samples.back().frame; }
  const TrackletSample* SampleIn(std::int64_t frame) const;  // nullptr if not seen in that frame
  double RadiusPx() const;                                   // median: a streak at an end looks larger
};

// Where an object that matters certainly is, in px of a frame.
struct TrackletSeed {
  std::int64_t frame = 0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
};

struct TrackletOptions {
  MarkerPhysics physics;
  // What begins here may be fast: it is looked for far and wide until its velocity is known.
  std::vector<TrackletSeed> seeds;
  double max_coast_s = 0.1;             // lost for longer: the tracklet ends …
  double max_coast_frames = 3;          // … but not before so many frames
  int min_samples = 4;                  // shorter ones are chance
  std::size_t max_live = 96;            // objects followed at once, besides seeded ones; the most contrasted come first
  int followed = 8;                     // samples; what has so many may look otherwise where it was missed
  double search_interval_s = 0.1;       // between searches of the whole picture …
  double urgent_interval_s = 1.0 / 30;  // … and after something well established was lost, …
  double urgent_s = 0.6;                // … for this long
  int established = 30;                 // samples
  double look_back_s = 0;               // what is found late is followed back in time, as far as this; 0: not
};

struct ExpectedStep;

// Follows everything that the detector sees. Feed frames in order; memory grows with what is found, not with the
// pictures, of which the last 48 MB are kept at most.
class TrackletBuilder {
 public:
  TrackletBuilder(MarkerDetector& detector, const TrackletOptions& options) : detector_(detector), options_(options) {}

  void Add(const video::VideoFrame& frame);

  // What is followed at the moment, each with a number that stays its own. Valid until the next frame.
  struct Followed {
    std::int64_t number;
    const Tracklet* tracklet;
  };
  std::vector<Followed> AllFollowed() const;
  // What has ended. Valid until the next frame.
  std::span<const Tracklet> Ended() const { return finished_; }

  // What Finish() would return if the last frame were the last of all.
  std::vector<Tracklet> SoFar() const;

  // All tracklets, in order of their first frame. Call once, after the last frame.
  std::vector<Tracklet> Finish();

  // Frames whose picture is the one before it once more while objects should have moved, increasing.
  const std::vector<std::int64_t>& RepeatedFrames() const { return repeated_; }

  // Frames in which most of what was moving was not where it was expected, all at once: the subject may be elsewhere.
  const std::vector<std::int64_t>& Discontinuities() const { return discontinuities_; }

 private:
  struct Live {
    Tracklet tracklet;
    Blob appearance;
    double quality = 0;
    double seen_s = 0;    // time of the last detection
    bool seeded = false;  // began at a seed
    std::int64_t number = 0;
    bool was_followed_back = false;

    bool IsFastStart() const { return seeded && tracklet.samples.size() < 3; }
  };
  MarkerPrediction Predict(const Live& live, double time_s, double frame_s) const;
  std::vector<MarkerPrediction> PredictAll(double time_s) const;
  std::vector<ExpectedStep> ExpectedSteps(std::span<const MarkerPrediction> predictions) const;
  void NoteInterval(double interval_s);
  bool HasCrept() const;
  bool StoodStill(const video::VideoFrame& frame, std::span<const MarkerPrediction> predictions) const;
  void NoteRepeated(std::int64_t frame);
  bool IsConfirmed(std::int64_t frame) const;
  void SetTimeBack(const video::VideoFrame& frame, double stood_still_s);
  std::int64_t TakeBackRepeated();
  void JudgeStanding(std::int64_t frame);
  void NoteBreak(std::int64_t frame, std::span<const MarkerPrediction> predictions);
  bool SearchEverywhere(std::int64_t frame) const;
  bool IsSeed(std::int64_t frame, const MarkerDetection& detection) const;
  void Associate(std::int64_t frame, std::span<const MarkerPrediction> predictions,
                 std::vector<MarkerDetection> detections);
  bool MakePlaceFor(const MarkerDetection& detection);
  double CoastS() const;  // how long an object may be lost before its tracklet ends
  void RetireLost();
  void Keep(Tracklet tracklet);
  std::optional<Tracklet> Judged(Tracklet tracklet) const;
  static void Extend(Live& live, const TrackletSample& when, const MarkerDetection& detection);
  void Remember(const video::VideoFrame& frame);
  bool IsNearAnother(const Live& live, std::int64_t frame, const Eigen::Vector2d& place) const;
  void FollowBack(Live& live);

  MarkerDetector& detector_;
  TrackletOptions options_;
  std::vector<Live> live_;
  std::vector<Tracklet> finished_;
  std::vector<Eigen::Vector2d> evicted_;  // where objects rested that were given up for others
  std::int64_t frames_seen_ = 0, last_number_ = 0;
  double frame_s_ = 0;  // between frames, usually; 0: not known yet
  // The frame at work: its time, as in TrackletSample.
  double time_s_ = 0;
  bool is_repeated_ = false;
  double stood_still_s_ = 0;  // in all
  // Frames before it that objects are followed back into, with their times.
  std::deque<std::pair<video::VideoFrame, double>> remembered_;
  video::VideoFrame previous_;  // its luma is compared with the next one's
  double repeated_since_s_ = 0;
  std::optional<std::int64_t> stands_since_;  // frame: all came to rest at once in it, or the picture froze
  std::vector<std::int64_t> repeated_, discontinuities_;
  std::optional<double> last_loss_s_;
};

}  // namespace lake::tracking
