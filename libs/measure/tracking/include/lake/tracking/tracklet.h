// Detections of one thing over successive frames, as far as that is certain: when it is lost for long, the tracklet
// ends, and what appears later is another until naming joins them.
#pragma once

#include <cstdint>
#include <vector>

#include "lake/tracking/marker_detector.h"
#include "lake/tracking/marker_physics.h"

namespace lake::tracking {

struct TrackletSample {
  std::int64_t frame = 0;
  double time_s = 0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  // px
  double sigma_px = 0;
  double radius_px = 0;  // apparent
  double amplitude = 0;
  double quality = 0;  // as in MarkerDetection
};

struct Tracklet {
  std::vector<TrackletSample> samples;  // frames increase; gaps of a few frames are possible
  std::optional<int> identity;

  std::int64_t FirstFrame() const { return samples.front().frame; }
  std::int64_t LastFrame() const { return samples.back().frame; }
  const TrackletSample* SampleIn(std::int64_t frame) const;  // nullptr if not seen in that frame
  double ExtentPx() const;                                   // diagonal of the box that holds all positions
};

// Where a thing that matters certainly is, in px of a frame.
struct TrackletSeed {
  std::int64_t frame = 0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
};

struct TrackletOptions {
  MarkerPhysics physics;
  // What begins here may be fast: it is looked for far and wide until its velocity is known.
  std::vector<TrackletSeed> seeds;
  double max_coast_s = 0.1;     // lost for longer: the tracklet ends …
  double max_coast_frames = 3;  // … but not before so many frames
  int min_samples = 4;          // shorter ones are chance
  std::size_t max_live = 96;    // things followed at once, besides seeded ones; the most contrasted come first
  int search_interval = 6;      // frames between searches of the whole picture …
  int urgent_interval = 2;      // … and after something well established was lost, …
  double urgent_s = 0.6;        // … for this long
  int established = 30;         // samples
};

// Follows everything that the detector sees. Feed frames in order; memory grows with what is found, not with the
// pictures.
class TrackletBuilder {
 public:
  TrackletBuilder(MarkerDetector& detector, const TrackletOptions& options) : detector_(detector), options_(options) {}

  void Add(const video::VideoFrame& frame);

  // All tracklets, in order of their first frame. Call once, after the last frame.
  std::vector<Tracklet> Finish();

 private:
  struct Live {
    Tracklet tracklet;
    Blob appearance;
    double quality = 0;
    double seen_s = 0;    // time of the last detection
    bool seeded = false;  // began at a seed

    bool IsFastStart() const { return seeded && tracklet.samples.size() < 3; }
  };
  MarkerPrediction Predict(const Live& live, double time_s, double frame_s) const;
  bool SearchEverywhere(const video::VideoFrame& frame) const;
  bool IsSeed(std::int64_t frame, const MarkerDetection& detection) const;
  void Associate(const video::VideoFrame& frame, std::span<const MarkerPrediction> predictions,
                 std::vector<MarkerDetection> detections);
  bool MakePlaceFor(const MarkerDetection& detection);
  void RetireLost(double time_s);
  void Keep(Tracklet tracklet);
  static void Extend(Live& live, const video::VideoFrame& frame, const MarkerDetection& detection);

  MarkerDetector& detector_;
  TrackletOptions options_;
  std::vector<Live> live_;
  std::vector<Tracklet> finished_;
  std::vector<Eigen::Vector2d> evicted_;  // where things rested that were given up for others
  std::int64_t frames_seen_ = 0;
  double previous_time_s_ = 0, frame_s_ = 0;
  std::optional<double> last_loss_s_;
};

}  // namespace lake::tracking
