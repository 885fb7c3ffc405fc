#include "lake/dynamics/rigid_segment.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

namespace lake::dynamics {
namespace {

using Eigen::Matrix3d, Eigen::Matrix3Xd, Eigen::Vector3d;

// The least-squares turn that takes `from` to `to`, both about their means (Kabsch); in a plane about its normal.
Matrix3d TurnBetween(const Matrix3Xd& from, const Matrix3Xd& to, const TurnNormal& normal) {
  const Matrix3d moment = to * from.transpose();
  if (normal) {
    const Vector3d turned(moment(2, 1) - moment(1, 2), moment(0, 2) - moment(2, 0), moment(1, 0) - moment(0, 1));
    const double angle = std::atan2(normal->dot(turned), moment.trace() - normal->dot(moment * *normal));
    return Eigen::AngleAxisd(angle, *normal).toRotationMatrix();
  }
  const Eigen::JacobiSVD<Matrix3d> svd(moment, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3d sign = Vector3d::Ones();
  sign.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

std::vector<Eigen::Index> SeenColumns(const Matrix3Xd& places) {
  std::vector<Eigen::Index> seen;
  for (Eigen::Index m = 0; m < places.cols(); ++m)
    if (places.col(m).allFinite()) seen.push_back(m);
  return seen;
}

}  // namespace

double RigidSegment::PointSdMm(double distance_mm) const {
  return marker_sd_mm * std::hypot(1 / std::sqrt(static_cast<double>(shape.cols())), distance_mm / shape.norm());
}

Pose PoseOf(const Matrix3Xd& shape, const Matrix3Xd& places, const TurnNormal& normal) {
  const std::vector<Eigen::Index> seen = SeenColumns(places);
  if (seen.size() < (normal ? 2u : 3u)) return {};
  Matrix3Xd from = shape(Eigen::all, seen), to = places(Eigen::all, seen);
  const Vector3d from_mean = from.rowwise().mean(), to_mean = to.rowwise().mean();
  from.colwise() -= from_mean;
  to.colwise() -= to_mean;
  Pose pose;
  pose.turn = TurnBetween(from, to, normal);
  pose.origin = to_mean - pose.turn * from_mean;
  return pose;
}

std::optional<RigidSegment> FitRigidSegment(const std::vector<Matrix3Xd>& places, const TurnNormal& normal) {
  constexpr int kRounds = 5;        // the mean shape stands still after two or three
  std::vector<Matrix3Xd> complete;  // about their means
  for (const Matrix3Xd& now : places)
    if (now.allFinite()) complete.emplace_back(now.colwise() - Vector3d(now.rowwise().mean()));
  if (complete.empty()) return std::nullopt;
  RigidSegment segment;
  segment.shape = complete.front();
  for (int round = 0; round < kRounds; ++round) {
    Matrix3Xd sum = Matrix3Xd::Zero(3, segment.shape.cols());
    for (const Matrix3Xd& now : complete) sum += TurnBetween(now, segment.shape, normal) * now;
    segment.shape = sum / static_cast<double>(complete.size());
  }
  double square = 0;
  for (const Matrix3Xd& now : places) {
    segment.poses.push_back(PoseOf(segment.shape, now, normal));
    Matrix3Xd& deformation = segment.deformation.emplace_back(Matrix3Xd::Zero(3, now.cols()));
    const Pose& pose = segment.poses.back();
    for (const Eigen::Index m : pose.IsSeen() ? SeenColumns(now) : std::vector<Eigen::Index>())
      deformation.col(m) = pose.turn.transpose() * (now.col(m) - pose.origin) - segment.shape.col(m);
    square += deformation.squaredNorm();
  }
  const double markers = static_cast<double>(segment.shape.cols());
  segment.freedom = normal ? 2 * markers - 3 : 3 * markers - 6;
  const auto seen = std::ranges::count_if(segment.poses, &Pose::IsSeen);
  segment.marker_sd_mm = std::sqrt(square / (static_cast<double>(seen) * segment.freedom));
  return segment;
}

}  // namespace lake::dynamics
