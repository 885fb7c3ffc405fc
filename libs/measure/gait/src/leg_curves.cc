#include "leg_curves.h"

#include <ceres/jet.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "lake/core/angles.h"
#include "lake/core/statistics.h"
#include "scatter.h"

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

double DifferenceVariance(const StateMatrix& covariance, int a, int b) {
  return covariance(a, a) + covariance(b, b) - 2 * covariance(a, b);
}

// A segment of the leg: its angle and its length in the state, and its lower marker.
struct Segment {
  int angle, length;
  LegMarker marker;
};
constexpr Segment kShank = {kShankAngle, kShankLength, kAnkle}, kThigh = {kThighAngle, kThighLength, kKnee},
                  kTrunk = {kTrunkAngle, kTrunkLength, kHip};

using MarkerVariances = std::array<double, kLegMarkers>;  // of positions, per axis

// What variances of the marker positions add to the segment's angle, and to the angle between it and the next one up.
double SegmentVarianceOfMarkers(const StateVector& state, const Segment& segment, const MarkerVariances& variance) {
  return (variance[segment.marker] + variance[segment.marker + 1u]) / std::pow(state[segment.length], 2);
}

double JointVarianceOfMarkers(const StateVector& state, const Segment& lower, const Segment& upper,
                              const MarkerVariances& variance) {
  const double below = state[lower.length], above = state[upper.length],
               angle = state[lower.angle] - state[upper.angle];
  return variance[lower.marker] / (below * below) + variance[upper.marker + 1u] / (above * above) +
         variance[upper.marker] * (1 / (below * below) + 1 / (above * above) + 2 * std::cos(angle) / (below * above));
}

double DegreesOfVariance(double variance) {
  return DegreesFromRadians(std::sqrt(variance));
}

// Adds a frame's; `slow`: what slow noise adds to the markers' variances.
void AddDeviations(const StateVector& state, const StateMatrix& of_state, const StateMatrix& of_rate,
                   const MarkerVariances& slow, bool has_trunk, StsDeviations& sd) {
  const PointDerivative hip = PointOf(kHip, state).by_state;
  const auto up_variance = [&](const StateMatrix& covariance) {
    return hip.row(1) * covariance * hip.row(1).transpose();
  };
  sd.hip_height.push_back(std::sqrt(up_variance(of_state)(0) + slow[kHip]));
  sd.hip_up_speed.push_back(std::sqrt(up_variance(of_rate)(0)));
  sd.knee_deg.push_back(
      DegreesOfVariance(KneeVariance(of_state) + JointVarianceOfMarkers(state, kShank, kThigh, slow)));
  sd.knee_deg_s.push_back(DegreesOfVariance(KneeVariance(of_rate)));
  sd.shank_deg.push_back(
      DegreesOfVariance(of_state(kShankAngle, kShankAngle) + SegmentVarianceOfMarkers(state, kShank, slow)));
  sd.shank_deg_s.push_back(DegreesOfVariance(of_rate(kShankAngle, kShankAngle)));
  const auto trunk = [&](double variance) { return has_trunk ? DegreesOfVariance(variance) : NAN; };
  sd.trunk_deg.push_back(trunk(of_state(kTrunkAngle, kTrunkAngle) + SegmentVarianceOfMarkers(state, kTrunk, slow)));
  sd.trunk_deg_s.push_back(trunk(of_rate(kTrunkAngle, kTrunkAngle)));
  sd.hip_deg.push_back(trunk(DifferenceVariance(of_state, kTrunkAngle, kThighAngle) +
                             JointVarianceOfMarkers(state, kThigh, kTrunk, slow)));
  sd.hip_deg_s.push_back(trunk(DifferenceVariance(of_rate, kTrunkAngle, kThighAngle)));
}

using SlowNoises = std::array<std::vector<double>, kLegMarkers>;  // variances, recorded unit, per frame

SlowNoises FindSlowNoises(const motion::MarkerRecording& recording, const LegModel& model,
                          const std::vector<double>& coefficients, const StateCovariances& covariances) {
  std::array<std::vector<Residual>, kLegMarkers> samples;
  std::array<double, kLegMarkers> variance = {};
  StateMatrix of_state;
  std::optional<std::size_t> frame;  // whose it is
  for (const LegObservation& o : model.observations) {
    const LegResidual residual = EvaluateObservation(model, o, coefficients);
    const double sigma2 = std::pow(model.Scatter(o), 2);
    if (!IsOrdinary(model, o, residual.value)) continue;
    if (frame != o.frame) of_state = covariances.At(o.frame);
    frame = o.frame;
    const double used = (residual.by_state * of_state * residual.by_state.transpose()).trace() / sigma2;
    samples[o.marker].push_back({recording.time_s[o.frame], residual.value.squaredNorm() / sigma2 / 2, 1 - used / 2});
    variance[o.marker] += std::pow(model.Sigma(o), 2);
  }
  SlowNoises slow;
  for (std::size_t m = 0; m < kLegMarkers; ++m) {
    slow[m] = SlowNoise(samples[m], recording.time_s);
    for (double& value : slow[m])
      value *= samples[m].empty() ? 0 : variance[m] / static_cast<double>(samples[m].size());
  }
  return slow;
}

// What the markers of one frame did beside their smooth paths, in the leg's axes: where they were seen, all of the
// residual but its share of noise that does not last; elsewhere it is not known, but there.
struct MarkerMoves {
  std::array<Eigen::Vector2d, kLegMarkers> move;
  std::array<double, kLegMarkers> path_share;     // of the estimate's error that is the smooth path's
  std::array<double, kLegMarkers> variance = {};  // of the rest, per axis

  MarkerMoves() {
    move.fill(Eigen::Vector2d::Zero());
    path_share.fill(1);
  }
};

std::vector<MarkerMoves> FindMoves(const LegModel& model, const std::vector<double>& coefficients,
                                   const std::vector<StateVector>& states, const std::vector<double>& time_s,
                                   double lasting_share) {
  std::array<std::vector<double>, kLegMarkers> variances;
  std::vector<MarkerMoves> moves(states.size());
  std::array<std::vector<char>, kLegMarkers> known;
  known.fill(std::vector<char>(states.size()));
  for (const LegObservation& o : model.observations) {
    const LegResidual residual = EvaluateObservation(model, o, coefficients);
    if (model.noise_share[o.marker].empty() || !IsOrdinary(model, o, residual.value)) continue;
    const double depth_mm = model.depth_mm[o.marker],
                 share = (1 - lasting_share) *
                         LimitedShare(model.noise_share[o.marker][o.frame], residual.value.norm() / model.Sigma(o));
    const Eigen::Vector2d seen = PlaneFromRecorded(model.view, o.seen, depth_mm);
    const double variance = std::pow(model.Sigma(o) * PlaneUnitsPerRecorded(model.view, seen, depth_mm), 2);
    const Eigen::Vector2d smooth = PointOf(o.marker, states[o.frame]).position;
    MarkerMoves& frame = moves[o.frame];
    frame.move[o.marker] = (1 - share) * (model.plane_from_leg.transpose() * seen - smooth);
    frame.path_share[o.marker] = share;
    frame.variance[o.marker] = (1 - share) * variance;
    known[o.marker][o.frame] = 1;
    variances[o.marker].push_back(variance);
  }
  for (std::size_t m = 0; m < kLegMarkers; ++m) {
    if (variances[m].empty()) continue;
    const double usual = Median(variances[m]);
    const std::vector<double> hidden =
        ScatterInGaps(model.noise_share[m], known[m], time_s, SmoothingOptions{}.memory_s);
    for (std::size_t i = 0; i < moves.size(); ++i)
      if (!known[m][i]) moves[i].variance[m] = hidden[i] * usual;
  }
  return moves;
}

// The state whose markers lie at these places, its angles next to those of another state.
void PlaceMarkers(const Eigen::VectorXd& places, StateVector& state) {
  state.head<2>() = places.head<2>();
  for (const Segment& segment : {kShank, kThigh, kTrunk}) {
    const Eigen::Index below = 2 * segment.marker;
    if (below + 4 > places.size()) break;
    const Eigen::Vector2d vector = places.segment<2>(below + 2) - places.segment<2>(below);
    double& angle = state[segment.angle];
    angle += std::remainder(std::atan2(vector.x(), vector.y()) - angle, 2 * std::numbers::pi);
    state[segment.length] = vector.norm();
  }
}

// The state whose markers lie where the moves put them.
void MoveMarkers(const MarkerMoves& moves, int states, StateVector& state, StateMatrix& covariance) {
  const int markers = states / 2;
  Eigen::MatrixXd by_state(states, states);
  Eigen::VectorXd places(states), variance(states), path_share(states);
  for (int m = 0; m < markers; ++m) {
    const auto index = static_cast<std::size_t>(m);
    const PointInLeg point = PointOf(static_cast<LegMarker>(m), state);
    by_state.middleRows<2>(2 * m) = point.by_state.leftCols(states);
    places.segment<2>(2 * m) = point.position + moves.move[index];
    variance.segment<2>(2 * m).setConstant(moves.variance[index]);
    path_share.segment<2>(2 * m).setConstant(moves.path_share[index]);
  }
  const Eigen::MatrixXd by_markers = by_state.inverse(),
                        of_path = by_markers * path_share.asDiagonal() * by_state;  // its errors that are left
  PlaceMarkers(places, state);
  covariance.topLeftCorner(states, states) = of_path * covariance.topLeftCorner(states, states) * of_path.transpose() +
                                             by_markers * variance.asDiagonal() * by_markers.transpose();
}

}  // namespace

double KneeVariance(const StateMatrix& covariance) {
  return DifferenceVariance(covariance, kShankAngle, kThighAngle);
}

LegCurves MakeLegCurves(const motion::MarkerRecording& recording, const LegModel& model,
                        const std::vector<double>& coefficients, double lasting_share, bool with_covariance) {
  const std::size_t n = recording.Frames();
  const LegCovariances covariances = CovariancesOf(model, coefficients);
  LegCurves curves;
  curves.markers = model.states == kLegStates ? kLegMarkers : kLegMarkers - 1;
  for (std::size_t i = 0; i < n; ++i) {
    const SplineGrid::Place place = model.At(i);
    curves.state.push_back(StateAt(model, coefficients, place.value, place.first));
    curves.rate.push_back(StateAt(model, coefficients, place.slope, place.first));
    curves.hip_speed_in_leg.push_back(PointOf(kHip, curves.state[i]).by_state * curves.rate[i]);
  }
  const SlowNoises slow = FindSlowNoises(recording, model, coefficients, covariances.state);
  const std::vector<MarkerMoves> moves = FindMoves(model, coefficients, curves.state, recording.time_s, lasting_share);
  for (std::size_t i = 0; i < n; ++i) {
    StateMatrix of_state = covariances.state.At(i);
    MoveMarkers(moves[i], model.states, curves.state[i], of_state);
    if (with_covariance) curves.covariance.push_back(of_state);
    MarkerVariances slow_in_plane = {};
    for (int m = 0; m < curves.markers; ++m) {
      const auto index = static_cast<std::size_t>(m);
      MarkerCurve& curve = curves.marker[index];
      const PointInLeg point = PointOf(static_cast<LegMarker>(m), curves.state[i]);
      curve.in_plane.push_back(model.plane_from_leg * point.position);
      curve.recorded.push_back(RecordedFromPlane<double>(model.view, curve.in_plane[i], model.depth_mm[index]));
      const double scale = PlaneUnitsPerRecorded(model.view, curve.in_plane[i], model.depth_mm[index]);
      slow_in_plane[index] = moves[i].path_share[index] * slow[index][i] * scale * scale;
      const double variance =
          (point.by_state * of_state * point.by_state.transpose()).trace() / 2 + slow_in_plane[index];
      curve.plane_sigma.push_back(std::sqrt(variance));
      curve.recorded_sigma.push_back(curve.plane_sigma[i] / scale);
      curve.scatter.push_back(model.sigma_scale[index] / std::sqrt(model.NoiseShare(static_cast<LegMarker>(m), i)));
    }
    AddDeviations(curves.state[i], of_state, covariances.rate.At(i), slow_in_plane, curves.markers == kLegMarkers,
                  curves.sd);
    curves.knee_deg_s.push_back(DegreesFromRadians(curves.rate[i][kShankAngle] - curves.rate[i][kThighAngle]));
  }
  curves.knee_sigma_deg = curves.sd.knee_deg;
  return curves;
}

SmoothCoordinate SmoothByItself(const SplineGrid& grid, const std::vector<double>& time_s,
                                const std::vector<double>& values, const std::vector<double>& sigmas,
                                const LegFitOptions& options) {
  SmoothingOptions smoothing;
  if (options.filter == LegFilter::kSpline) smoothing.cutoff_hz = options.cutoff_hz;
  smoothing.max_iterations = options.most_smoothing_iterations;
  const SmoothSignal signal = FitSmoothingSpline(grid, time_s, values, sigmas, smoothing);
  const double usual = options.known_sigmas && !smoothing.cutoff_hz ? 1 : Median(signal.noise_share),
               lasting = options.LastingShare();
  SmoothCoordinate result;
  result.settled = signal.converged;
  std::vector<Residual> samples;
  std::vector<double> noise_variance, shares, path_shares;
  std::vector<char> seen;
  shares.reserve(time_s.size());
  seen.reserve(time_s.size());
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    const SplineGrid::Place place = grid.At(time_s[i]);
    const double share = std::min(1.0, signal.noise_share[i] / usual), own = VarianceAt(place, signal.covariance),
                 noise = sigmas[i] * sigmas[i] / usual;
    result.value.push_back(ValueAt(place, signal.coefficients));
    result.rate.push_back(SlopeAt(place, signal.coefficients));
    result.scatter.push_back(1 / std::sqrt(signal.noise_share[i]));
    shares.push_back(share);
    seen.push_back(std::isfinite(values[i]));
    if (std::isfinite(values[i])) {
      const double residual = values[i] - result.value[i],
                   kept = (1 - lasting) * LimitedShare(share, std::abs(residual) / std::sqrt(noise));
      samples.push_back({time_s[i], residual * residual * share / noise, 1 - own * share / noise});
      result.value[i] += (1 - kept) * residual;
      result.variance.push_back(kept * kept * own + (1 - kept) * noise);
      noise_variance.push_back(noise);
      path_shares.push_back(kept);
    } else {
      result.variance.push_back(own);
      path_shares.push_back(1);
    }
  }
  const std::vector<double> slow = SlowNoise(samples, time_s);
  const double usual_noise = Median(noise_variance);
  const std::vector<double> hidden = ScatterInGaps(shares, seen, time_s, smoothing.memory_s);
  for (std::size_t i = 0; i < time_s.size(); ++i)
    result.variance[i] += (path_shares[i] * slow[i] + hidden[i]) * usual_noise;
  return result;
}

MarkerCurve SmoothMarker(const motion::MarkerRecording& recording, const Detections& d, const LegView& view,
                         const LegFitOptions& options) {
  const std::size_t n = recording.Frames();
  const SplineGrid grid = MakeSplineGrid(
      recording.time_s, (recording.time_s.back() - recording.time_s.front()) / static_cast<double>(n - 1));
  MarkerCurve curve;
  curve.in_plane.resize(n);
  curve.scatter.assign(n, 1);
  std::vector<double> variance(n, 0.0);
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<double> values(n, motion::LegSample::kUnknown);
    for (std::size_t i = 0; i < n; ++i)
      if (d.trusted[i]) values[i] = d.in_plane[i][axis];
    const SmoothCoordinate smooth = SmoothByItself(grid, recording.time_s, values, d.plane_sigma, options);
    curve.settled &= smooth.settled;
    for (std::size_t i = 0; i < n; ++i) {
      curve.in_plane[i][axis] = smooth.value[i];
      variance[i] += smooth.variance[i] / 2;
      curve.scatter[i] = std::max(curve.scatter[i], smooth.scatter[i]);
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    curve.plane_sigma.push_back(std::sqrt(variance[i]));
    curve.recorded.push_back(RecordedFromPlane<double>(view, curve.in_plane[i], d.depth_mm));
    curve.recorded_sigma.push_back(curve.plane_sigma[i] / PlaneUnitsPerRecorded(view, curve.in_plane[i], d.depth_mm));
  }
  return curve;
}

}  // namespace lake::gait
