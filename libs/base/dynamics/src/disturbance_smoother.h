// Kalman filter and disturbance smoother of a linear state-space model, and one axis of a marker's path as such a
// model. Not part of the interface.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

#include "lake/dynamics/path_smoother.h"
#include "white_jerk.h"

namespace lake::dynamics {

// A linear state-space model in frames: N states in columns that share the covariance, three of them, one where N is
// Eigen::Dynamic; then there are at most kMostStates.
inline constexpr int kMostStates = 16;

template <int N>
inline constexpr int kMost = N == Eigen::Dynamic ? kMostStates : N;
template <int N>
using State = Eigen::Matrix<double, N, 1, 0, kMost<N>, 1>;
template <int N>
using Square = Eigen::Matrix<double, N, N, 0, kMost<N>, kMost<N>>;
template <int N>
using Values = Eigen::Matrix<double, 1, N == Eigen::Dynamic ? 1 : 3>;
template <int N>
using Means = Eigen::Matrix<double, N, Values<N>::ColsAtCompileTime, 0, kMost<N>, Values<N>::ColsAtCompileTime>;

// One measurement h·x + noise.
template <int N>
struct Row {
  State<N> h;
  Values<N> value;
  double variance = 1;
  // By the filter:
  State<N> gain = {};
  Values<N> innovation = {};
  double innovation_variance = 1;
};

template <int N>
struct Frame {
  Means<N> mean;         // from this frame's measurements and those before
  Square<N> covariance;  // of that
  std::size_t first_row = 0, rows = 0;
  bool starts = false;  // anew, as nothing is known any more
};

// The disturbance smoother's r and N: of what all later measurements add.
template <int N>
struct Backward {
  Means<N> r;
  Square<N> n;
};

template <int N>
class Filter {
 public:
  // Columns that count: the others are 0.
  Filter(std::size_t frames, int states, int columns) : states_(states), columns_(columns), frames_(frames) {}

  std::vector<Row<N>> rows;  // sorted by frame
  Frame<N>& At(std::size_t frame) { return frames_[frame]; }

  // `advance(i, mean, covariance)` moves the state to frame i, or starts it anew.
  template <typename Advance>
  double Forward(const Advance& advance) {
    Means<N> mean = Means<N>::Zero(states_, Values<N>::ColsAtCompileTime);
    Square<N> covariance = Square<N>::Zero(states_, states_);
    double log_likelihood = 0;
    for (std::size_t i = 0; i < frames_.size(); ++i) {
      Frame<N>& frame = frames_[i];
      advance(i, mean, covariance);
      for (std::size_t k = frame.first_row; k < frame.first_row + frame.rows; ++k) {
        Row<N>& row = rows[k];
        const State<N> by = covariance * row.h;
        row.innovation_variance = row.h.dot(by) + row.variance;
        row.innovation = row.value - row.h.transpose() * mean;
        row.gain = by / row.innovation_variance;
        mean.noalias() += row.gain * row.innovation;
        covariance.noalias() -= row.gain * by.transpose();
        log_likelihood -= (row.innovation.squaredNorm() / row.innovation_variance +
                           columns_ * std::log(2 * std::numbers::pi * row.innovation_variance)) /
                          2;
      }
      frame.mean = mean;
      frame.covariance = covariance;
    }
    return log_likelihood;
  }

  // From the last frame to the first. `state_visit(i, backward)`: what later frames add to frame i's state;
  // `row_visit(i, u, D)`: the measurement's smoothed disturbance over its variance, and that one's own variance;
  // `step_visit(i, backward)`: the same for what frame i and later ones add to the state that is predicted for it.
  // `retreat(i, backward)` moves what is added from frame i to the one before.
  template <typename Retreat, typename StateVisit, typename RowVisit, typename StepVisit>
  void Back(const Retreat& retreat, const StateVisit& state_visit, const RowVisit& row_visit,
            const StepVisit& step_visit) {
    Backward<N> b{Means<N>::Zero(states_, Values<N>::ColsAtCompileTime), Square<N>::Zero(states_, states_)};
    for (std::size_t i = frames_.size(); i-- > 0;) {
      Frame<N>& frame = frames_[i];
      state_visit(i, b);
      for (std::size_t k = frame.first_row + frame.rows; k-- > frame.first_row;) {
        const Row<N>& row = rows[k];
        const State<N> g = b.n * row.gain;
        const Values<N> u = row.innovation / row.innovation_variance - row.gain.transpose() * b.r;
        const double d = 1 / row.innovation_variance + row.gain.dot(g);
        b.r.noalias() += row.h * u;
        b.n.noalias() -= row.h * g.transpose();
        b.n.noalias() -= g * row.h.transpose();
        b.n.noalias() += d * row.h * row.h.transpose();
        row_visit(i, u, d);
      }
      step_visit(i, b);
      if (frame.starts) {
        b.r.setZero();
        b.n.setZero();
      } else {
        retreat(i, b);
      }
    }
  }

 private:
  int states_, columns_;
  std::vector<Frame<N>> frames_;
};

// Position, velocity, acceleration and lasting noise of one axis.
inline constexpr int kAxisStates = 4;
enum { kPosition, kVelocity, kAcceleration, kLasting };

// What a time t does to an axis: x ← F x, F that of the jerk and of what is kept of the lasting noise; and the
// covariance that the jerk adds, for q = 1.
struct AxisStep {
  double t = 0, kept = 0;
  Eigen::Matrix3d jerk;

  AxisStep(double time_s, double lasting_kept) : t(time_s), kept(lasting_kept), jerk(JerkCovariance(time_s)) {}

  // F is nearly empty, so its products are written out: x ← F x, and x ← Fᵀ x.
  template <typename Matrix>
  void Apply(Matrix&& x) const {
    x.row(kPosition) += t * x.row(kVelocity) + t * t / 2 * x.row(kAcceleration);
    x.row(kVelocity) += t * x.row(kAcceleration);
    x.row(kLasting) *= kept;
  }
  template <typename Matrix>
  void ApplyTransposed(Matrix&& x) const {
    x.row(kAcceleration) += t * x.row(kVelocity) + t * t / 2 * x.row(kPosition);
    x.row(kVelocity) += t * x.row(kPosition);
    x.row(kLasting) *= kept;
  }
};

inline Eigen::Matrix4d StartCovariance(const PathModel& model, const MotionPrior& prior) {
  return Eigen::Vector4d(prior.reach * prior.reach, prior.speed * prior.speed, prior.acceleration * prior.acceleration,
                         model.lasting)
      .asDiagonal();
}

}  // namespace lake::dynamics
