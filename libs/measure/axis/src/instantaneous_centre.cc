#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>

#include "lake/axis/functional_axis.h"
#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/gait/smoothing_spline.h"

namespace lake::axis {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

constexpr int kBins = 60;   // over the range of angles
constexpr int kSteps = 30;  // of the spline

// Two directions across the axis and the axis, as columns.
Matrix3d AcrossAndAlong(const Vector3d& axis) {
  Matrix3d frame;
  frame.col(0) = axis.unitOrthogonal();
  frame.col(1) = axis.cross(frame.col(0));
  frame.col(2) = axis;
  return frame;
}

// Means over bins of the angle, each passage through a bin one draw; `sigma` is of those means.
struct Binned {
  std::vector<double> place, value, sigma;
};

Binned Bin(const std::vector<double>& place, const std::vector<double>& value) {
  std::map<int, std::vector<double>> passages;
  std::map<int, double> places;
  for (std::size_t i = 0; i < place.size();) {
    const int bin = std::min(static_cast<int>(place[i] * kBins), kBins - 1);
    double sum = 0, count = 0;
    for (; i < place.size() && std::min(static_cast<int>(place[i] * kBins), kBins - 1) == bin; ++i, ++count)
      sum += value[i];
    passages[bin].push_back(sum / count);
  }
  double square = 0, freedom = 0;
  for (const auto& [bin, draws] : passages) {
    const double mean = Mean(draws);
    for (double draw : draws) square += (draw - mean) * (draw - mean);
    freedom += static_cast<double>(draws.size()) - 1;
  }
  if (freedom < 1 || square <= 0)
    throw Fail("the segments pass no angle twice: an instantaneous centre needs a repeated movement");
  Binned binned;
  for (const auto& [bin, draws] : passages) {
    binned.place.push_back((bin + 0.5) / kBins);
    binned.value.push_back(Mean(draws));
    binned.sigma.push_back(std::sqrt(square / freedom / static_cast<double>(draws.size())));
  }
  return binned;
}

// A function of the place in the range of angles, with its slope.
struct Curve {
  gait::SplineGrid grid;
  gait::SmoothSignal signal;

  double Value(double place) const { return gait::ValueAt(grid.At(place), signal.coefficients); }
  double Slope(double place) const { return gait::SlopeAt(grid.At(place), signal.coefficients); }
  double ValueVariance(double place) const { return gait::VarianceAt(grid.At(place), signal.covariance); }
  double SlopeVariance(double place) const {
    gait::SplineGrid::Place at = grid.At(place);
    at.value = at.slope;
    return gait::VarianceAt(at, signal.covariance);
  }
};

Curve CurveOf(const std::vector<double>& place, const std::vector<double>& value) {
  const Binned binned = Bin(place, value);
  gait::SmoothingOptions options;
  options.window_s = 1;  // one roughness over the range
  Curve curve;
  curve.grid = gait::MakeSplineGrid(std::vector<double>{0, 1}, 1.0 / kSteps);
  curve.signal = gait::FitSmoothingSpline(curve.grid, binned.place, binned.value, binned.sigma, options);
  return curve;
}

}  // namespace

std::vector<double> KneeAngles(const SegmentMotion& motion, const MeanAxis& axis) {
  const Matrix3d frame = AcrossAndAlong(axis.direction_shank);
  const Vector3d shank = frame.transpose() * (motion.shank_marker - axis.in_shank);
  std::vector<double> angles(motion.shank.size(), std::numeric_limits<double>::quiet_NaN());
  double before = 0;
  bool has_before = false;
  std::vector<double> seen;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    if (!motion.shank[i].IsSeen() || !motion.thigh[i].IsSeen()) continue;
    const Matrix3d turn = motion.shank[i].turn.transpose() * motion.thigh[i].turn;
    const Vector3d thigh = frame.transpose() * (turn * (axis.in_thigh - motion.thigh_marker));
    double angle = DegreesFromRadians(std::atan2(thigh.y(), thigh.x()) - std::atan2(shank.y(), shank.x()));
    angle = std::remainder(has_before ? angle - before : angle, 360) + (has_before ? before : 0);
    before = angle;
    has_before = true;
    angles[i] = angle;
    seen.push_back(angle);
  }
  if (!seen.empty() && Mean(seen) < 0)
    for (double& angle : angles) angle = -angle;
  return angles;
}

std::vector<InstantaneousCentre> InstantaneousCentres(const SegmentMotion& motion, const MeanAxis& axis) {
  const Matrix3d frame = AcrossAndAlong(axis.direction_shank);
  const std::vector<double> angles = KneeAngles(motion, axis);
  std::vector<std::size_t> frames;
  std::vector<double> place, x, y;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (std::size_t i = 0; i < angles.size(); ++i) {
    if (!std::isfinite(angles[i])) continue;
    frames.push_back(i);
    low = std::min(low, angles[i]);
    high = std::max(high, angles[i]);
    const Pose &shank = motion.shank[i], &thigh = motion.thigh[i];
    const Vector3d stray =
        frame.transpose() *
        (shank.turn.transpose() * (thigh.turn * axis.in_thigh + thigh.origin - shank.origin) - axis.in_shank);
    x.push_back(stray.x());
    y.push_back(stray.y());
  }
  if (!(high > low)) throw Fail("the knee angle stands still: an instantaneous centre needs a movement");
  // The knee angle's sign against a turn about the axis.
  double same = 0;
  for (std::size_t k = 1; k < frames.size(); ++k) {
    const Matrix3d a = motion.shank[frames[k - 1]].turn.transpose() * motion.thigh[frames[k - 1]].turn;
    const Matrix3d b = motion.shank[frames[k]].turn.transpose() * motion.thigh[frames[k]].turn;
    const Eigen::AngleAxisd step(b * a.transpose());
    same += step.angle() * step.axis().dot(axis.direction_shank) * (angles[frames[k]] - angles[frames[k - 1]]);
  }
  const double range = RadiansFromDegrees((same < 0 ? -1 : 1) * (high - low));  // rad about the axis, per unit of place
  for (std::size_t i : frames) place.push_back((angles[i] - low) / (high - low));
  const Curve stray_x = CurveOf(place, x), stray_y = CurveOf(place, y);
  std::vector<InstantaneousCentre> centres;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const double p = place[k];
    // No velocity at the centre c: d(stray)/dθ + z × (c − stray) = 0, so c = stray + z × d(stray)/dθ.
    const Vector3d centre(stray_x.Value(p) - stray_y.Slope(p) / range, stray_y.Value(p) + stray_x.Slope(p) / range, 0);
    const Vector3d variance(stray_x.ValueVariance(p) + stray_y.SlopeVariance(p) / (range * range),
                            stray_y.ValueVariance(p) + stray_x.SlopeVariance(p) / (range * range), 0);
    const Pose& shank = motion.shank[frames[k]];
    InstantaneousCentre c{frames[k], angles[frames[k]], axis.in_shank + frame * centre, {}, {}};
    c.in_file = shank.turn * c.in_shank + shank.origin;
    c.sd_mm = (frame * variance.asDiagonal() * frame.transpose()).diagonal().cwiseSqrt();
    centres.push_back(c);
  }
  return centres;
}

}  // namespace lake::axis
