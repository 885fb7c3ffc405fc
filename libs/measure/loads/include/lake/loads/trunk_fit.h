// Where the trunk's centre of mass is: fitted so that the zero-moment point lies within the foot and moves slowly.
//
// The trunk's centre is  H + (table + along + a_r) u + (across + b_r) n + w(t) x,  u and n the trunk's axes. What no
// rigid trunk has: a_r and b_r are each rise's own (another bend of the spine, other arms), w is a cubic B-spline
// (head and arms move, markers slide on skin). With all forces from the trunk down, the ground's force acts at zmp(t);
// a person keeps that within the foot, and does not shake it:
//
//   minimise  Σ_i (z_i − ρ_i z_{i−1})² / (s² (1 − ρ_i²))  +  along²/.. + across²/.. + habit²/.. + Σ (a_r² + b_r²)/..
//   + Σ w_k²/..,          z_i = zmp(t_i) − place(t_i) − habit,    ρ_i = exp(−(t_i − t_{i−1}) / memory)
//
// over the times when the feet alone bear the body. A Gauss–Newton solve with its covariance.
#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <random>
#include <vector>

#include "lake/loads/leg_dynamics.h"
#include "lake/loads/spline_grid.h"

namespace lake::loads {

// Standard deviations of what is not known beforehand.
struct TrunkPrior {
  double along_m = 0.06, across_m = 0.03;  // of the centre, from where the table has it (a shoulder marker is no joint)
  double across_from_waist_m = 0.08;       // where the hip–waist vector stands for the trunk: it leans otherwise
  // Where on the foot the zero-moment point is on average, from the heel: it lies back when the seat is left, and comes
  // forward while rising. Between the two by the thigh's tilt.
  double place_seated = 0.3, place_standing = 0.5;
  double spread = 0.25;         // of the foot's length: how far it is from there: the ends are 2 SD away
  double habit_m = 0.025;       // a person's own, for the whole trial
  double memory_s = 0.3;        // over which time it keeps its place
  double posture_m = 0.02;      // along and across, of each rise beside the others
  double wobble_m = 0.01;       // of each coefficient of w
  double wobble_step_s = 0.08;  // between them
};

// Frames [begin, end) in which the feet alone bear the body.
struct Window {
  std::size_t begin = 0, end = 0;
};

class TrunkFit {
 public:
  // Throws Error if no window has a frame.
  TrunkFit(const LegPath& path, const LegBody& body, const std::vector<Window>& windows, const TrunkPrior& prior);

  double AlongM() const { return common_[0]; }
  double AcrossM() const { return common_[1]; }
  Eigen::Vector2d SigmaM() const { return common_covariance_.diagonal().head<2>().cwiseSqrt(); }

  // Along and across, with the posture of the rise in whose window the frame is.
  Eigen::Vector2d InTrunkM(std::size_t frame) const;

  // At a frame: fixed in the trunk and, within the windows, w.
  Displacement At(const LegPath& path, std::size_t frame) const;

  // Another trunk that the data allow as well, with the probability that the fit gives it.
  TrunkFit Draw(std::mt19937_64& random) const;

 private:
  struct Piece {
    Window window;
    SplineGrid grid;
    Eigen::VectorXd own;                 // the wobble's coefficients, then a_r and b_r
    Eigen::LLT<Eigen::MatrixXd> factor;  // of their normal matrix
    Eigen::MatrixXd coupling;            // of theirs with what is common, × 3
    Eigen::VectorXd right;
  };
  void Linearize(const LegPath& path, const LegBody& body, const TrunkPrior& prior);
  void Accumulate(const LegPath& path, const LegBody& body, const TrunkPrior& prior, Piece& piece,
                  Eigen::Matrix3d& normal, Eigen::Vector3d& right) const;
  const Piece* PieceAt(std::size_t frame) const;

  std::vector<Piece> pieces_;
  Eigen::Vector3d common_ = Eigen::Vector3d::Zero();  // along, across, the habit
  Eigen::Matrix3d common_covariance_ = Eigen::Matrix3d::Zero();
};

}  // namespace lake::loads
