#include "leg_curves.h"

#include <ceres/jet.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "lake/core/angles.h"
#include "lake/core/statistics.h"

namespace lake::gait {
namespace {

using StateJet = ceres::Jet<double, kLegStates>;
using PointDerivative = Eigen::Matrix<double, 2, kLegStates>;

struct PointInLeg {
  Eigen::Vector2d position;
  PointDerivative by_state;
};

PointInLeg PointOf(LegMarker marker, const StateVector& state) {
  std::array<StateJet, kLegStates> jets;
  for (int s = 0; s < kLegStates; ++s) jets[static_cast<std::size_t>(s)] = StateJet(state[s], s);
  const Eigen::Matrix<StateJet, 2, 1> point = MarkerInLeg(marker, jets.data());
  PointInLeg result{{point[0].a, point[1].a}, {}};
  for (int i = 0; i < 2; ++i) result.by_state.row(i) = point[i].v.transpose();
  return result;
}

// What variances of the marker positions across the segments add to the knee angle's.
double KneeVarianceOfMarkers(const StateVector& state, double ankle, double knee, double hip) {
  const double shank = state[kShankLength], thigh = state[kThighLength],
               knee_rad = state[kShankAngle] - state[kThighAngle];
  return ankle / (shank * shank) + hip / (thigh * thigh) +
         knee * (1 / (shank * shank) + 1 / (thigh * thigh) + 2 * std::cos(knee_rad) / (shank * thigh));
}

using SlowNoises = std::array<std::vector<double>, kLegMarkers>;  // variances, recorded unit, per frame

SlowNoises FindSlowNoises(const motion::MarkerRecording& recording, const LegModel& model,
                          const std::vector<double>& coefficients, const StateCovariances& covariances) {
  std::array<std::vector<NoiseSample>, kLegMarkers> samples;
  std::array<double, kLegMarkers> variance = {};
  StateMatrix of_state;
  std::optional<std::size_t> frame;  // whose it is
  for (const LegObservation& o : model.observations) {
    const LegResidual residual = EvaluateObservation(model, o, coefficients);
    const double sigma2 = o.sigma * o.sigma;
    if (!IsOrdinary(model, residual.value, o.sigma)) continue;
    if (frame != o.frame) of_state = covariances.At(o.frame);
    frame = o.frame;
    const double used = (residual.by_state * of_state * residual.by_state.transpose()).trace() / sigma2;
    samples[o.marker].push_back({o.frame, 1 - used / 2, residual.value.squaredNorm() / sigma2 / 2});
    variance[o.marker] += sigma2;
  }
  SlowNoises slow;
  for (std::size_t m = 0; m < kLegMarkers; ++m) {
    slow[m] = SlowNoise(samples[m], recording.time_s);
    for (double& value : slow[m])
      value *= samples[m].empty() ? 0 : variance[m] / static_cast<double>(samples[m].size());
  }
  return slow;
}

// Moves of the markers off the smooth paths in one frame, in the leg's axes, and their variances per axis.
struct MarkerMoves {
  std::array<Eigen::Vector2d, kLegMarkers> move;
  std::array<double, kLegMarkers> variance = {};
};

// Of hidden markers the jitter is not known, but there. Outliers are no measurement of it.
std::vector<MarkerMoves> FindMoves(const LegModel& model, const std::vector<double>& coefficients,
                                   const std::vector<StateVector>& states,
                                   const std::array<Jitter, kLegMarkers>& jitters) {
  std::array<std::vector<double>, kLegMarkers> variances;
  std::vector<MarkerMoves> moves(states.size());
  std::vector<std::array<bool, kLegMarkers>> known(states.size());
  for (const LegObservation& o : model.observations) {
    const LegResidual residual = EvaluateObservation(model, o, coefficients);
    if (jitters[o.marker].share == 0 || !IsOrdinary(model, residual.value, o.sigma)) continue;
    const Eigen::Vector2d seen = PlaneFromRecorded(model.view, o.seen, model.depth_mm[o.marker]);
    const double scatter_variance =
        std::pow(o.sigma * PlaneUnitsPerRecorded(model.view, seen, model.depth_mm[o.marker]), 2);
    const Eigen::Vector2d smooth = PointOf(o.marker, states[o.frame]).position;
    moves[o.frame].move[o.marker] = jitters[o.marker].share * (model.plane_from_leg.transpose() * seen - smooth);
    moves[o.frame].variance[o.marker] = jitters[o.marker].VarianceWhereSeen(scatter_variance);
    known[o.frame][o.marker] = true;
    variances[o.marker].push_back(scatter_variance);
  }
  for (std::size_t m = 0; m < kLegMarkers; ++m) {
    const double hidden = variances[m].empty() ? 0 : jitters[m].VarianceWhereHidden(Median(variances[m]));
    for (std::size_t i = 0; i < moves.size(); ++i)
      if (!known[i][m]) moves[i].move[m].setZero(), moves[i].variance[m] = hidden;
  }
  return moves;
}

// The state whose markers lie where the moves put them.
void MoveMarkers(const MarkerMoves& moves, int states, StateVector& state, StateMatrix& covariance) {
  const int markers = states / 2;
  Eigen::MatrixXd by_state(states, states), variance = Eigen::MatrixXd::Zero(states, states);
  Eigen::VectorXd move(states);
  for (int m = 0; m < markers; ++m) {
    const auto index = static_cast<std::size_t>(m);
    by_state.middleRows<2>(2 * m) = PointOf(static_cast<LegMarker>(m), state).by_state.leftCols(states);
    move.segment<2>(2 * m) = moves.move[index];
    variance.diagonal().segment<2>(2 * m).setConstant(moves.variance[index]);
  }
  const Eigen::MatrixXd by_markers = by_state.inverse();
  state.head(states) += by_markers * move;
  covariance.topLeftCorner(states, states) += by_markers * variance * by_markers.transpose();
}

}  // namespace

double KneeVariance(const StateMatrix& covariance) {
  return covariance(kShankAngle, kShankAngle) + covariance(kThighAngle, kThighAngle) -
         2 * covariance(kShankAngle, kThighAngle);
}

std::vector<double> SlowNoise(const std::vector<NoiseSample>& samples, const std::vector<double>& time_s) {
  constexpr double kReach_s = 0.25;
  constexpr std::size_t kLeastSamples = 4;
  // The mean of 2n squares (two axes) scatters by 1/√n of itself; half of that is forgiven.
  constexpr double kForgiven = 0.5;
  std::vector<double> slow(time_s.size(), 0.0);
  double expected = 0, observed = 0;
  std::size_t begin = 0, end = 0;
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    for (; end < samples.size() && time_s[samples[end].frame] <= time_s[i] + kReach_s; ++end)
      expected += samples[end].expected, observed += samples[end].observed;
    for (; begin < end && time_s[samples[begin].frame] < time_s[i] - kReach_s; ++begin)
      expected -= samples[begin].expected, observed -= samples[begin].observed;
    const std::size_t count = end - begin;
    if (count < kLeastSamples) continue;
    const auto n = static_cast<double>(count);
    slow[i] = std::max(0.0, expected / n * (1 - kForgiven / std::sqrt(n)) - observed / n);
  }
  return slow;
}

LegCurves MakeLegCurves(const motion::MarkerRecording& recording, const LegModel& model,
                        const std::vector<double>& coefficients, const std::array<Jitter, kLegMarkers>& jitters,
                        bool with_covariance) {
  const std::size_t n = recording.Frames();
  const StateCovariances covariances = CovariancesOf(model, coefficients);
  LegCurves curves;
  curves.markers = model.states == kLegStates ? kLegMarkers : kLegMarkers - 1;
  for (std::size_t i = 0; i < n; ++i) {
    const SplineGrid::Place place = model.At(i);
    curves.state.push_back(StateAt(model, coefficients, place.value, place.first));
    curves.rate.push_back(StateAt(model, coefficients, place.slope, place.first));
    curves.hip_speed_in_leg.push_back(PointOf(kHip, curves.state[i]).by_state * curves.rate[i]);
  }
  const SlowNoises slow = FindSlowNoises(recording, model, coefficients, covariances);
  const bool any_jitters =
      std::any_of(jitters.begin(), jitters.end(), [](const Jitter& jitter) { return jitter.share > 0; });
  const std::vector<MarkerMoves> moves =
      any_jitters ? FindMoves(model, coefficients, curves.state, jitters) : std::vector<MarkerMoves>();
  for (std::size_t i = 0; i < n; ++i) {
    StateMatrix of_state = covariances.At(i);
    if (!moves.empty()) MoveMarkers(moves[i], model.states, curves.state[i], of_state);
    if (with_covariance) curves.covariance.push_back(of_state);
    std::array<double, kLegMarkers> slow_in_plane = {};
    for (int m = 0; m < curves.markers; ++m) {
      const auto index = static_cast<std::size_t>(m);
      MarkerCurve& curve = curves.marker[index];
      const PointInLeg point = PointOf(static_cast<LegMarker>(m), curves.state[i]);
      curve.in_plane.push_back(model.plane_from_leg * point.position);
      curve.recorded.push_back(RecordedFromPlane<double>(model.view, curve.in_plane[i], model.depth_mm[index]));
      const double scale = PlaneUnitsPerRecorded(model.view, curve.in_plane[i], model.depth_mm[index]);
      slow_in_plane[index] = slow[index][i] * scale * scale;
      const double variance =
          (point.by_state * of_state * point.by_state.transpose()).trace() / 2 + slow_in_plane[index];
      curve.plane_sigma.push_back(std::sqrt(variance));
      curve.recorded_sigma.push_back(curve.plane_sigma[i] / scale);
    }
    const double knee_variance =
        KneeVariance(of_state) +
        KneeVarianceOfMarkers(curves.state[i], slow_in_plane[kAnkle], slow_in_plane[kKnee], slow_in_plane[kHip]);
    curves.knee_sigma_deg.push_back(DegreesFromRadians(std::sqrt(knee_variance)));
    curves.knee_deg_s.push_back(DegreesFromRadians(curves.rate[i][kShankAngle] - curves.rate[i][kThighAngle]));
  }
  return curves;
}

MarkerCurve SmoothMarker(const motion::MarkerRecording& recording, const Detections& d, const LegView& view,
                         const LegFitOptions& options) {
  const std::size_t n = recording.Frames();
  const SplineGrid grid = MakeSplineGrid(
      recording.time_s, (recording.time_s.back() - recording.time_s.front()) / static_cast<double>(n - 1));
  SmoothingOptions smoothing;
  if (options.filter == LegFilter::kSpline) smoothing.cutoff_hz = options.cutoff_hz;
  smoothing.max_iterations = options.most_smoothing_iterations;
  MarkerCurve curve;
  curve.in_plane.assign(n, Eigen::Vector2d::Zero());
  std::vector<double> variance(n, 0.0);
  std::vector<NoiseSample> samples;
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<double> values(n, motion::LegSample::kUnknown);
    for (std::size_t i = 0; i < n; ++i)
      if (d.trusted[i]) values[i] = d.in_plane[i][axis];
    const SmoothSignal signal = FitSmoothingSpline(grid, recording.time_s, values, d.plane_sigma, smoothing);
    curve.settled &= signal.converged;
    curve.noise_scale = std::max(curve.noise_scale, signal.noise_scale);
    const Jitter jitter = options.FollowsJitter() ? Jitter(signal.noise_scale) : Jitter();
    for (std::size_t i = 0; i < n; ++i) {
      const SplineGrid::Place place = grid.At(recording.time_s[i]);
      const double smooth = ValueAt(place, signal.coefficients), own = VarianceAt(place, signal.covariance);
      curve.in_plane[i][axis] = smooth;
      variance[i] += own / 2;
      if (!d.trusted[i]) continue;
      const double sigma2 = std::pow(signal.noise_scale * d.plane_sigma[i], 2);
      samples.push_back({i, 1 - own / sigma2, std::pow(values[i] - smooth, 2) / sigma2});
      curve.in_plane[i][axis] += jitter.share * (values[i] - smooth);
      variance[i] += jitter.VarianceWhereSeen(sigma2) / 2;
    }
  }
  std::stable_sort(samples.begin(), samples.end(), [](const auto& a, const auto& b) { return a.frame < b.frame; });
  const std::vector<double> slow = SlowNoise(samples, recording.time_s);
  for (std::size_t i = 0; i < n; ++i) {
    curve.plane_sigma.push_back(std::sqrt(variance[i] + slow[i] * d.plane_sigma[i] * d.plane_sigma[i]));
    curve.recorded.push_back(RecordedFromPlane<double>(view, curve.in_plane[i], d.depth_mm));
    curve.recorded_sigma.push_back(curve.plane_sigma[i] / PlaneUnitsPerRecorded(view, curve.in_plane[i], d.depth_mm));
  }
  return curve;
}

}  // namespace lake::gait
