#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "hinge_fit.h"

namespace lake::axis {
namespace {

using Eigen::MatrixXd, Eigen::Vector2d, Eigen::Vector3d, Eigen::VectorXd;

constexpr int kPlaces = 41;  // over the range of angles

// Where the centre is against the hinge's point in the shank, at places over the range of angles; mean and variance,
// each way, over the suppositions on the errors.
struct CentrePath {
  double low_rad = 0, high_rad = 0;
  Eigen::Matrix2Xd place_mm;
  VectorXd variance_mm2;

  // The place before an angle, and how far it is on the way to the next.
  std::pair<Eigen::Index, double> At(double angle_rad) const {
    const double place = (angle_rad - low_rad) / (high_rad - low_rad) * (kPlaces - 1);
    const auto before = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(place), 0, kPlaces - 2);
    return {before, place - static_cast<double>(before)};
  }
};

CentrePath CentrePathOf(const HingeFit& fit, const VectorXd& unknowns, const std::vector<ErrorModel>& errors) {
  const auto [least, most] = std::ranges::minmax_element(fit.Equations(), {}, &HingeEquation::angle_rad);
  CentrePath path{least->angle_rad, most->angle_rad, Eigen::Matrix2Xd::Zero(2, kPlaces), VectorXd::Zero(kPlaces)};
  const double markers = fit.MarkersAtJoint_mm();
  const double joint_share = kJointStray_mm * kJointStray_mm / (kJointStray_mm * kJointStray_mm + markers * markers);
  const std::vector<HingeEquation>& blocks = fit.Blocks();
  const auto n = static_cast<Eigen::Index>(blocks.size());
  Eigen::MatrixX2d strays(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) strays.row(i) = blocks[static_cast<std::size_t>(i)].Stray(unknowns).transpose();
  for (const ErrorModel& model : errors) {
    const double variance = model.repeated_mm * model.repeated_mm, memory = model.angle_memory_rad;
    MatrixXd value(n, kPlaces), slope(n, kPlaces);  // covariances of the blocks with j and with its slope
    for (Eigen::Index i = 0; i < n; ++i)
      for (int k = 0; k < kPlaces; ++k) {
        const double angle = path.low_rad + (path.high_rad - path.low_rad) * k / (kPlaces - 1);
        const double difference = angle - blocks[static_cast<std::size_t>(i)].angle_rad;
        value(i, k) = variance * Covariance(difference, memory);
        slope(i, k) = variance * CovarianceSlope(difference, memory);
      }
    const Eigen::LLT<MatrixXd> factor(BlockCovariance(blocks, model));
    factor.matrixL().solveInPlace(value);
    factor.matrixL().solveInPlace(slope);
    const Eigen::Matrix2Xd whitened = Eigen::MatrixX2d(factor.matrixL().solve(strays)).transpose();
    const Eigen::Matrix2Xd stray = whitened * value, change = whitened * slope;
    Eigen::Matrix2Xd centre(2, kPlaces);
    centre << stray.row(0) - change.row(1), stray.row(1) + change.row(0);
    centre *= joint_share;
    const double before = variance * (1 + 1 / (memory * memory));
    for (int k = 0; k < kPlaces; ++k) {
      const double known = value.col(k).squaredNorm() + slope.col(k).squaredNorm();
      path.variance_mm2[k] += model.probability * (joint_share * before - joint_share * joint_share * known +
                                                   centre.col(k).squaredNorm() / 2);
    }
    path.place_mm += model.probability * centre;
  }
  path.variance_mm2 -= path.place_mm.colwise().squaredNorm().transpose() / 2;
  return path;
}

}  // namespace

std::vector<InstantaneousCentre> InstantaneousCentres(const SegmentMotion& motion, const MeanAxesResult& axes) {
  const std::vector<double> angles = KneeAngles(motion, axes.whole);
  std::vector<std::size_t> frames;
  for (std::size_t i = 0; i < angles.size(); ++i)
    if (std::isfinite(angles[i])) frames.push_back(i);
  const AxisFrames across = AxisFramesOf(motion, frames);
  const HingeFit fit(motion, EquationsOf(motion, frames, across));
  const HingeSolution hinge = fit.Solve(axes.errors.models);
  const CentrePath path = CentrePathOf(fit, hinge.unknowns, axes.errors.models);
  const auto shank_modes = motion.shank.deformation.modes.cols();
  std::vector<InstantaneousCentre> centres;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const auto [before, share] = path.At(fit.Equations()[k].angle_rad);
    Eigen::Matrix2Xd rows = -fit.Equations()[k].rows;  // of the shank's point alone
    rows.leftCols<2>().setZero();
    rows.rightCols(rows.cols() - 4 - 2 * shank_modes).setZero();
    const Vector2d place =
        rows * hinge.unknowns + (1 - share) * path.place_mm.col(before) + share * path.place_mm.col(before + 1);
    const double stray = (1 - share) * path.variance_mm2[before] + share * path.variance_mm2[before + 1];
    const Eigen::Matrix2d covariance = rows * hinge.covariance * rows.transpose() + stray * Eigen::Matrix2d::Identity();
    const Pose& shank = motion.shank.poses[frames[k]];
    InstantaneousCentre c{frames[k], angles[frames[k]], across.shank.leftCols<2>() * place, {}, {}};
    c.in_file = shank.turn * c.in_shank + shank.origin;
    c.sd_mm = (across.shank.leftCols<2>() * covariance * across.shank.leftCols<2>().transpose()).diagonal().cwiseSqrt();
    centres.push_back(c);
  }
  return centres;
}

}  // namespace lake::axis
