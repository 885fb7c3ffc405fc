// The leg as functions of time, and the one least-squares problem that determines them.
//
//   state s(t) = (A_x, A_y, θ_shank, θ_thigh, |AK|, |KH|, θ_trunk, |HW|) = Σ_k B_k(t) c_k     cubic B-splines, c_k all
//   at once markers      K = A + |AK| (sin θ_shank, cos θ_shank),  H = K + |KH| (sin θ_thigh, cos θ_thigh),  W likewise
//   minimise     Σ ρ( |π(marker(t_i)) − seen_i|² / σ_i² )  +  Σ_k (Δ³c_k)² / q_k  +  Σ_k (Δ¹|·|_k)² / p
//
// π is the view (camera, plane, depth), ρ Tukey's biweight, Δ differences of neighbouring coefficients, q_k and p
// variances per component of the state. Positions in the leg frame's axes, angles in rad, from the vertical. Not part
// of the library's interface.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "lake/gait/banded_matrix.h"
#include "lake/gait/leg_view.h"
#include "lake/gait/smoothing_spline.h"

namespace lake::gait {

enum LegState { kAnkleX, kAnkleY, kShankAngle, kThighAngle, kShankLength, kThighLength, kTrunkAngle, kTrunkLength };
inline constexpr int kLegStates = 8, kLegStatesWithoutTrunk = 6;

enum LegMarker : std::uint8_t { kAnkle, kKnee, kHip, kWaist };
inline constexpr int kLegMarkers = 4;

// Small, as there are four of every frame.
struct LegObservation {
  Eigen::Vector2d seen;     // as recorded
  double sigma = 1;         // per axis, as stated
  double jolt = 0;          // recorded unit: see Detections
  std::uint32_t frame = 0;  // index into the recording
  LegMarker marker = kAnkle;
  bool trusted = true;  // false: judged by what the others predict
};

struct LegPrior {
  std::vector<double> roughness;           // q, per third difference
  std::vector<double> possible_roughness;  // ≥ q: of what may have happened in gaps; for the covariance
  double slope_variance = 0;               // p; 0: no such term
};

struct LegModel {
  SplineGrid grid;
  LegView view;
  Eigen::Matrix2d plane_from_leg;  // rotation, or reflection for a subject who faces left
  int states = kLegStates;
  std::array<LegPrior, kLegStates> priors;
  std::vector<double> time_s;                     // of the frames
  std::array<double, kLegMarkers> depth_mm = {};  // of the markers
  std::vector<LegObservation> observations;       // frames increase
  double outlier_deviations = 7;                  // the biweight reaches zero at so many deviations and a jolt
  std::size_t knots_per_piece = 2048;             // that are solved at once
  double piece_margin_s = 2;

  // Of the noise's deviations over the stated sigmas, and of the noise in the variances about the smooth paths, frame
  // by frame; the rest the markers did themselves. Empty: 1.
  std::array<double, kLegMarkers> sigma_scale = {1, 1, 1, 1};
  std::array<std::vector<double>, kLegMarkers> noise_share;

  double NoiseShare(LegMarker m, std::size_t frame) const { return noise_share[m].empty() ? 1 : noise_share[m][frame]; }
  double Sigma(const LegObservation& o) const { return o.sigma * sigma_scale[o.marker]; }
  // An observation's deviation about the smooth path, and where its residual has no weight at all, in such deviations.
  double Scatter(const LegObservation& o) const { return Sigma(o) / std::sqrt(NoiseShare(o.marker, o.frame)); }
  double OutlierLimit(const LegObservation& o) const { return outlier_deviations + o.jolt / Scatter(o); }
  // The coefficients that reach a frame's time, and what each contributes.
  SplineGrid::Place At(std::size_t frame) const { return grid.At(time_s[frame]); }
};

// A marker's position in the leg's axes from a state, for T = double or a Jet.
template <typename T>
Eigen::Matrix<T, 2, 1> MarkerInLeg(LegMarker marker, const T* state) {
  using std::cos, std::sin;
  Eigen::Matrix<T, 2, 1> point(state[kAnkleX], state[kAnkleY]);
  constexpr int kAngles[] = {kShankAngle, kThighAngle, kTrunkAngle},
                kLengths[] = {kShankLength, kThighLength, kTrunkLength};
  for (int segment = 0; segment < marker; ++segment) {
    const T &angle = state[kAngles[segment]], &length = state[kLengths[segment]];
    point += length * Eigen::Matrix<T, 2, 1>(sin(angle), cos(angle));
  }
  return point;
}

// Residual (predicted − seen, recorded unit) of an observation at the coefficients, and its derivative by the state
// there.
struct LegResidual {
  Eigen::Vector2d value;
  Eigen::Matrix<double, 2, kLegStates> by_state;
};
LegResidual EvaluateObservation(const LegModel& model, const LegObservation& observation,
                                const std::vector<double>& coefficients);

struct LegSolveSummary {
  bool usable = false;
  int iterations = 0;
  double initial_cost = 0, final_cost = 0;
  std::string message;
};

// From the given coefficients (grid.count × states) to the solution, by Ceres, which keeps every derivative (9 kB per
// frame): piece by piece, each with a margin on both sides that is given up.
LegSolveSummary SolveLegProblem(const LegModel& model, std::vector<double>& coefficients);

// ρ'(|r|²/σ²) of an observation: 1 for an ordinary one, 0 for an outlier.
double RobustWeight(const LegModel& model, const LegObservation& observation, const Eigen::Vector2d& residual);

// Whether a residual is so much smaller than the limit that it is no outlier: statistics of the noise count these, with
// equal weights (with the weights ρ' the noise would look smaller than it is).
bool IsOrdinary(const LegModel& model, const LegObservation& observation, const Eigen::Vector2d& residual);

// State, its derivative by time, and its covariance at a place.
using StateVector = Eigen::Matrix<double, kLegStates, 1>;
using StateMatrix = Eigen::Matrix<double, kLegStates, kLegStates>;
StateVector StateAt(const LegModel& model, const std::vector<double>& coefficients,
                    const std::array<double, 4>& weights, std::size_t first);

// One of each frame; symmetric, so half of it is kept.
class StateCovariances {
 public:
  explicit StateCovariances(std::size_t frames) : lower_(frames) {}

  void Set(std::size_t frame, const StateMatrix& covariance);
  StateMatrix At(std::size_t frame) const;

 private:
  std::vector<std::array<double, kLegStates*(kLegStates + 1) / 2>> lower_;
};

struct LegCovariances {
  StateCovariances state, rate;  // of the state and of its derivative by time
};

// By the inverse of the Gauss–Newton matrix. Throws SolverError if the data and the prior do not determine the
// coefficients.
LegCovariances CovariancesOf(const LegModel& model, const std::vector<double>& coefficients);

// One line of the prior: what a difference of coefficients of one component of the state adds to the sum.
struct PriorTerm {
  int state;
  std::array<double, 4> row;  // of a least-squares residual
};

// Those of the coefficients from the k-th to the one three further on.
std::vector<PriorTerm> PriorTerms(const LegModel& model, std::size_t k);
double PriorResidual(const LegModel& model, const PriorTerm& term, std::size_t k,
                     const std::vector<double>& coefficients);

}  // namespace lake::gait
