// A marker's path as a random process: position, velocity and acceleration, driven by white jerk,
//
//     d³x/dt³ = w(t),   E w(t) w(s) = q δ(t − s),
//
// each axis by itself. Over a time T without a measurement the variance of position grows by q T⁵/20, of velocity by
// q T³/3, of acceleration by q T: what is predicted over a long gap is worth little, and contradicts nothing.
// Särkkä, Bayesian Filtering and Smoothing (2013), chapters 4 and 12; Bar-Shalom, Li & Kirubarajan, Estimation with
// Applications to Tracking and Navigation (2001), 6.2.3.
//
// The unit of length is the caller's (px or mm); times in s; q in unit²/s⁵.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace lake::dynamics {

// A measured place with its standard deviation per axis.
struct PathSample {
  double time_s = 0;
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  double sigma = 0;
};

// What is known of a path at one time: rows are position, velocity and acceleration, columns the axes, whose errors are
// independent and share one covariance.
struct PathState {
  Eigen::Matrix<double, 3, 2> mean = Eigen::Matrix<double, 3, 2>::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();

  Eigen::Vector2d Position() const { return mean.row(0); }
  Eigen::Vector2d Velocity() const { return mean.row(1); }
};

// What is known of a motion before anything is seen of it: standard deviations per axis.
struct MotionPrior {
  double speed = 0;         // unit/s
  double acceleration = 0;  // unit/s²
  double reach = 0;         // unit: from where it was, however long ago
};

PathState StartAt(const PathSample& sample, const MotionPrior& prior);

// The state `elapsed_s` later, or earlier if that is negative.
PathState Moved(const PathState& state, double elapsed_s, double density);

// What is known besides the path that leads to a state: it is within reach of where the marker was, as fast as it may
// be. Over a gap of some tenths of a second that is more.
PathState WithinReach(const PathState& state, const Eigen::Vector2d& was_at, const MotionPrior& prior);

// Takes a measurement at the state's own time in; returns the logarithm of the density that the state gave it.
double Observe(const PathSample& sample, PathState& state);

// A state, and the logarithm of the density of the samples that it comes from, given the first three, which set out the
// path.
struct PathEvidence {
  PathState state;
  double log_likelihood = 0;
};

// The state at `at_s` from samples in the order in which they follow one another there: all before it, or all after it
// and backward in time. Needs one sample.
PathEvidence EvidenceAt(std::span<const PathSample> samples, double at_s, double density, const MotionPrior& prior);

// The logarithm of the density that two states, each known from its own side, are those of one path `elapsed_s` apart.
double LogJoin(const PathState& before, const PathState& after, double elapsed_s, double density);

// How a recording's markers move and how much their measurements err, learnt from it.
struct LearntMotion {
  double density = 0;         // q of a quick movement: nine in ten of the windows in which something moves have less
  double extra_sigma = 0;     // what the samples' own sigmas leave out, per axis
  double log_likelihood = 0;  // of the windows, each of a density that is as frequent as it is in all
};

// By the marginal likelihood of windows of 0.6 s and 14 samples at least, at most 150 of them spread over the paths,
// over densities half a decade apart; the errors to 4 %. `unit_mm`: mm to a unit. All paths have increasing times.
LearntMotion LearnMotion(std::span<const std::vector<PathSample>> paths, double unit_mm);

// The prior of a person's marker: 1 m/s, 10 m/s², 0.5 m.
MotionPrior PersonPrior(double unit_mm);

}  // namespace lake::dynamics
