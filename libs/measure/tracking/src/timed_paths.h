// The markers' paths beside a frame as evidence for when it was taken. Not part of the interface.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "lake/dynamics/marker_path.h"
#include "lake/motion/marker_recording.h"

namespace lake::tracking {

// How the markers go on from one frame to the next, told from the paths on either side. Every density of jerk, from a
// person's who rests to that of a heel set down, counts as much as the path itself makes it likely.
class Passage {
 public:
  std::size_t Markers() const { return markers_.size(); }

  // The logarithm of the density of the paths after it given those before it, if `elapsed_s` lie between the two
  // frames.
  double LogDensity(double elapsed_s) const;
  // The same if they have nothing to do with each other, as on both sides of a cut.
  double LogDensityOfCut(double elapsed_s) const;
  // By how much more likely one time is than another, of all markers but the `best` ones, which say so most: what moves
  // alone may have been left behind by the encoder, hip and waist are struck together by a seat. A logarithm.
  double LogRatioWithoutBest(double elapsed_s, double other_s, std::size_t best) const;
  // How far two markers at least are from where the paths before lead, if `elapsed_s` lie between the two frames; 0 of
  // fewer.
  double JumpMm(double elapsed_s) const;
  // How many markers are faster than this on both sides, px/s.
  int Faster(double least_px_s) const;

 private:
  friend class TimedPaths;
  struct Hypothesis {
    double log_weight = 0, density = 0;
    dynamics::PathState before, after;
  };
  using Marker = std::vector<Hypothesis>;  // one for each density

  double LogDensity(const Marker& marker, double elapsed_s, double unrelated) const;
  double LogDensity(double elapsed_s, double unrelated) const;  // that share of markers is something else afterwards

  std::vector<Marker> markers_;
  double log_unrelated_ = 0;
  double unit_mm_ = 0;  // of a px
  dynamics::MotionPrior prior_;
};

// How late (negative: early) a frame's time is, by all markers' paths through its neighbours.
struct Lateness {
  double late_s = 0, sigma_s = 0;
  double across = 0;  // squared distances from the paths across them, which no time explains, over their variances
};

// Frames by their place in a recording; `frames`: those that are new, in order. Times may change in the meantime.
class TimedPaths {
 public:
  // Learns from these frames how the markers move.
  TimedPaths(const motion::MarkerRecording& recording, const std::vector<std::size_t>& frames);

  // Between frames[after − 1] and frames[after], by what is seen from frames[from] to frames[to − 1].
  Passage Between(const std::vector<std::size_t>& frames, std::size_t after, std::size_t from, std::size_t to) const;

  // The squared distance of the same paths in standard deviations, for a quick movement, over its expectation; 0 where
  // nothing is seen on both sides.
  double Misfit(const std::vector<std::size_t>& frames, std::size_t after, std::size_t from, std::size_t to) const;

  // nullopt where fewer than two markers are seen on both sides or nothing moves.
  std::optional<Lateness> LatenessOf(const std::vector<std::size_t>& frames, std::size_t at) const;

  // frames[first] to frames[end − 1] show hardly anything else than the one before: the logarithm of the odds that they
  // repeat it, against that everything rested. `frame_s`: the usual time between frames.
  double LogOddsOfRepeat(const std::vector<std::size_t>& frames, std::size_t first, std::size_t end,
                         double frame_s) const;

  // The logarithm of the likelihood of the paths at these times, one per frame of the recording, all moving as quickly
  // as they were learnt to at the frames' times: quick, for the choice among many hypotheses.
  double LogLikelihoodQuickly(const std::vector<std::size_t>& frames, const std::vector<double>& time_s) const;

  // The same, of how they move if these are the times; without times: as they were learnt.
  double LogLikelihood() const { return learnt_.log_likelihood; }
  double LogLikelihood(const std::vector<std::size_t>& frames, const std::vector<double>& time_s) const;

 private:
  std::vector<std::vector<dynamics::PathSample>> PathsAt(const std::vector<std::size_t>& frames,
                                                         const std::vector<double>& time_s) const;
  struct Sides {
    std::vector<dynamics::PathSample> before, after;  // each the farthest first
  };
  std::optional<Sides> SidesOf(const motion::MarkerTrack& marker, const std::vector<std::size_t>& frames,
                               std::size_t after, std::size_t from, std::size_t to) const;
  std::vector<dynamics::PathSample> Beside(const motion::MarkerTrack& marker, const std::vector<std::size_t>& frames,
                                           std::ptrdiff_t nearest, std::ptrdiff_t end, int direction) const;
  // A marker before, in and behind a run of frames; `behind`: the nearest first.
  struct MarkerRun {
    std::vector<dynamics::PathSample> before, run, behind;
    double log_copied = 0;        // density of the run's samples if its pictures are copies of the one before
    double run_s = 0, end_s = 0;  // from the frame before to the run's first, and when its last was taken
  };
  // Of a run of frames and what follows, the logarithms of the densities if the run repeats a picture while time goes
  // on or stands, or if the markers rest in it and go on from there, or are elsewhere after a cut.
  struct RunLogs {
    double going_on = 0, standing = 0, rested = 0, cut = 0;
  };
  dynamics::PathState AtRest(const dynamics::PathSample& last, double frame_s, double beginning) const;
  std::optional<MarkerRun> RunOf(const motion::MarkerTrack& marker, const std::vector<std::size_t>& frames,
                                 std::size_t first, std::size_t end) const;
  double LogDensityOfStart(const MarkerRun& seen, double density) const;
  RunLogs LogsAt(const MarkerRun& seen, double density, double stood_s) const;
  std::optional<RunLogs> LogsOfRun(const motion::MarkerTrack& marker, const std::vector<std::size_t>& frames,
                                   std::size_t first, std::size_t end, double stood_s) const;

  const motion::MarkerRecording& recording_;
  double unit_mm_;  // of a px
  dynamics::LearntMotion learnt_;
  dynamics::MotionPrior prior_;
};

}  // namespace lake::tracking
