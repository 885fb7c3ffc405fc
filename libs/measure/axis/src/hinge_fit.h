// The hinge between two segments as a linear problem in the plane across its axis, and the errors that keep them from
// it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lake/axis/functional_axis.h"

namespace lake::axis {

// Frames whose first two columns lie across the axis and whose third is the axis, of both segments. `thigh_along_mm`:
// where the plane through the mean of the shank's markers cuts the axis, along it from the mean of the thigh's.
struct AxisFrames {
  Eigen::Matrix3d shank, thigh;
  double thigh_along_mm = 0;
};

// The frames' mean axis: the directions that the rotations take to each other best.
AxisFrames AxisFramesOf(const SegmentMotion& motion, const std::vector<std::size_t>& frames);

// rows · unknowns + offset = how far the two points stand apart, mm. Unknowns: thigh's point, shank's point, then two
// of each mode of the shank's deformation, and of the thigh's.
struct HingeEquation {
  double frame = 0;
  double angle_rad = 0;  // of the thigh on the shank about the axis, continuous
  double share = 1;      // of the range of angles, 1 on average
  double weight = 1;     // the share, and Huber's weight
  Eigen::Matrix2Xd rows;
  Eigen::Vector2d offset;

  Eigen::Vector2d Stray(const Eigen::VectorXd& unknowns) const { return rows * unknowns + offset; }
};

std::vector<HingeEquation> EquationsOf(const SegmentMotion& motion, const std::vector<std::size_t>& frames,
                                       const AxisFrames& axis);

struct HingeSolution {
  Eigen::VectorXd unknowns;
  Eigen::MatrixXd covariance;
};

// How far a knee's own motion strays from a hinge, each way: 0.4 mm in the root mean square over 0 to 90 degrees in the
// planar model of Yamaguchi & Zajac (compare's knee_axis.h), and people differ.
inline constexpr double kJointStray_mm = 1;

double PinStrayMm(const std::vector<ErrorModel>& errors);

// With what is known of the pin from the whole recording.
HingeSolution WithWhole(HingeSolution own, const AxisFrames& axis, const LearntErrors& learnt);

// The equations of some frames, and means over blocks of neighbours, few enough for full covariances.
class HingeFit {
 public:
  // `learnt`: from the whole recording, of which these frames are a part; else nothing is known before.
  HingeFit(const SegmentMotion& motion, std::vector<HingeEquation> equations, const LearntErrors* learnt = nullptr);

  LearntErrors LearnErrors(const AxisFrames& axis) const;
  HingeSolution Solve(const std::vector<ErrorModel>& errors) const;

  const std::vector<HingeEquation>& Equations() const { return equations_; }
  const std::vector<HingeEquation>& Blocks() const { return blocks_; }
  // What the markers' errors, if independent, leave at the joint, along each axis.
  double MarkersAtJoint_mm() const { return markers_at_joint_mm_; }

 private:
  void SetPrior(const SegmentMotion& motion, const LearntErrors* learnt);
  void SolveCorrected(const SegmentMotion& motion);
  double LogLikelihood(const Eigen::MatrixXd& covariance) const;

  std::vector<HingeEquation> equations_, blocks_;
  Eigen::MatrixXd prior_precision_;  // of the unknowns, per mm²
  Eigen::VectorXd prior_mean_;
  double residual_mm_ = 0;  // along each axis
  double markers_at_joint_mm_ = 0;
  double shank_share_ = 0;  // of that variance
  Eigen::VectorXd unknowns_;
  Eigen::MatrixXd inverse_;  // of the corrected normal matrix of the blocks
};

// Covariances at a difference, for a variance of 1; and the derivative with respect to the first angle.
double Covariance(double difference, double memory);
double CovarianceSlope(double difference, double memory);
// Of the blocks' errors, mm².
Eigen::MatrixXd BlockCovariance(const std::vector<HingeEquation>& blocks, const ErrorModel& errors);

}  // namespace lake::axis
