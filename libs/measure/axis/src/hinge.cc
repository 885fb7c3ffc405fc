#include "hinge.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "lake/core/numbers.h"

namespace lake::axis {
namespace {

using Eigen::Matrix2d, Eigen::Matrix3d, Eigen::Matrix4d, Eigen::Vector2d, Eigen::Vector3d, Eigen::Vector4d;
using Matrix42 = Eigen::Matrix<double, 4, 2>;

// The thigh's origin in the shank's frame, mm.
Vector3d OffsetOf(const SegmentMotion& motion, std::size_t frame) {
  const Pose &shank = motion.shank.poses[frame], &thigh = motion.thigh.poses[frame];
  return shank.turn.transpose() * (thigh.origin - shank.origin);
}

// The directions a and b of shank and thigh that the turns take to each other best: with their mean M, b = Mᵀ a and a
// is M Mᵀ's first eigenvector.
void SetDirections(const SegmentMotion& motion, const std::vector<std::size_t>& frames, Hinge& hinge) {
  const double count = static_cast<double>(frames.size());
  Matrix3d mean = Matrix3d::Zero();
  for (std::size_t frame : frames) mean += TurnOf(motion, frame) / count;
  const Matrix3d square = mean * mean.transpose();
  const Vector3d first = Eigen::SelfAdjointEigenSolver<Matrix3d>(square).eigenvectors().col(2);
  const Vector3d shank = first.z() < 0 ? Vector3d(-first) : first;
  hinge.shank = AcrossAndAlong(shank);
  hinge.thigh = AcrossAndAlong((mean.transpose() * shank).normalized());
  for (std::size_t frame : frames) hinge.thigh_along_mm -= shank.dot(OffsetOf(motion, frame)) / count;
}

void SetFrames(const SegmentMotion& motion, const std::vector<std::size_t>& frames, Hinge& hinge) {
  for (std::size_t i : frames) {
    const Matrix3d turn = hinge.shank.transpose() * TurnOf(motion, i) * hinge.thigh;
    const Vector3d offset = hinge.shank.transpose() * OffsetOf(motion, i) + hinge.thigh_along_mm * turn.col(2);
    HingeFrame frame{turn.topLeftCorner<2, 2>(), offset.head<2>(),
                     std::atan2(turn(1, 0) - turn(0, 1), turn(0, 0) + turn(1, 1))};
    if (!hinge.frames.empty()) {
      const double before = hinge.frames.back().angle_rad;
      frame.angle_rad = before + std::remainder(frame.angle_rad - before, 2 * kPi);
    }
    hinge.frames.push_back(frame);
  }
  const auto [least, most] = std::ranges::minmax_element(hinge.frames, {}, &HingeFrame::angle_rad);
  hinge.range_rad = std::max(most->angle_rad - least->angle_rad, 1e-9);
}

// Of the residual with respect to the thigh's point and the shank's.
Matrix42 Gradient(const HingeFrame& frame) {
  Matrix42 gradient;
  gradient << frame.turn.transpose(), -Matrix2d::Identity();
  return gradient;
}

// Returns the inverse of the normal matrix.
Matrix4d SetPoints(Hinge& hinge) {
  Matrix4d normal = Matrix4d::Zero();
  Vector4d right = Vector4d::Zero();
  for (const HingeFrame& frame : hinge.frames) {
    const Matrix42 gradient = Gradient(frame);
    normal += gradient * gradient.transpose();
    right -= gradient * frame.offset;
  }
  Matrix4d inverse = normal.inverse();
  const Vector4d points = inverse * right;
  hinge.thigh_mm = points.head<2>();
  hinge.shank_mm = points.tail<2>();
  return inverse;
}

// How errors e of the frames move the points: inverse · Σ gradient · e. From the covariance of that sum, the shank
// point's variance along each axis, mm².
double PointVariance(const Matrix4d& inverse, const Matrix4d& covariance_of_sum) {
  return (inverse * covariance_of_sum * inverse).bottomRightCorner<2, 2>().trace() / 2;
}

// Of that sum where the errors are those of a segment's pose. They are estimated from the deformation, coordinate by
// coordinate of each marker: were it the displacement of one marker, it would shift the pose by 1 / markers of it and
// turn it about the mean of the markers. Only changes within these frames count, as the frame is the markers' own mean.
Matrix4d PoseCovariance(const Segment& segment, const std::vector<std::size_t>& frames, const Hinge& hinge,
                        bool is_thigh) {
  const Matrix3d& axes = is_thigh ? hinge.thigh : hinge.shank;
  const Vector2d joint = is_thigh ? hinge.thigh_mm : hinge.shank_mm, lever(-joint.y(), joint.x());
  const double square_mm2 = (axes.leftCols<2>().transpose() * segment.shape).squaredNorm();
  const Matrix2d shift_and_turn =
      Matrix2d::Identity() / static_cast<double>(segment.shape.cols()) + lever * lever.transpose() / square_mm2;
  std::vector<Matrix42> sums(static_cast<std::size_t>(segment.shape.size()), Matrix42::Zero());
  std::vector<double> means(sums.size(), 0);
  Matrix42 gradients = Matrix42::Zero();
  for (std::size_t i = 0; i < frames.size(); ++i) {
    Matrix42 gradient = Gradient(hinge.frames[i]);
    if (is_thigh) gradient = gradient * hinge.frames[i].turn;
    gradients += gradient;
    const double* const deformation = segment.deformation[frames[i]].data();
    for (std::size_t k = 0; k < sums.size(); ++k) {
      sums[k] += deformation[k] * gradient;
      means[k] += deformation[k] / static_cast<double>(frames.size());
    }
  }
  Matrix4d covariance = Matrix4d::Zero();
  for (std::size_t k = 0; k < sums.size(); ++k) {
    const Matrix42 sum = sums[k] - means[k] * gradients;
    covariance += sum * shift_and_turn * sum.transpose() / segment.freedom;
  }
  return covariance;
}

// How much larger a variance that comes from so many coordinates must be for an ellipse to hold 95 %: the quantile of
// F(2, freedom), which has a closed form, over that of F(2, ∞) = ln 20.
double Widening(double freedom) {
  return freedom / 2 * (std::pow(20, 2 / freedom) - 1) / std::log(20);
}

// The shank point's variance by errors in proportion to the angle, which leave next to no residual: as large as each
// power of the angle, to the fourth, is in the residual on average.
double VarianceByResidual(const Hinge& hinge, const Matrix4d& inverse) {
  constexpr double kLeast_mm = 0.1;  // root mean square: a machined hinge, measured optically, has as much (README)
  constexpr double kFreedom = 6;     // four powers along two axes; the points take two
  const double count = static_cast<double>(hinge.frames.size());
  std::vector<Vector4d> powers;
  Vector4d mean = Vector4d::Zero();
  for (const HingeFrame& frame : hinge.frames) {
    const double x = (frame.angle_rad - hinge.frames.front().angle_rad) / hinge.range_rad;
    powers.emplace_back(x, x * x, x * x * x, x * x * x * x);
    mean += powers.back() / count;
  }
  Matrix4d square = Matrix4d::Zero();
  Matrix42 right = Matrix42::Zero(), linear = Matrix42::Zero();
  for (std::size_t i = 0; i < powers.size(); ++i) {
    const Vector4d power = powers[i] - mean;
    square += power * power.transpose();
    right += power * hinge.Residual(hinge.frames[i]).transpose();
    linear += power[0] * Gradient(hinge.frames[i]);
  }
  const double found_mm2 = right.cwiseProduct(square.ldlt().solve(right)).sum() / kFreedom;
  const double each_mm2 = std::max(Widening(kFreedom) * found_mm2, count * kLeast_mm * kLeast_mm);
  return each_mm2 / square(0, 0) * PointVariance(inverse, linear * linear.transpose());
}

}  // namespace

Matrix3d AcrossAndAlong(const Vector3d& axis) {
  Matrix3d frame;
  frame.col(0) = axis.unitOrthogonal();
  frame.col(1) = axis.cross(frame.col(0));
  frame.col(2) = axis;
  return frame;
}

Matrix3d TurnOf(const SegmentMotion& motion, std::size_t frame) {
  return motion.shank.poses[frame].turn.transpose() * motion.thigh.poses[frame].turn;
}

Hinge FitHinge(const SegmentMotion& motion, const std::vector<std::size_t>& frames) {
  Hinge hinge;
  SetDirections(motion, frames, hinge);
  SetFrames(motion, frames, hinge);
  const Matrix4d inverse = SetPoints(hinge);
  const Matrix4d of_poses =
      PoseCovariance(motion.shank, frames, hinge, false) + PoseCovariance(motion.thigh, frames, hinge, true);
  const double by_deformation =
      Widening(motion.shank.freedom + motion.thigh.freedom) * PointVariance(inverse, of_poses);
  hinge.sd_mm = std::sqrt(std::max(by_deformation, VarianceByResidual(hinge, inverse)));
  return hinge;
}

}  // namespace lake::axis
