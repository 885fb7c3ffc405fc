// The markers' paths as evidence for when frames were taken. Not part of the interface.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "lake/dynamics/marker_path.h"
#include "lake/motion/marker_recording.h"

namespace lake::tracking {

double LogSum(const std::vector<double>& logs);  // of the exponentials

// What lies between two frames, and frames between them that may repeat the first. Each density of jerk, from a
// person's who rests to that of a heel set down, counts as much as the paths make it likely.
class Interval {
 public:
  // Logarithms of the densities of what is seen in and behind the interval given the paths before, if the frames in
  // between are copies and so much time passed over all,
  double LogIfCopied(double elapsed_s) const;
  // if they are new, and so much time passed since the last of them,
  double LogIfNew(double elapsed_s) const;
  // and if the paths behind have nothing to do with those before.
  double LogIfCut(double elapsed_s) const;

  std::size_t Markers() const { return markers_.size(); }
  // By how much more likely one time is than another, of all markers but the `best` ones, which say so most: what moves
  // alone may have been left behind by the encoder, hip and waist are struck together by a seat. A logarithm.
  double LogRatioWithoutBest(double elapsed_s, double other_s, std::size_t best) const;
  // How far two markers at least are from where the paths before lead; 0 of fewer.
  double JumpMm(double elapsed_s) const;
  // How many markers are faster than this on both sides, px/s.
  int Faster(double least_px_s) const;

 private:
  friend class TimedPaths;
  // From the last state before to the first behind.
  struct Way {
    double log_weight = 0, density = 0;
    dynamics::PathState before, behind;
  };
  using Ways = std::vector<Way>;
  struct Marker {
    Ways copied, is_new;
  };

  double Log(const Ways& ways, double elapsed_s, double unrelated) const;
  double LogOfAll(Ways Marker::*ways, double elapsed_s, double unrelated) const;

  std::vector<Marker> markers_;
  double log_unrelated_ = 0, sudden_share_ = 0;
  double unit_mm_ = 0;  // of a px
  dynamics::MotionPrior prior_;
};

// How late (negative: early) a frame was taken, by all markers' paths through the others.
struct Lateness {
  double late_s = 0, sigma_s = 0;
  double across = 0;  // squared distances from the paths across them, which no time explains, over their variances
};

// The paths through those frames of a recording that show something new; they are counted by their place among these.
// The recording's times may change in the meantime.
class TimedPaths {
 public:
  // Learns from these frames how the markers move.
  TimedPaths(const motion::MarkerRecording& recording, std::vector<std::size_t> frames);

  std::size_t Frames() const { return frames_.size(); }
  std::size_t FrameAt(std::size_t at) const { return frames_[at]; }
  double TimeAt(std::size_t at) const { return recording_.time_s[frames_[at]]; }
  double UsualInterval() const;

  // No path leads from the frame before this one to it.
  void Cut(std::size_t at) { is_cut_[at] = true; }
  bool IsCut(std::size_t at) const { return is_cut_[at]; }

  // From frame `first` − 1 to frame `end`, with those in between.
  Interval Between(std::size_t first, std::size_t end) const;

  // The squared distance of the paths before this frame from those that begin there, in standard deviations for a quick
  // movement, over its expectation; 0 where nothing is seen on both sides.
  double Misfit(std::size_t at) const;

  // Of all frames; nullopt where fewer than two markers are seen or nothing moves.
  std::vector<std::optional<Lateness>> LatenessOfAll() const;

  // The logarithm of the likelihood of the paths at these times, one per frame of the recording, all moving as quickly
  // as they were learnt to at the recording's times: quick, for the choice among many hypotheses.
  double LogLikelihoodQuickly(const std::vector<double>& time_s) const;

  // The same, of how they move if these are the times; without times: as they were learnt.
  double LogLikelihood() const { return learnt_.log_likelihood; }
  double LogLikelihood(const std::vector<double>& time_s) const;

 private:
  std::vector<double> Times() const;
  std::vector<std::vector<dynamics::PathSample>> PathsAt(const std::vector<double>& time_s) const;
  std::vector<dynamics::PathSample> Beside(const motion::MarkerTrack& marker, std::size_t nearest, int step) const;
  std::optional<Interval::Marker> MarkerBetween(const motion::MarkerTrack& track, std::size_t first,
                                                std::size_t end) const;

  const motion::MarkerRecording& recording_;
  std::vector<std::size_t> frames_;
  std::vector<bool> is_cut_;
  double unit_mm_;  // of a px
  dynamics::LearntMotion learnt_;
  dynamics::MotionPrior prior_;
};

}  // namespace lake::tracking
