#include <algorithm>
#include <cmath>

#include "disturbance_smoother.h"
#include "lake/dynamics/path_smoother.h"

namespace lake::dynamics {
namespace {

// The states of a bridge: four of each axis, then two of each distance's deviation (its value and its speed).
struct BridgeLayout {
  int axes, distances;
  int States() const { return kAxisStates * axes + 2 * distances; }
  int Axis(int axis, int part) const { return kAxisStates * axis + part; }
  int Deviation(int distance) const { return kAxisStates * axes + 2 * distance; }
};

using BridgeFilter = Filter<Eigen::Dynamic>;
using BridgeState = State<Eigen::Dynamic>;
using BridgeSquare = Square<Eigen::Dynamic>;

Row<Eigen::Dynamic> OneRow(const BridgeLayout& layout, double value, double variance) {
  Row<Eigen::Dynamic> row;
  row.h = BridgeState::Zero(layout.States());
  row.value = Values<Eigen::Dynamic>(value);
  row.variance = variance;
  return row;
}

// Matérn with ν = 3/2 and variance 1: its step over a time T and the covariance that it adds (Särkkä & Solin, Applied
// Stochastic Differential Equations, 2019, 12.3).
struct MaternStep {
  Eigen::Matrix2d transition, added;

  MaternStep(double t, double memory_s) {
    const double rate = std::sqrt(3) / memory_s, kept = std::exp(-rate * t);
    transition << (1 + rate * t) * kept, t * kept, -rate * rate * t * kept, (1 - rate * t) * kept;
    const Eigen::Matrix2d stationary = Eigen::Vector2d(1, rate * rate).asDiagonal();
    added = stationary - transition * stationary * transition.transpose();
  }
};

}  // namespace

SmoothedPath BridgePath(const SeenPath& seen, const PathModel& model, const MotionPrior& prior,
                        std::span<const DistancePrior> distances, std::span<const PathPoint> near, std::size_t begin,
                        std::size_t end) {
  const BridgeLayout layout{seen.axes, static_cast<int>(distances.size())};
  const int states = layout.States();
  BridgeFilter filter(end - begin, states, 1);
  std::vector<BridgeSquare> transitions(end - begin, BridgeSquare::Zero(states, states));
  for (std::size_t i = begin; i < end; ++i) {
    Frame<Eigen::Dynamic>& frame = filter.At(i - begin);
    frame.first_row = filter.rows.size();
    for (int a = 0; a < seen.axes && seen.IsSeen(i); ++a) {
      auto row = OneRow(layout, seen.place[i][a], model.WhiteVariance(i, seen.sigma[i]));
      row.h[layout.Axis(a, kPosition)] = 1;
      row.h[layout.Axis(a, kLasting)] = seen.sigma[i];
      filter.rows.push_back(row);
    }
    for (int k = 0; k < layout.distances; ++k) {
      const DistancePrior& distance = distances[static_cast<std::size_t>(k)];
      const double least_variance = 1e-6 * distance.sigma * distance.sigma + 1e-12;
      if (seen.IsSeen(i)) {
        if (!std::isfinite(distance.deviation[i])) continue;
        auto row = OneRow(layout, distance.deviation[i], std::pow(distance.deviation_sigma[i], 2));
        row.h[layout.Deviation(k)] = 1;
        filter.rows.push_back(row);
        continue;
      }
      const Eigen::Vector3d apart = near[i - begin].position - distance.other[i];
      if (!apart.allFinite() || !(apart.norm() > 0)) continue;
      const Eigen::Vector3d along = apart.normalized();
      const Eigen::Matrix3d& covariance = near[i - begin].position_covariance;
      const double curved = (covariance.trace() - along.dot(covariance * along)) / apart.norm();
      auto row = OneRow(layout, distance.length + along.dot(distance.other[i]),
                        least_variance + along.dot(distance.other_covariance[i] * along) + curved * curved / 2);
      for (int a = 0; a < seen.axes; ++a) row.h[layout.Axis(a, kPosition)] = along[a];
      row.h[layout.Deviation(k)] = -1;
      filter.rows.push_back(row);
    }
    frame.rows = filter.rows.size() - frame.first_row;
  }
  const Eigen::Matrix4d start = StartCovariance(model, prior);
  filter.Forward([&](std::size_t k, Means<Eigen::Dynamic>& mean, BridgeSquare& covariance) {
    Frame<Eigen::Dynamic>& frame = filter.At(k);
    const std::size_t i = begin + k;
    double farthest2 = 0;
    if (k > 0) {
      const double t = seen.time_s[i] - seen.time_s[i - 1];
      const AxisStep step(t, model.Kept(i, t));
      BridgeSquare added = BridgeSquare::Zero(states, states);
      BridgeSquare& by = transitions[k];
      for (int a = 0; a < seen.axes; ++a) {
        const int at = layout.Axis(a, 0);
        by.block<3, 3>(at, at) = JerkTransition(t);
        by(at + kLasting, at + kLasting) = step.kept;
        added.block<3, 3>(at, at) = model.density[i] * step.jerk;
        added(at + kLasting, at + kLasting) = model.lasting * (1 - step.kept * step.kept);
      }
      for (int d = 0; d < layout.distances; ++d) {
        const DistancePrior& distance = distances[static_cast<std::size_t>(d)];
        const MaternStep matern(t, distance.memory_s);
        by.block<2, 2>(layout.Deviation(d), layout.Deviation(d)) = matern.transition;
        added.block<2, 2>(layout.Deviation(d), layout.Deviation(d)) = distance.sigma * distance.sigma * matern.added;
      }
      mean = Means<Eigen::Dynamic>(by * mean);
      covariance = BridgeSquare(by * covariance * by.transpose() + added);
      for (int a = 0; a < seen.axes; ++a)
        farthest2 = std::max(farthest2, covariance(layout.Axis(a, kPosition), layout.Axis(a, kPosition)));
    }
    frame.starts = k == 0 || farthest2 > prior.reach * prior.reach;
    if (!frame.starts) return;
    mean.setZero();
    covariance.setZero();
    for (int a = 0; a < seen.axes; ++a) {
      mean(layout.Axis(a, kPosition), 0) = near[k].position[a];
      covariance.block<4, 4>(layout.Axis(a, 0), layout.Axis(a, 0)) = start;
    }
    for (int d = 0; d < layout.distances; ++d) {
      const DistancePrior& distance = distances[static_cast<std::size_t>(d)];
      const int at = layout.Deviation(d);
      covariance(at, at) = distance.sigma * distance.sigma;
      covariance(at + 1, at + 1) = 3 * distance.sigma * distance.sigma / (distance.memory_s * distance.memory_s);
    }
  });
  SmoothedPath path;
  path.point.resize(end - begin);
  filter.Back(
      [&](std::size_t k, Backward<Eigen::Dynamic>& b) {
        const BridgeSquare& by = transitions[k];
        b.r = Means<Eigen::Dynamic>(by.transpose() * b.r);
        b.n = BridgeSquare(by.transpose() * b.n * by);
      },
      [&](std::size_t k, const Backward<Eigen::Dynamic>& b) {
        const Frame<Eigen::Dynamic>& frame = filter.At(k);
        const BridgeState mean = frame.mean.col(0) + frame.covariance * b.r.col(0);
        const BridgeSquare covariance = frame.covariance - frame.covariance * b.n * frame.covariance;
        PathPoint& point = path.point[k];
        for (int a = 0; a < seen.axes; ++a) {
          point.position[a] = mean[layout.Axis(a, kPosition)];
          point.velocity[a] = mean[layout.Axis(a, kVelocity)];
          point.acceleration[a] = mean[layout.Axis(a, kAcceleration)];
          for (int c = 0; c < seen.axes; ++c)
            point.position_covariance(a, c) = covariance(layout.Axis(a, kPosition), layout.Axis(c, kPosition));
          point.velocity_variance += covariance(layout.Axis(a, kVelocity), layout.Axis(a, kVelocity)) / seen.axes;
        }
      },
      [](auto&&...) {}, [](auto&&...) {});
  return path;
}

}  // namespace lake::dynamics
