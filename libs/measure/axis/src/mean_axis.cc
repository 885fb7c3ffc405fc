#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>

#include "lake/axis/functional_axis.h"
#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"

namespace lake::axis {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Rows = Eigen::Matrix<double, 3, 6>;

// Of one frame, in the shank's frame: turn · in_thigh − in_shank + offset is how far the two points stand apart.
struct Equation {
  std::size_t frame;
  Rows rows;
  Vector3d offset;
};

std::vector<Equation> EquationsOf(const SegmentMotion& motion, std::size_t first, std::size_t last) {
  std::vector<Equation> equations;
  for (std::size_t i = first; i <= last; ++i) {
    const Pose &shank = motion.shank[i], &thigh = motion.thigh[i];
    if (!shank.IsSeen() || !thigh.IsSeen()) continue;
    Rows rows;
    rows << shank.turn.transpose() * thigh.turn, -Matrix3d::Identity();
    equations.push_back({i, rows, shank.turn.transpose() * (thigh.origin - shank.origin)});
  }
  return equations;
}

struct Solution {
  Vector6d points;             // in_thigh, in_shank
  Vector6d direction;          // the same of the axis
  Matrix6d inverse;            // of the normal matrix, across the axis
  std::vector<double> weight;  // of each equation
};

Solution Solve(const std::vector<Equation>& equations) {
  constexpr double kHuber = 1.345;  // 95 % efficient on normal residuals
  constexpr int kRounds = 20;
  Solution s;
  s.weight.assign(equations.size(), 1);
  for (int round = 0; round < kRounds; ++round) {
    Matrix6d normal = Matrix6d::Zero();
    Vector6d right = Vector6d::Zero();
    for (std::size_t i = 0; i < equations.size(); ++i) {
      normal += s.weight[i] * equations[i].rows.transpose() * equations[i].rows;
      right -= s.weight[i] * equations[i].rows.transpose() * equations[i].offset;
    }
    const Eigen::SelfAdjointEigenSolver<Matrix6d> eigen(normal);
    s.direction = eigen.eigenvectors().col(0);
    s.inverse.setZero();
    for (int k = 1; k < 6; ++k)
      s.inverse += eigen.eigenvectors().col(k) * eigen.eigenvectors().col(k).transpose() / eigen.eigenvalues()[k];
    s.points = s.inverse * right;
    std::vector<double> sizes;
    std::ranges::transform(equations, std::back_inserter(sizes),
                           [&](const Equation& e) { return (e.rows * s.points + e.offset).norm(); });
    const double scale = kHuber * Median(sizes);
    for (std::size_t i = 0; i < sizes.size(); ++i) s.weight[i] = sizes[i] > scale ? scale / sizes[i] : 1;
  }
  return s;
}

double TurnDeg(const Matrix3d& a, const Matrix3d& b) {
  return DegreesFromRadians(Eigen::AngleAxisd(a.transpose() * b).angle());
}

// The residuals' covariance at each lag of frames over the whole recording, tapered to zero at a quarter of it.
std::vector<Matrix3d> LagCovariances(const std::vector<Equation>& equations, const Solution& s, std::size_t frames) {
  std::vector<std::optional<Vector3d>> residual(frames);
  for (const Equation& e : equations) residual[e.frame] = e.rows * s.points + e.offset;
  const std::size_t lags = std::max<std::size_t>(frames / 4, 1);
  std::vector<Matrix3d> covariances(lags, Matrix3d::Zero());
  for (std::size_t lag = 0; lag < lags; ++lag) {
    for (std::size_t i = 0; i + lag < frames; ++i)
      if (residual[i] && residual[i + lag]) covariances[lag] += *residual[i] * residual[i + lag]->transpose();
    // Divided alike at each lag: so the whole is positive definite.
    covariances[lag] *=
        (1 - static_cast<double>(lag) / static_cast<double>(lags)) / static_cast<double>(equations.size());
  }
  return covariances;
}

Matrix6d CovarianceOf(const std::vector<Equation>& equations, const Solution& s, const std::vector<Matrix3d>& lags) {
  Matrix6d middle = Matrix6d::Zero();
  for (std::size_t i = 0; i < equations.size(); ++i)
    for (std::size_t j = i; j < equations.size() && equations[j].frame - equations[i].frame < lags.size(); ++j) {
      const Matrix6d term = s.weight[i] * s.weight[j] * equations[i].rows.transpose() *
                            lags[equations[j].frame - equations[i].frame] * equations[j].rows;
      middle += term;
      if (j != i) middle += term.transpose();
    }
  return s.inverse * middle * s.inverse;
}

MeanAxis AxisOf(const SegmentMotion& motion, const std::vector<Equation>& equations, const Solution& s,
                const std::vector<Matrix3d>& lags) {
  MeanAxis axis;
  axis.first = equations.front().frame;
  axis.last = equations.back().frame;
  axis.direction_thigh = s.direction.head<3>().normalized();
  axis.direction_shank = s.direction.tail<3>().normalized();
  if (axis.direction_shank.z() < 0) {
    axis.direction_shank *= -1;
    axis.direction_thigh *= -1;
  }
  const double along = s.points.tail<3>().dot(axis.direction_shank);
  axis.in_thigh = s.points.head<3>() - along * axis.direction_thigh;
  axis.in_shank = s.points.tail<3>() - along * axis.direction_shank;
  const Matrix3d across = Matrix3d::Identity() - axis.direction_shank * axis.direction_shank.transpose();
  axis.sd_mm = std::sqrt((across * CovarianceOf(equations, s, lags).bottomRightCorner<3, 3>() * across).trace() / 2);
  axis.in_file = axis.direction_file = Vector3d::Zero();
  double square = 0;
  const Matrix3d start = equations.front().rows.leftCols<3>();
  double low = 0, high = 0, angle = 0;
  Matrix3d before = start;
  for (const Equation& e : equations) {
    const Pose& shank = motion.shank[e.frame];
    axis.in_file += (shank.turn * axis.in_shank + shank.origin) / static_cast<double>(equations.size());
    axis.direction_file += shank.turn * axis.direction_shank;
    square += (across * (e.rows * s.points + e.offset)).squaredNorm();
    const Matrix3d now = e.rows.leftCols<3>();
    const Eigen::AngleAxisd step(now * before.transpose());
    angle += DegreesFromRadians(step.angle()) * step.axis().dot(axis.direction_shank);
    low = std::min(low, angle);
    high = std::max(high, angle);
    before = now;
  }
  axis.direction_file.normalize();
  axis.pin_residual_mm = std::sqrt(square / static_cast<double>(equations.size()));
  axis.flexion_deg = high - low;
  return axis;
}

double LargestTurnDeg(const std::vector<Equation>& equations) {
  double turn = 0;
  for (const Equation& e : equations)
    turn = std::max(turn, TurnDeg(equations.front().rows.leftCols<3>(), e.rows.leftCols<3>()));
  return turn;
}

}  // namespace

MeanAxesResult MeanAxes(const SegmentMotion& motion, std::size_t window_frames, double least_turn_deg) {
  constexpr std::size_t kLeastFrames = 10;  // six unknowns, and something to judge the residuals by
  const std::size_t frames = motion.shank.size();
  const std::vector<Equation> all = frames ? EquationsOf(motion, 0, frames - 1) : std::vector<Equation>();
  if (all.size() < kLeastFrames)
    throw Fail("{} frames show both segments; an axis needs at least {}", all.size(), kLeastFrames);
  if (const double turn = LargestTurnDeg(all); turn < least_turn_deg)
    throw Fail("the segments turn by {:.1f} degrees only; an axis needs at least {:.0f}", turn, least_turn_deg);
  const Solution whole = Solve(all);
  const std::vector<Matrix3d> lags = LagCovariances(all, whole, frames);
  MeanAxesResult result{AxisOf(motion, all, whole, lags), {}, {}};
  for (std::size_t window = 1; window_frames > 0 && window * window_frames <= frames; ++window) {
    const std::size_t first = (window - 1) * window_frames, last = window * window_frames - 1;
    const std::vector<Equation> some = EquationsOf(motion, first, last);
    const double turn = some.empty() ? 0 : LargestTurnDeg(some);
    if (some.size() < kLeastFrames || turn < least_turn_deg) {
      result.warnings.push_back(
          fmt::format("window {} is left out: {} of its frames show both segments, which turn by {:.1f} degrees; an "
                      "axis needs at least {} and {:.0f}",
                      window, some.size(), turn, kLeastFrames, least_turn_deg));
      continue;
    }
    result.windows.push_back(AxisOf(motion, some, Solve(some), lags));
    result.windows.back().window = window;
  }
  return result;
}

}  // namespace lake::axis
