#include "hinge_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <utility>

#include "lake/core/statistics.h"

namespace lake::axis {
namespace {

using Eigen::Matrix2d, Eigen::Matrix3d, Eigen::MatrixXd, Eigen::Vector2d, Eigen::Vector3d, Eigen::VectorXd;

constexpr Eigen::Index kPoints = 4;        // unknowns of the two points
constexpr double kLeast_mm = 1e-6;         // exact points have errors of rounding
constexpr double kLeastMemory_rad = 0.35;  // over which errors that repeat with the angle are alike
constexpr double kNoiseShare = 0.05;       // of the residual: what changes from block to block

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

// The thigh's origin in the shank's frame.
Vector3d OffsetOf(const SegmentMotion& motion, std::size_t frame) {
  const Pose &shank = motion.shank.poses[frame], &thigh = motion.thigh.poses[frame];
  return shank.turn.transpose() * (thigh.origin - shank.origin);
}

VectorXd SolveWeighted(const std::vector<HingeEquation>& equations, const MatrixXd& precision, const VectorXd& mean) {
  MatrixXd normal = precision;
  VectorXd right = precision * mean;
  for (const HingeEquation& e : equations) {
    normal += e.weight * e.rows.transpose() * e.rows;
    right -= e.weight * e.rows.transpose() * e.offset;
  }
  return normal.ldlt().solve(right);
}

// All angles count alike, however long a person stays at one: frames whose errors repeat with the angle share them.
void SetShares(std::vector<HingeEquation>& equations) {
  std::vector<double> angles;
  angles.reserve(equations.size());
  for (const HingeEquation& e : equations) angles.push_back(e.angle_rad);
  std::ranges::sort(angles);
  double sum = 0;
  for (HingeEquation& e : equations) {
    const double from = std::max(angles.front(), e.angle_rad - kLeastMemory_rad);
    const double to = std::min(angles.back(), e.angle_rad + kLeastMemory_rad);
    const auto frames =
        std::upper_bound(angles.begin(), angles.end(), to) - std::lower_bound(angles.begin(), angles.end(), from);
    e.share = (to - from) / static_cast<double>(frames);
    sum += e.share;
  }
  for (HingeEquation& e : equations) {
    e.share = sum > 0 ? e.share * static_cast<double>(equations.size()) / sum : 1;  // 0 where nothing turns
    e.weight = e.share;
  }
}

// Slow errors are no outliers: what is weighed less is far from all others.
VectorXd SolveRobustly(std::vector<HingeEquation>& equations, const MatrixXd& precision, const VectorXd& mean) {
  constexpr double kFar = 3;  // medians of the distances: 3.5 standard deviations of normal ones
  constexpr int kRounds = 10;
  VectorXd unknowns;
  for (int round = 0; round < kRounds; ++round) {
    unknowns = SolveWeighted(equations, precision, mean);
    std::vector<double> sizes;
    for (const HingeEquation& e : equations) sizes.push_back(e.Stray(unknowns).norm());
    const double scale = kFar * Median(sizes);
    for (std::size_t i = 0; i < sizes.size(); ++i)
      equations[i].weight = equations[i].share * (sizes[i] > scale ? scale / sizes[i] : 1);
  }
  return unknowns;
}

double ResidualOf(const std::vector<HingeEquation>& equations, const VectorXd& unknowns) {
  double square = 0;
  for (const HingeEquation& e : equations) square += e.Stray(unknowns).squaredNorm();
  return std::max(std::sqrt(square / (2 * static_cast<double>(equations.size()))), kLeast_mm);
}

// Means over neighbours: the errors hardly change from one frame to the next.
std::vector<HingeEquation> BlocksOf(const std::vector<HingeEquation>& equations) {
  constexpr std::size_t kMostBlocks = 120, kMostFrames = 20;
  const std::size_t frames = std::clamp<std::size_t>(equations.size() / kMostBlocks, 1, kMostFrames);
  const std::size_t all = equations.size() / frames, count = std::min(all, kMostBlocks);
  std::vector<HingeEquation> blocks;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t first = k * all / count * frames;
    HingeEquation block = equations[first];
    for (std::size_t i = first + 1; i < first + frames; ++i) {
      block.frame += equations[i].frame;
      block.angle_rad += equations[i].angle_rad;
      block.weight += equations[i].weight;
      block.rows += equations[i].rows;
      block.offset += equations[i].offset;
    }
    const double n = static_cast<double>(frames);
    block.frame /= n;
    block.angle_rad /= n;
    block.weight /= n;
    block.rows /= n;
    block.offset /= n;
    blocks.push_back(std::move(block));
  }
  return blocks;
}

}  // namespace

AxisFrames AxisFramesOf(const SegmentMotion& motion, const std::vector<std::size_t>& frames) {
  Matrix3d mean = Matrix3d::Zero();
  for (std::size_t frame : frames) mean += TurnOf(motion, frame) / static_cast<double>(frames.size());
  // Σ |turn · a − b|² is least for the first singular vectors of the mean turn.
  const Eigen::JacobiSVD<Matrix3d> svd(mean, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = svd.matrixU()(2, 0) < 0 ? -1 : 1;
  AxisFrames axis{AcrossAndAlong(sign * svd.matrixU().col(0)), AcrossAndAlong(sign * svd.matrixV().col(0)), 0};
  for (std::size_t frame : frames)
    axis.thigh_along_mm -= axis.shank.col(2).dot(OffsetOf(motion, frame)) / static_cast<double>(frames.size());
  return axis;
}

std::vector<HingeEquation> EquationsOf(const SegmentMotion& motion, const std::vector<std::size_t>& frames,
                                       const AxisFrames& axis) {
  const MatrixXd &shank = motion.shank.deformation.modes, &thigh = motion.thigh.deformation.modes;
  std::vector<HingeEquation> equations;
  for (std::size_t frame : frames) {
    const Matrix3d turn = axis.shank.transpose() * TurnOf(motion, frame) * axis.thigh;
    HingeEquation e;
    e.frame = static_cast<double>(frame);
    e.angle_rad = std::atan2(turn(1, 0) - turn(0, 1), turn(0, 0) + turn(1, 1));
    if (!equations.empty())
      e.angle_rad = equations.back().angle_rad + std::remainder(e.angle_rad - equations.back().angle_rad, 2 * M_PI);
    e.offset =
        axis.shank.leftCols<2>().transpose() * OffsetOf(motion, frame) + axis.thigh_along_mm * turn.col(2).head<2>();
    e.rows.resize(2, kPoints + 2 * (shank.cols() + thigh.cols()));
    e.rows.leftCols<kPoints>() << turn.topLeftCorner<2, 2>(), -Matrix2d::Identity();
    const auto row = static_cast<Eigen::Index>(frame);
    Eigen::Index column = kPoints;
    for (Eigen::Index mode = 0; mode < shank.cols(); ++mode, column += 2)
      e.rows.middleCols<2>(column) = -shank(row, mode) * Matrix2d::Identity();
    for (Eigen::Index mode = 0; mode < thigh.cols(); ++mode, column += 2)
      e.rows.middleCols<2>(column) = thigh(row, mode) * turn.topLeftCorner<2, 2>();
    equations.push_back(std::move(e));
  }
  return equations;
}

// A Matérn function of order 3/2: once differentiable.
double Covariance(double difference, double memory) {
  const double distance = std::abs(difference) / memory;
  return (1 + distance) * std::exp(-distance);
}

double CovarianceSlope(double difference, double memory) {
  return -difference / (memory * memory) * std::exp(-std::abs(difference) / memory);
}

namespace {

template <typename Difference>
MatrixXd Covariances(const std::vector<HingeEquation>& blocks, double memory, Difference difference) {
  const auto n = static_cast<Eigen::Index>(blocks.size());
  MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j)
      covariance(i, j) = covariance(j, i) =
          Covariance(difference(blocks[static_cast<std::size_t>(i)], blocks[static_cast<std::size_t>(j)]), memory);
  return covariance;
}

MatrixXd OverAngle(const std::vector<HingeEquation>& blocks, double memory_rad) {
  return Covariances(blocks, memory_rad, [](const auto& a, const auto& b) { return a.angle_rad - b.angle_rad; });
}

MatrixXd OverTime(const std::vector<HingeEquation>& blocks, double memory_frames) {
  return Covariances(blocks, memory_frames, [](const auto& a, const auto& b) { return a.frame - b.frame; });
}

MatrixXd Sum(const MatrixXd& over_angle, const MatrixXd& over_time, const ErrorModel& errors) {
  MatrixXd sum = errors.repeated_mm * errors.repeated_mm * over_angle + errors.slow_mm * errors.slow_mm * over_time;
  sum.diagonal().array() += errors.noise_mm * errors.noise_mm;
  return sum;
}

}  // namespace

MatrixXd BlockCovariance(const std::vector<HingeEquation>& blocks, const ErrorModel& errors) {
  return Sum(OverAngle(blocks, errors.angle_memory_rad), OverTime(blocks, errors.memory_frames), errors);
}

HingeFit::HingeFit(const SegmentMotion& motion, std::vector<HingeEquation> equations, const LearntErrors* learnt)
    : equations_(std::move(equations)) {
  SetShares(equations_);
  SetPrior(motion, learnt);
  const VectorXd rough = SolveRobustly(equations_, prior_precision_, prior_mean_);
  residual_mm_ = learnt ? learnt->residual_mm : ResidualOf(equations_, rough);
  blocks_ = BlocksOf(equations_);
  SolveCorrected(motion);
}

void HingeFit::SetPrior(const SegmentMotion& motion, const LearntErrors* learnt) {
  const Deformation &shank = motion.shank.deformation, &thigh = motion.thigh.deformation;
  const Eigen::Index shank_unknowns = 2 * shank.modes.cols(), thigh_unknowns = 2 * thigh.modes.cols();
  const Eigen::Index carried = shank_unknowns + thigh_unknowns;
  prior_mean_ = VectorXd::Zero(kPoints + carried);
  prior_precision_ = MatrixXd::Zero(kPoints + carried, kPoints + carried);
  // At first without the deformation, to know where about the joint is.
  prior_precision_.diagonal().tail(carried).setConstant(1 / (kLeast_mm * kLeast_mm));
  const VectorXd plain = SolveRobustly(equations_, prior_precision_, prior_mean_);
  const double shank_mm = plain.segment<2>(2).norm(), thigh_mm = plain.head<2>().norm();
  const double shank_lever = shank_mm / shank.radius_mm, thigh_lever = thigh_mm / thigh.radius_mm;
  const double shank_sd_mm = shank.PointSdMm(shank_mm), thigh_sd_mm = thigh.PointSdMm(thigh_mm);
  const double both_mm = std::hypot(shank_sd_mm, thigh_sd_mm);
  markers_at_joint_mm_ = std::max(both_mm, kLeast_mm);
  shank_share_ = both_mm > 0 ? std::pow(shank_sd_mm / both_mm, 2) : 0.5;
  if (learnt) {
    prior_mean_.tail(carried) = learnt->carried;
    prior_precision_.bottomRightCorner(carried, carried) = learnt->carried_covariance.inverse();
  } else {
    // A cluster that is strained alike throughout carries its deformation to the joint in proportion to the distance.
    prior_precision_.diagonal().segment(kPoints, shank_unknowns).setConstant(1 / (shank_lever * shank_lever));
    prior_precision_.diagonal().tail(thigh_unknowns).setConstant(1 / (thigh_lever * thigh_lever));
  }
}

// Errors of the turns are the points' own times the lever, and draw the points towards the markers: their expected part
// of the normal matrix is taken away, as far as it is well below the rest.
void HingeFit::SolveCorrected(const SegmentMotion& motion) {
  constexpr double kLeastShare = 0.3;  // of the least eigenvalue that must remain
  constexpr double kLess = 0.8;
  const auto size = prior_mean_.size();
  const MatrixXd prior = residual_mm_ * residual_mm_ * prior_precision_;
  MatrixXd normal = prior;
  VectorXd right = prior * prior_mean_;
  for (const HingeEquation& block : blocks_) {
    normal += block.weight * block.rows.transpose() * block.rows;
    right -= block.weight * block.rows.transpose() * block.offset;
  }
  VectorXd pull = VectorXd::Zero(size);
  pull.head<2>().setConstant(std::pow(motion.thigh.deformation.pose_sd_rad, 2));
  pull.segment<2>(2).setConstant(std::pow(motion.shank.deformation.pose_sd_rad, 2));
  double frames = 0;
  for (const HingeEquation& block : blocks_) frames += block.weight;
  pull *= frames;
  const auto least = [](const MatrixXd& matrix) {
    return Eigen::SelfAdjointEigenSolver<MatrixXd>(matrix, Eigen::EigenvaluesOnly).eigenvalues()[0];
  };
  const double before = least(normal);
  while (least(normal - MatrixXd(pull.asDiagonal())) < kLeastShare * before) pull *= kLess;
  normal -= pull.asDiagonal();
  inverse_ = normal.inverse();
  unknowns_ = inverse_ * right;
}

// A segment's frame is its markers' mean over these frames: what of its errors is alike in all of them moves its point
// and its frame together, and is no error of the axis' place. So the errors count about their mean: those of the shank
// in its axes, those of the thigh in its own.
HingeSolution HingeFit::Solve(const std::vector<ErrorModel>& errors) const {
  const auto n = static_cast<Eigen::Index>(blocks_.size());
  const Eigen::Index unknowns = unknowns_.size();
  MatrixXd in_shank(n, 2 * unknowns), in_thigh(n, 2 * unknowns);
  for (Eigen::Index i = 0; i < n; ++i) {
    const HingeEquation& block = blocks_[static_cast<std::size_t>(i)];
    const Eigen::Matrix2Xd rows = block.weight * block.rows, turned = block.rows.leftCols<2>().transpose() * rows;
    in_shank.row(i) << rows.row(0), rows.row(1);
    in_thigh.row(i) << turned.row(0), turned.row(1);
  }
  in_shank.rowwise() -= in_shank.colwise().mean().eval();
  in_thigh.rowwise() -= in_thigh.colwise().mean().eval();
  MatrixXd covariance = MatrixXd::Zero(n, n);
  for (const ErrorModel& model : errors) covariance += model.probability * BlockCovariance(blocks_, model);
  MatrixXd middle = std::pow(residual_mm_, 4) * prior_precision_;
  for (const auto& [design, share] : {std::pair(&in_shank, shank_share_), std::pair(&in_thigh, 1 - shank_share_)}) {
    const MatrixXd square = design->transpose() * covariance * *design;
    middle += share * (square.topLeftCorner(unknowns, unknowns) + square.bottomRightCorner(unknowns, unknowns));
  }
  return {unknowns_, inverse_ * middle * inverse_};
}

// How far a pin that fits a part of the range strays from that of the whole, along each axis, by what repeats with the
// angle and is the joint's: as an instantaneous centre does, by that and by its slope. A joint strays as a knee does at
// most, and by no more than the recording shows.
double PinStrayMm(const std::vector<ErrorModel>& errors) {
  double variance_mm2 = 0;
  for (const ErrorModel& model : errors)
    variance_mm2 += model.probability * std::pow(std::min(kJointStray_mm, model.repeated_mm), 2) *
                    (1 + std::pow(model.angle_memory_rad, -2));
  return std::sqrt(variance_mm2);
}

// How much of the whole's errors is in this part's own is not known: its weight is that of independent ones, the
// covariance that of common ones.
HingeSolution WithWhole(HingeSolution own, const AxisFrames& axis, const LearntErrors& learnt) {
  const Eigen::Index shank = 2, unknowns = own.unknowns.size();
  const Matrix2d own_pin = own.covariance.block<2, 2>(shank, shank);
  const double stray_mm2 = std::pow(PinStrayMm(learnt.models), 2), whole_mm2 = learnt.pin_sd_mm * learnt.pin_sd_mm;
  const Matrix2d both = own_pin + (stray_mm2 + whole_mm2) * Matrix2d::Identity();
  const MatrixXd gain = own.covariance.middleCols<2>(shank) * both.inverse();
  const Vector2d whole = axis.shank.leftCols<2>().transpose() * learnt.pin_in_shank;
  own.unknowns += gain * (whole - own.unknowns.segment<2>(shank));
  MatrixXd kept = MatrixXd::Identity(unknowns, unknowns);
  kept.middleCols<2>(shank) -= (1 - std::min(1.0, std::sqrt(2 * whole_mm2 / own_pin.trace()))) * gain;
  own.covariance = kept * own.covariance * kept.transpose() + stray_mm2 * gain * gain.transpose();
  return own;
}

// Restricted, by generalised least squares.
double HingeFit::LogLikelihood(const MatrixXd& covariance) const {
  const auto n = static_cast<Eigen::Index>(blocks_.size()), unknowns = unknowns_.size();
  const Eigen::LLT<MatrixXd> factor(covariance);
  MatrixXd x(n, unknowns + 1), y(n, unknowns + 1);
  for (Eigen::Index i = 0; i < n; ++i) {
    const HingeEquation& block = blocks_[static_cast<std::size_t>(i)];
    x.row(i) << block.rows.row(0), block.offset.x();
    y.row(i) << block.rows.row(1), block.offset.y();
  }
  factor.matrixL().solveInPlace(x);
  factor.matrixL().solveInPlace(y);
  MatrixXd square = x.transpose() * x + y.transpose() * y;
  square.topLeftCorner(unknowns, unknowns) += prior_precision_;
  const Eigen::LLT<MatrixXd> normal(square.topLeftCorner(unknowns, unknowns));
  const VectorXd right = square.col(unknowns).head(unknowns);
  const auto log_sum = [](const Eigen::LLT<MatrixXd>& llt) { return llt.matrixLLT().diagonal().array().log().sum(); };
  return -0.5 * (square(unknowns, unknowns) - right.dot(normal.solve(right))) - 2 * log_sum(factor) - log_sum(normal);
}

LearntErrors HingeFit::LearnErrors(const AxisFrames& axis) const {
  constexpr double kAngleMemories[] = {kLeastMemory_rad, 2 * kLeastMemory_rad, 4 * kLeastMemory_rad};
  constexpr double kFrameMemories[] = {5, 20, 80};
  constexpr double kRepeated[] = {0.125, 0.25, 0.5, 1, 2, 4};  // of what the markers' deformation lets expect
  constexpr double kSlow[] = {0.25, 0.5, 1, 2};                // of the residual
  constexpr double kSpread = 0.7;                              // of the logarithm of what is expected
  constexpr double kLeastProbability = 0.01;
  std::vector<MatrixXd> over_time;
  for (const double memory : kFrameMemories) over_time.push_back(OverTime(blocks_, memory));
  std::vector<ErrorModel> models;
  std::vector<double> logs;
  for (const double angle_memory : kAngleMemories) {
    const MatrixXd over_angle = OverAngle(blocks_, angle_memory);
    for (const double repeated : kRepeated)
      for (std::size_t t = 0; t < over_time.size(); ++t)
        for (const double slow : kSlow) {
          models.push_back({.probability = 0,
                            .repeated_mm = repeated * markers_at_joint_mm_,
                            .angle_memory_rad = angle_memory,
                            .slow_mm = slow * residual_mm_,
                            .memory_frames = kFrameMemories[t],
                            .noise_mm = kNoiseShare * residual_mm_});
          logs.push_back(LogLikelihood(Sum(over_angle, over_time[t], models.back())) -
                         0.5 * std::pow(std::log(repeated) / kSpread, 2));
        }
  }
  const double most = *std::ranges::max_element(logs);
  for (std::size_t i = 0; i < models.size(); ++i) models[i].probability = std::exp(logs[i] - most);
  std::erase_if(models, [](const ErrorModel& model) { return model.probability < kLeastProbability; });
  double sum = 0;
  for (const ErrorModel& model : models) sum += model.probability;
  for (ErrorModel& model : models) model.probability /= sum;
  const HingeSolution solution = Solve(models);
  const Eigen::Index carried = unknowns_.size() - kPoints;
  return {.models = std::move(models),
          .residual_mm = residual_mm_,
          .carried = solution.unknowns.tail(carried),
          .carried_covariance = solution.covariance.bottomRightCorner(carried, carried),
          .pin_in_shank = axis.shank.leftCols<2>() * solution.unknowns.segment<2>(2),
          .pin_sd_mm = std::sqrt(solution.covariance.diagonal().segment<2>(2).mean())};
}

}  // namespace lake::axis
