#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "hinge_fit.h"
#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/plausible.h"

namespace lake::axis {
namespace {

using Eigen::Matrix3d, Eigen::MatrixXd, Eigen::Vector2d, Eigen::Vector3d, Eigen::VectorXd;

constexpr std::size_t kLeastFrames = 10;  // four unknowns, and something to judge the residuals by

std::vector<std::size_t> SeenFrames(const SegmentMotion& motion, std::size_t first, std::size_t end) {
  std::vector<std::size_t> frames;
  for (std::size_t i = first; i < end; ++i)
    if (motion.shank.poses[i].IsSeen() && motion.thigh.poses[i].IsSeen()) frames.push_back(i);
  return frames;
}

double LargestTurnDeg(const SegmentMotion& motion, const std::vector<std::size_t>& frames) {
  const auto turn = [&](std::size_t i) -> Matrix3d {
    return motion.shank.poses[i].turn.transpose() * motion.thigh.poses[i].turn;
  };
  double largest = 0;
  for (std::size_t i : frames)
    largest =
        std::max(largest, DegreesFromRadians(Eigen::AngleAxisd(turn(frames.front()).transpose() * turn(i)).angle()));
  return largest;
}

// How the shank's point moves with the unknowns at the shank's deformation `modes`.
Eigen::Matrix2Xd ShankPointRows(const Eigen::RowVectorXd& modes, Eigen::Index unknowns) {
  Eigen::Matrix2Xd rows = Eigen::Matrix2Xd::Zero(2, unknowns);
  rows.middleCols<2>(2).setIdentity();
  for (Eigen::Index mode = 0; mode < modes.size(); ++mode)
    rows.middleCols<2>(4 + 2 * mode).diagonal().setConstant(modes[mode]);
  return rows;
}

MeanAxis AxisOf(const SegmentMotion& motion, const std::vector<std::size_t>& frames, const AxisFrames& across,
                const HingeFit& fit, const HingeSolution& solution) {
  const double count = static_cast<double>(frames.size());
  const MatrixXd& modes = motion.shank.deformation.modes;
  const auto in_shank = [&](const Eigen::RowVectorXd& mode) -> Vector3d {
    return across.shank.leftCols<2>() * (ShankPointRows(mode, solution.unknowns.size()) * solution.unknowns);
  };
  MeanAxis axis;
  axis.first = frames.front();
  axis.last = frames.back();
  axis.direction_shank = across.shank.col(2);
  axis.in_thigh = across.thigh * Vector3d(solution.unknowns[0], solution.unknowns[1], across.thigh_along_mm);
  axis.in_file = axis.direction_file = Vector3d::Zero();
  Eigen::RowVectorXd mean_modes = Eigen::RowVectorXd::Zero(modes.cols());
  for (std::size_t i : frames) {
    const Pose& shank = motion.shank.poses[i];
    const auto row = modes.row(static_cast<Eigen::Index>(i));
    mean_modes += row / count;
    axis.in_file += (shank.turn * in_shank(row) + shank.origin) / count;
    axis.direction_file += shank.turn * axis.direction_shank;
  }
  axis.in_shank = in_shank(mean_modes);
  axis.direction_file.normalize();
  const Eigen::Matrix2Xd rows = ShankPointRows(mean_modes, solution.unknowns.size());
  axis.sd_mm = std::sqrt((rows * solution.covariance * rows.transpose()).trace() / 2);
  double square = 0;
  for (const HingeEquation& e : fit.Equations()) square += e.Stray(solution.unknowns).squaredNorm();
  axis.pin_residual_mm = std::sqrt(square / count);
  const auto [least, most] = std::ranges::minmax_element(fit.Equations(), {}, &HingeEquation::angle_rad);
  axis.flexion_deg = DegreesFromRadians(most->angle_rad - least->angle_rad);
  return axis;
}

// A hinge of two segments is no farther from their markers than a segment is long.
void CheckIsAKnees(const MeanAxis& axis) {
  for (const auto& [segment, distance_mm] : {std::pair{"shank", axis.in_shank.norm()}, {"thigh", axis.in_thigh.norm()}})
    if (distance_mm - 2 * axis.sd_mm > kPlausibleSegment.high)
      throw Fail(
          "the axis is {:.0f} mm (standard deviation {:.0f}) from the markers of the {}, and a knee is within {:.0f} "
          "mm: are all markers of --segment on the segments that they are named for?",
          distance_mm, axis.sd_mm, segment, kPlausibleSegment.high);
}

MeanAxis WindowAxis(const SegmentMotion& motion, const std::vector<std::size_t>& frames, const LearntErrors& errors) {
  const AxisFrames across = AxisFramesOf(motion, frames);
  const HingeFit fit(motion, EquationsOf(motion, frames, across), &errors);
  return AxisOf(motion, frames, across, fit, WithWhole(fit.Solve(errors.models), across, errors));
}

}  // namespace

MeanAxesResult MeanAxes(const SegmentMotion& motion, std::size_t window_frames, double least_turn_deg) {
  const std::size_t count = motion.shank.poses.size();
  const std::vector<std::size_t> all = SeenFrames(motion, 0, count);
  if (all.size() < kLeastFrames)
    throw Fail("{} frames show both segments; an axis needs at least {}", all.size(), kLeastFrames);
  if (const double turn = LargestTurnDeg(motion, all); turn < least_turn_deg)
    throw Fail("the segments turn by {:.1f} degrees only; an axis needs at least {:.0f}", turn, least_turn_deg);
  const AxisFrames across = AxisFramesOf(motion, all);
  const HingeFit fit(motion, EquationsOf(motion, all, across));
  MeanAxesResult result;
  result.errors = fit.LearnErrors(across);
  result.whole = AxisOf(motion, all, across, fit, fit.Solve(result.errors.models));
  CheckIsAKnees(result.whole);
  for (std::size_t window = 1; window_frames > 0 && window * window_frames <= count; ++window) {
    const std::vector<std::size_t> some = SeenFrames(motion, (window - 1) * window_frames, window * window_frames);
    const double turn = some.empty() ? 0 : LargestTurnDeg(motion, some);
    if (some.size() < kLeastFrames || turn < least_turn_deg) {
      result.warnings.push_back(
          fmt::format("window {} is left out: {} of its frames show both segments, which turn by {:.1f} degrees; an "
                      "axis needs at least {} and {:.0f}",
                      window, some.size(), turn, kLeastFrames, least_turn_deg));
      continue;
    }
    result.windows.push_back(WindowAxis(motion, some, result.errors));
    result.windows.back().window = window;
  }
  return result;
}

std::vector<double> KneeAngles(const SegmentMotion& motion, const MeanAxis& axis) {
  Matrix3d frame;
  frame.col(0) = axis.direction_shank.unitOrthogonal();
  frame.col(1) = axis.direction_shank.cross(frame.col(0));
  frame.col(2) = axis.direction_shank;
  const Vector3d shank = frame.transpose() * (motion.shank.first_marker - axis.in_shank);
  const std::size_t count = motion.shank.poses.size();
  std::vector<double> angles(count, std::numeric_limits<double>::quiet_NaN());
  double sum = 0, before = 0;
  bool has_before = false;
  for (std::size_t i : SeenFrames(motion, 0, count)) {
    const Matrix3d turn = motion.shank.poses[i].turn.transpose() * motion.thigh.poses[i].turn;
    const Vector3d thigh = frame.transpose() * (turn * (axis.in_thigh - motion.thigh.first_marker));
    const double angle = DegreesFromRadians(std::atan2(thigh.y(), thigh.x()) - std::atan2(shank.y(), shank.x()));
    angles[i] = std::remainder(has_before ? angle - before : angle, 360) + (has_before ? before : 0);
    sum += before = angles[i];
    has_before = true;
  }
  if (sum < 0)
    for (double& angle : angles) angle = -angle;
  return angles;
}

MeanAxis PinOver(const SegmentMotion& motion, const MeanAxesResult& axes, double from_deg, double to_deg) {
  const std::vector<double> angles = KneeAngles(motion, axes.whole);
  std::vector<std::size_t> frames;
  for (std::size_t i = 0; i < angles.size(); ++i)
    if (angles[i] >= from_deg && angles[i] <= to_deg) frames.push_back(i);
  if (frames.size() < kLeastFrames) {
    const auto seen = SeenFrames(motion, 0, angles.size());
    const auto [least, most] = std::ranges::minmax(seen, {}, [&](std::size_t i) { return angles[i]; });
    throw Fail(
        "{} frames have a knee angle of {:.0f} to {:.0f} degrees; a pin needs at least {}: the recording goes from "
        "{:.0f} to {:.0f}",
        frames.size(), from_deg, to_deg, kLeastFrames, angles[least], angles[most]);
  }
  const AxisFrames across = AxisFramesOf(motion, frames);
  const HingeFit fit(motion, EquationsOf(motion, frames, across), &axes.errors);
  return AxisOf(motion, frames, across, fit, fit.Solve(axes.errors.models));
}

}  // namespace lake::axis
