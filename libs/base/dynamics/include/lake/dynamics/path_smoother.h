// Smoothing of a marker's path: the white-jerk process of marker_path.h in every axis, seen with noise of which one
// part is white, one grows with the marker's speed, and one lasts from frame to frame,
//
//     y(t) = x(t) + √(w σ²(t) + b |ẋ(t)|²) e(t) + σ(t) o(t),
//
// e white with variance 1, o an Ornstein–Uhlenbeck process with variance ℓ and memory τ, σ the stated standard
// deviation. In films that are coded, the error stays while the picture does and changes as the marker moves over the
// pixels: o then forgets with the way too, exp(−Δt/τ − |ẋ|Δt/λ). Kalman filter and disturbance smoother: Durbin &
// Koopman, Time Series Analysis by State Space Methods (2012), 4.4–4.5; leave-one-out residuals: de Jong (1988),
// doi 10.1093/biomet/75.3.594. The jerk's density q, w, b and ℓ are those of the largest likelihood, by fixed-point
// steps: Wood & Fasiolo (2017), doi 10.1111/biom.12666.
//
// The unit of length is the caller's (px or mm); times in s; q in unit²/s⁵.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <span>
#include <vector>

#include "lake/dynamics/marker_path.h"

namespace lake::dynamics {

// A marker as it was seen. Coordinates beyond the first `axes` are 0.
struct SeenPath {
  int axes = 2;
  std::vector<double> time_s;          // of all frames, increasing
  std::vector<Eigen::Vector3d> place;  // per frame
  std::vector<double> sigma;           // stated, per axis; NaN: not seen in this frame

  bool IsSeen(std::size_t frame) const { return sigma[frame] > 0; }
  void See(std::size_t frame, const Eigen::Vector2d& at, double sigma_there, double across = 0) {
    place[frame] << at, across;
    sigma[frame] = sigma_there;
  }
};

// A path of which nothing is seen yet.
SeenPath UnseenPath(int axes, std::vector<double> time_s);

// How the marker moves and how its measurements err.
struct PathModel {
  std::vector<double> density;      // q, of the interval that ends at each frame; the first is not used
  double white = 1;                 // w
  double per_speed_s2 = 0;          // b
  double lasting = 0;               // ℓ
  double memory_s = 0.03;           // τ
  double memory_length = INFINITY;  // λ
  double not_averaged = 0;          // of σ²: lasting noise that smoothing does not take away
  double jitter = 0;                // of what the marker does from frame to frame, over σ²
  std::vector<double> speed2 = {};  // |ẋ|², per frame; where b > 0 or λ is finite

  // How much of what is seen beyond path and lasting noise is jitter.
  double OfJitter() const { return jitter / (jitter + white); }
  double SpeedNoise(std::size_t frame) const { return per_speed_s2 > 0 ? speed2[frame] : 0; }  // for b = 1
  // How much of the lasting noise is left after a time that ends at a frame.
  double Kept(std::size_t frame, double elapsed_s) const {
    const double speed = std::isfinite(memory_length) ? std::sqrt(speed2[frame]) : 0;
    return std::exp(-elapsed_s * (1 / memory_s + speed / memory_length));
  }
  // Of all that is not alike in the frames beside it.
  double WhiteVariance(std::size_t frame, double sigma) const {
    return (white + jitter) * sigma * sigma + per_speed_s2 * SpeedNoise(frame);
  }
};

struct PathPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero(), velocity = Eigen::Vector3d::Zero(),
                  acceleration = Eigen::Vector3d::Zero();
  Eigen::Matrix3d position_covariance = Eigen::Matrix3d::Zero();
  double velocity_variance = 0;  // per axis
};

struct SmoothedPath {
  std::vector<PathPoint> point;
  // Of each frame in which the marker is seen: its place less what all other frames predict, and that difference's
  // variance per axis.
  std::vector<Eigen::Vector3d> surprise;
  std::vector<double> surprise_variance;
};

SmoothedPath SmoothPath(const SeenPath& seen, const PathModel& model, const MotionPrior& prior);

// A distance to a point that is known in some frames: |x − other| = length + d(t), d a Matérn process (ν = 3/2) with a
// standard deviation and a memory. In the frames in which the marker is seen, d itself is known.
struct DistancePrior {
  std::vector<Eigen::Vector3d> other;              // per frame
  std::vector<Eigen::Matrix3d> other_covariance;   // per frame
  std::vector<double> deviation, deviation_sigma;  // d where the marker is seen, NaN elsewhere
  double length = 0, sigma = 0, memory_s = 0;
};

// As SmoothPath, of the frames [begin, end) alone, where the marker keeps its distances to other points in those frames
// in which it is not seen. Linearised about `near`, one per frame, which may be far off in angle but not on the wrong
// side; what the linearisation leaves out by its covariance widens the distances (second-order extended Kalman filter).
SmoothedPath BridgePath(const SeenPath& seen, const PathModel& model, const MotionPrior& prior,
                        std::span<const DistancePrior> distances, std::span<const PathPoint> near, std::size_t begin,
                        std::size_t end);

// What is known of the stated sigmas.
enum class SigmaTrust {
  kNone,   // they are guesses: w, b and ℓ are learnt
  kScale,  // their ratios hold, and they are not too large: w is learnt, ℓ is what white noise leaves of them
  kFull,   // they hold: w + ℓ = 1, and what scatters beyond them is movement, the marker's jitter
};

struct LearningOptions {
  double window_s = 0.1;      // q is alike over about this time to each side
  double common = 0.2;        // how many intervals' worth of the whole recording each window takes in
  double gap_memory_s = 0.1;  // a movement that is not seen goes on as it was for about this time
  int most_rounds = 40;       // of the fixed-point steps, for each memory
  double unit_mm = 1;         // the unit of length
  SigmaTrust trust = SigmaTrust::kNone;
  double lasting_share = 0;  // ℓ / (w + ℓ), at least; so much of σ² is in every place that is seen
};

// The models of paths of one recording, which have ℓ and τ in common. In a gap q rises to that of the quickest movement
// of all paths.
std::vector<PathModel> LearnPaths(std::span<const SeenPath> paths, const MotionPrior& prior,
                                  const LearningOptions& options);

// SmoothPath with what is learnt from the path alone.
SmoothedPath LearnAndSmooth(const SeenPath& seen, const MotionPrior& prior, const LearningOptions& options);

// A series through the smoother with a given cutoff: NaN where a value is NaN.
std::vector<double> LowPass(std::span<const double> time_s, std::span<const double> values, double cutoff_hz);

// q of the smoother with −3 dB at a cutoff: its gain is 1 / (1 + σ² Δt / q (2πf)⁶).
double DensityOfCutoff(double cutoff_hz, double sigma, double interval_s);
double CutoffOfDensity(double density, double sigma, double interval_s);

}  // namespace lake::dynamics
