// A smooth function of time from noisy samples of known noise: a cubic B-spline with a penalty on its jerk, whose
// weight is found from the data, moment by moment.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "lake/gait/banded_matrix.h"

namespace lake::gait {

// Uniform cubic B-splines over [start, start + step · (count − 3)].
struct SplineGrid {
  double start_s = 0;
  double step_s = 1;
  std::size_t count = 4;  // coefficients

  // What the four coefficients from `first` on contribute to the value at a time, and to the first and the second
  // derivative there (per s and s²).
  struct Place {
    std::size_t first = 0;
    std::array<double, 4> value, slope, curve;
  };
  Place At(double time_s) const;
};

// Covers the times. Throws Error if that takes more than 50 coefficients per sample (holes in the time stamps).
SplineGrid MakeSplineGrid(std::span<const double> time_s, double step_s);

double ValueAt(const SplineGrid::Place& place, std::span<const double> coefficients);
double VarianceAt(const SplineGrid::Place& place, const BandedMatrix& covariance);
double SlopeAt(const SplineGrid::Place& place, std::span<const double> coefficients);
double CurveAt(const SplineGrid::Place& place, std::span<const double> coefficients);

struct SmoothingOptions {
  std::optional<double> cutoff_hz;  // fixed instead of found
  double least_cutoff_hz = 0.5;     // a limb's motion is never slower; below it the normal equations lose their digits
  double window_s = 0.2;            // the roughness is alike over about this time to each side
  double memory_s = 0.1;            // a movement that is not seen goes on as it was for about this time
  double common = 0.2;  // how many differences' worth of the whole recording's roughness each window takes in
  int max_iterations = 60;
};

// The prior is that the third differences of the coefficients are independent with variances `roughness`, an integrated
// random jerk; its posterior mean is the penalised spline  min Σ (y − f)²/σ² + ∫ μ f‴²  with μ = step⁵ / roughness. A
// limb rests and moves, so the roughness follows the signal: one value would be too rough for the one and too smooth
// for the other.
struct SmoothSignal {
  std::vector<double> coefficients;
  BandedMatrix covariance{0, 3};    // of the coefficients, within three of the diagonal
  std::vector<double> roughness;    // variance of Δ³ of the coefficients, count − 3
  std::vector<double> change;       // per difference, the chance that the movement is not that of the samples beside it
  double quickest_roughness = 0;    // of the quickest movement, which `roughness` takes in with that chance
  double slope_square = 0;          // mean square of f′ at the samples, its uncertainty included
  std::vector<double> noise_share;  // of the scatter about the curve, at each sample
  double noise_scale = 1;           // ≥ 1: scatter about the curve over the samples' sigmas, root mean square
  double effective_parameters = 0;
  double risk = 0;       // Akaike's: Σ (r/s)² + log (s/σ)² + 2 effective parameters, s the scatter; compares grids
  double cutoff_hz = 0;  // of the equivalent low-pass (−3 dB), for the geometric mean of the roughness
  int iterations = 0;
  bool converged = false;
};

// Samples that are NaN are gaps. The roughness maximises the restricted likelihood (Fellner–Schall step: S. N. Wood &
// M. Fasiolo, Biometrics 73, 2017). Throws Error with fewer than four samples or a sigma that is not positive.
SmoothSignal FitSmoothingSpline(const SplineGrid& grid, std::span<const double> time_s, std::span<const double> values,
                                std::span<const double> sigmas, const SmoothingOptions& options = {});

// The roughness of the low-pass with −3 dB at a cutoff: the penalised spline's gain is 1 / (1 + μ σ² Δt (2πf)⁶).
double RoughnessOfCutoff(double cutoff_hz, double sigma, double sample_step_s, double grid_step_s);
double CutoffOfRoughness(double roughness, double sigma, double sample_step_s, double grid_step_s);

}  // namespace lake::gait
