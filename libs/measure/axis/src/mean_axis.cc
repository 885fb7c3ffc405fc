#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "hinge.h"
#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/plausible.h"

namespace lake::axis {
namespace {

using Eigen::Matrix3d, Eigen::Vector2d, Eigen::Vector3d;

constexpr std::size_t kLeastFrames = 10;  // four unknowns, and something to judge the residuals by

std::vector<std::size_t> SeenFrames(const SegmentMotion& motion, std::size_t first, std::size_t end) {
  std::vector<std::size_t> frames;
  for (std::size_t i = first; i < end; ++i)
    if (motion.shank.poses[i].IsSeen() && motion.thigh.poses[i].IsSeen()) frames.push_back(i);
  return frames;
}

double LargestTurnDeg(const SegmentMotion& motion, const std::vector<std::size_t>& frames) {
  const Matrix3d back = TurnOf(motion, frames.front()).transpose();
  double largest_rad = 0;
  for (std::size_t i : frames) largest_rad = std::max(largest_rad, Eigen::AngleAxisd(back * TurnOf(motion, i)).angle());
  return DegreesFromRadians(largest_rad);
}

MeanAxis AxisOver(const SegmentMotion& motion, const std::vector<std::size_t>& frames) {
  const Hinge hinge = FitHinge(motion, frames);
  const double count = static_cast<double>(frames.size());
  MeanAxis axis;
  axis.first = frames.front();
  axis.last = frames.back();
  axis.in_shank = hinge.shank.leftCols<2>() * hinge.shank_mm;
  axis.in_thigh = hinge.thigh * Vector3d(hinge.thigh_mm.x(), hinge.thigh_mm.y(), hinge.thigh_along_mm);
  axis.direction_shank = hinge.shank.col(2);
  axis.in_file = axis.direction_file = Vector3d::Zero();
  for (std::size_t i : frames) {
    const Pose& shank = motion.shank.poses[i];
    axis.in_file += (shank.turn * axis.in_shank + shank.origin) / count;
    axis.direction_file += shank.turn * axis.direction_shank;
  }
  axis.direction_file.normalize();
  axis.sd_mm = hinge.sd_mm;
  double square = 0;
  for (const HingeFrame& frame : hinge.frames) square += hinge.Residual(frame).squaredNorm();
  axis.pin_residual_mm = std::sqrt(square / count);
  axis.flexion_deg = DegreesFromRadians(hinge.range_rad);
  return axis;
}

// A knee is no farther from a segment's markers than a segment is long.
void CheckIsAKnees(const MeanAxis& axis) {
  for (const auto& [segment, distance_mm] : {std::pair{"shank", axis.in_shank.norm()}, {"thigh", axis.in_thigh.norm()}})
    if (distance_mm - 2 * axis.sd_mm > kPlausibleSegment.high)
      throw Fail(
          "the axis is {:.0f} mm (standard deviation {:.0f}) from the markers of the {}, and a knee is within {:.0f} "
          "mm: are all markers of --segment on the segments that they are named for?",
          distance_mm, axis.sd_mm, segment, kPlausibleSegment.high);
}

}  // namespace

MeanAxesResult MeanAxes(const SegmentMotion& motion, std::size_t window_frames, double least_turn_deg) {
  const std::size_t count = motion.shank.poses.size();
  const std::vector<std::size_t> all = SeenFrames(motion, 0, count);
  if (all.size() < kLeastFrames)
    throw Fail("{} frames show both segments; an axis needs at least {}", all.size(), kLeastFrames);
  if (const double turn = LargestTurnDeg(motion, all); turn < least_turn_deg)
    throw Fail("the segments turn by {:.1f} degrees only; an axis needs at least {:.0f}", turn, least_turn_deg);
  MeanAxesResult result;
  result.whole = AxisOver(motion, all);
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
    result.windows.push_back(AxisOver(motion, some));
    result.windows.back().window = window;
  }
  return result;
}

std::vector<double> KneeAngles(const SegmentMotion& motion, const MeanAxis& axis) {
  const Matrix3d frame = AcrossAndAlong(axis.direction_shank);
  const Vector3d shank = frame.transpose() * (motion.shank.shape.col(0) - axis.in_shank);
  const std::size_t count = motion.shank.poses.size();
  std::vector<double> angles(count, std::numeric_limits<double>::quiet_NaN());
  double sum = 0, before = 0;
  bool has_before = false;
  for (std::size_t i : SeenFrames(motion, 0, count)) {
    const Vector3d thigh = frame.transpose() * (TurnOf(motion, i) * (axis.in_thigh - motion.thigh.shape.col(0)));
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
  return AxisOver(motion, frames);
}

std::vector<InstantaneousCentre> InstantaneousCentres(const SegmentMotion& motion, const MeanAxesResult& axes) {
  const std::vector<double> angles = KneeAngles(motion, axes.whole);
  const std::vector<std::size_t> frames = SeenFrames(motion, 0, angles.size());
  const Hinge hinge = FitHinge(motion, frames);
  const double shank_mm2 = std::pow(motion.shank.PointSdMm(hinge.shank_mm.norm()), 2);
  const double thigh_mm2 = std::pow(motion.thigh.PointSdMm(hinge.thigh_mm.norm()), 2);
  const double both_mm2 = shank_mm2 + thigh_mm2;
  const double thighs_share = both_mm2 > 0 ? shank_mm2 / both_mm2 : 0.5;
  const double sd_mm = std::sqrt(hinge.sd_mm * hinge.sd_mm + thighs_share * thigh_mm2);
  const Vector3d across = (1 - hinge.shank.col(2).array().square()).max(0).sqrt();
  std::vector<InstantaneousCentre> centres;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const Vector2d place = hinge.shank_mm + thighs_share * hinge.Residual(hinge.frames[k]);
    const Pose& shank = motion.shank.poses[frames[k]];
    InstantaneousCentre centre{frames[k], angles[frames[k]], hinge.shank.leftCols<2>() * place, {}, sd_mm * across};
    centre.in_file = shank.turn * centre.in_shank + shank.origin;
    centres.push_back(centre);
  }
  return centres;
}

}  // namespace lake::axis
