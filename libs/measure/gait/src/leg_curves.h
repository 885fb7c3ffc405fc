// The solved fit, evaluated at the frames. Not part of the interface.
#pragma once

#include <array>
#include <vector>

#include "leg_problem.h"
#include "leg_signals.h"

namespace lake::gait {

// A marker's fitted position in every frame.
struct MarkerCurve {
  std::vector<Eigen::Vector2d> in_plane, recorded;
  std::vector<double> plane_sigma, recorded_sigma;           // per axis
  bool settled = true;                                       // whether its smoothness was found
  double noise_scale = 1;                                    // see MarkerReport
  std::vector<double> across, across_rate, across_variance;  // of trials in three dimensions: mm, mm/s, mm²
};

struct LegCurves {
  int markers = kLegMarkers;
  std::array<MarkerCurve, kLegMarkers> marker;
  std::vector<StateVector> state, rate;  // rate: per s
  std::vector<StateMatrix> covariance;   // of the state, without slow noise; if asked for
  std::vector<double> knee_sigma_deg, knee_deg_s;
  std::vector<Eigen::Vector2d> hip_speed_in_leg;  // per s
  std::vector<Eigen::Vector3d> flexion_axis;      // of trials in three dimensions: the leg's axes and across them
};

// Variance of θ_shank − θ_thigh, rad².
double KneeVariance(const StateMatrix& covariance);

// What a marker itself scatters about its smooth path, from frame to frame, where the noise is known: of a scatter with
// `scale` times the noise's deviation, 1/scale² of the variance is noise. The best estimate of a frame's jitter is that
// share of its residual which is none (Wiener), with the variance that this leaves.
struct Jitter {
  Jitter() = default;
  explicit Jitter(double scale) : share(1 - 1 / (scale * scale)) {}

  double share = 0;  // of the residual's variance
  double VarianceWhereSeen(double scatter_variance) const { return share * (1 - share) * scatter_variance; }
  double VarianceWhereHidden(double scatter_variance) const { return share * scatter_variance; }
};

// Smooth paths, and on them the markers' jitters.
LegCurves MakeLegCurves(const motion::MarkerRecording& recording, const LegModel& model,
                        const std::vector<double>& coefficients, const std::array<Jitter, kLegMarkers>& jitters,
                        bool with_covariance);

// A marker that is not the leg's, smoothed and bridged by itself.
MarkerCurve SmoothMarker(const motion::MarkerRecording& recording, const Detections& detections, const LegView& view,
                         const LegFitOptions& options);

// Tracks, trajectory, motion, events, reports.
void FillResult(const motion::MarkerRecording& recording, const std::array<Detections, kLegMarkers>& leg,
                const LegCurves& curves, const LegModel& model, motion::Facing facing, const LegFitOptions& options,
                LegFitResult& result);

// Noise that a sigma states but the residuals do not show is too slow to be told from motion: it is in the curve, and
// must be in the curve's variance. In variances of the detections (1 = all of it), per frame.
struct NoiseSample {
  std::size_t frame = 0;
  double expected = 0;  // of (r/σ)² per axis: 1 − leverage
  double observed = 0;
};
std::vector<double> SlowNoise(const std::vector<NoiseSample>& samples, const std::vector<double>& time_s);

}  // namespace lake::gait
