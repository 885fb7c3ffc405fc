#include "lake/gait/smoothing_spline.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"

namespace lake {
namespace {

constexpr std::array<double, 4> kThirdDifference = {-1, 3, -3, 1};
constexpr double kHalfPower = std::numbers::sqrt2 - 1;  // g of 1 / (1 + g) = √½

struct Sample {
  SplineGrid::Place place;
  double value, precision;
};

// One round at a given roughness: coefficients, and what the next step needs.
struct Round {
  std::vector<double> coefficients;
  BandedMatrix covariance{0, 3};
  double jerk_square = 0;       // Σ (Δ³c)²
  double jerk_variance = 0;     // Σ of its posterior variances
  double slope_square = 0;      // mean f′² + its variance, at the samples
  double residual_square = 0;   // Σ weight (r/σ)²
  double weight = 0;            // Σ of the robust weights
  double effective_parameters = 0;
};

std::vector<Sample> CollectSamples(const SplineGrid& grid, std::span<const double> time_s, std::span<const double> values,
                                   std::span<const double> sigmas) {
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    if (!(sigmas[i] > 0)) throw Fail("smoothing: the sigma {} of sample {} is not positive", sigmas[i], i);
    samples.push_back({grid.At(time_s[i]), values[i], 1 / (sigmas[i] * sigmas[i])});
  }
  if (samples.size() < 4) throw Fail("smoothing: {} samples are too few for a curve", samples.size());
  return samples;
}

template <std::size_t N>
void AddSquare(BandedMatrix& matrix, std::size_t first, const std::array<double, N>& row, double weight) {
  for (std::size_t a = 0; a < N; ++a)
    for (std::size_t b = 0; b <= a; ++b) matrix.Lower(first + a, first + b) += weight * row[a] * row[b];
}

template <std::size_t N>
double Variance(const BandedMatrix& covariance, std::size_t first, const std::array<double, N>& row) {
  double sum = 0;
  for (std::size_t a = 0; a < N; ++a)
    for (std::size_t b = 0; b < N; ++b) sum += row[a] * row[b] * covariance.At(first + a, first + b);
  return sum;
}

double TukeyWeight(double residual, double limit) {
  const double u = residual / limit;
  return std::abs(u) < 1 ? (1 - u * u) * (1 - u * u) : 0;
}

Round RunRound(const SplineGrid& grid, const std::vector<Sample>& samples, const std::vector<double>& weights,
               double noise_scale, double roughness) {
  BandedMatrix normal(grid.count, 3);
  Round round;
  round.coefficients.assign(grid.count, 0.0);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double weight = weights[i] * samples[i].precision / (noise_scale * noise_scale);
    AddSquare(normal, samples[i].place.first, samples[i].place.value, weight);
    for (std::size_t a = 0; a < 4; ++a)
      round.coefficients[samples[i].place.first + a] += weight * samples[i].value * samples[i].place.value[a];
  }
  for (std::size_t k = 0; k + 3 < grid.count; ++k) AddSquare(normal, k, kThirdDifference, 1 / roughness);
  if (!Factorize(normal)) throw Fail("smoothing: the samples do not determine a curve (too few, or all at one time)");
  Solve(normal, round.coefficients);

  round.covariance = SelectedInverse(normal);
  const BandedMatrix& covariance = round.covariance;
  for (std::size_t k = 0; k + 3 < grid.count; ++k) {
    double jerk = 0;
    for (std::size_t a = 0; a < 4; ++a) jerk += kThirdDifference[a] * round.coefficients[k + a];
    round.jerk_square += jerk * jerk;
    round.jerk_variance += Variance(covariance, k, kThirdDifference);
  }
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double residual = samples[i].value - ValueAt(samples[i].place, round.coefficients);
    round.residual_square += weights[i] * samples[i].precision * residual * residual;
    round.weight += weights[i];
    const double slope = SlopeAt(samples[i].place, round.coefficients);
    round.slope_square += slope * slope + Variance(covariance, samples[i].place.first, samples[i].place.slope);
    round.effective_parameters += weights[i] * samples[i].precision / (noise_scale * noise_scale) *
                                  Variance(covariance, samples[i].place.first, samples[i].place.value);
  }
  round.slope_square /= static_cast<double>(samples.size());
  return round;
}

double RootMeanSigma(const std::vector<Sample>& samples) {
  double variance = 0;
  for (const Sample& sample : samples) variance += 1 / sample.precision;
  return std::sqrt(variance / static_cast<double>(samples.size()));
}

}  // namespace

SplineGrid::Place SplineGrid::At(double time_s) const {
  const double position = (time_s - start_s) / step_s;
  Place place;
  place.first = static_cast<std::size_t>(std::clamp(std::floor(position), 0.0, static_cast<double>(count - 4)));
  const double u = position - static_cast<double>(place.first), v = 1 - u;
  place.value = {v * v * v / 6, (3 * u * u * u - 6 * u * u + 4) / 6, (-3 * u * u * u + 3 * u * u + 3 * u + 1) / 6, u * u * u / 6};
  place.slope = {-v * v / 2 / step_s, (3 * u * u - 4 * u) / 2 / step_s, (-3 * u * u + 2 * u + 1) / 2 / step_s,
                 u * u / 2 / step_s};
  return place;
}

SplineGrid MakeSplineGrid(std::span<const double> time_s, double step_s) {
  const double length = time_s.back() - time_s.front(), pieces = std::max(1.0, std::ceil(length / step_s * (1 - 1e-9)));
  if (!(step_s > 0) || pieces > 50 * static_cast<double>(time_s.size()) + 50)
    throw Fail("smoothing: the time stamps run over {:.4g} s, but a step is {:.4g} s: they have holes too large to bridge", length,
               step_s);
  return {time_s.front(), step_s, static_cast<std::size_t>(pieces) + 3};
}

double ValueAt(const SplineGrid::Place& place, std::span<const double> coefficients) {
  double sum = 0;
  for (std::size_t a = 0; a < 4; ++a) sum += place.value[a] * coefficients[place.first + a];
  return sum;
}

double VarianceAt(const SplineGrid::Place& place, const BandedMatrix& covariance) {
  return Variance(covariance, place.first, place.value);
}

double SlopeAt(const SplineGrid::Place& place, std::span<const double> coefficients) {
  double sum = 0;
  for (std::size_t a = 0; a < 4; ++a) sum += place.slope[a] * coefficients[place.first + a];
  return sum;
}

SmoothSignal FitSmoothingSpline(const SplineGrid& grid, std::span<const double> time_s, std::span<const double> values,
                                std::span<const double> sigmas, const SmoothingOptions& options) {
  const std::vector<Sample> samples = CollectSamples(grid, time_s, values, sigmas);
  std::vector<double> weights(samples.size(), 1.0);
  const double sigma = RootMeanSigma(samples);
  const double sample_step_s = (time_s.back() - time_s.front()) / static_cast<double>(time_s.size() - 1);
  const auto roughness_of = [&](double cutoff_hz, double scale) {
    return RoughnessOfCutoff(cutoff_hz, scale * sigma, sample_step_s, grid.step_s);
  };
  constexpr double kFirstCutoffHz = 8;  // where the search starts; a few Hz above human motion
  SmoothSignal signal;
  signal.roughness = roughness_of(options.cutoff_hz.value_or(kFirstCutoffHz), 1);
  const auto differences = static_cast<double>(grid.count - 3);
  constexpr double kConverged = 0.01;  // of logarithms; the roughness's own error is ten times larger
  Round round;
  for (; signal.iterations < options.max_iterations && !signal.converged; ++signal.iterations) {
    ThrowIfInterrupted();
    round = RunRound(grid, samples, weights, signal.noise_scale, signal.roughness);
    const double scale = std::max(1.0, std::sqrt(round.residual_square / std::max(round.weight - round.effective_parameters, 1.0)));
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double residual = samples[i].value - ValueAt(samples[i].place, round.coefficients);
      weights[i] = TukeyWeight(residual * std::sqrt(samples[i].precision) / scale, options.outlier_deviations);
    }
    // Of n differences, n − Σ V/q are determined by the data: their squares add up to that many times the variance q.
    const double determined = std::max(differences - round.jerk_variance / signal.roughness, 1e-3 * differences);
    const double next = options.cutoff_hz ? roughness_of(*options.cutoff_hz, scale)
                                          : std::max(round.jerk_square / determined, roughness_of(options.least_cutoff_hz, scale));
    signal.converged = std::abs(std::log(next / signal.roughness)) < kConverged &&
                       std::abs(std::log(scale / signal.noise_scale)) < kConverged;
    signal.noise_scale = scale;
    signal.roughness = next;
  }
  signal.coefficients = std::move(round.coefficients);
  signal.covariance = std::move(round.covariance);
  signal.slope_square = round.slope_square;
  signal.effective_parameters = round.effective_parameters;
  signal.risk = round.residual_square + 2 * round.effective_parameters;
  signal.cutoff_hz = CutoffOfRoughness(signal.roughness, signal.noise_scale * sigma, sample_step_s, grid.step_s);
  return signal;
}

double RoughnessOfCutoff(double cutoff_hz, double sigma, double sample_step_s, double grid_step_s) {
  const double omega = 2 * std::numbers::pi * cutoff_hz;
  return std::pow(grid_step_s, 5) * sigma * sigma * sample_step_s * std::pow(omega, 6) / kHalfPower;
}

double CutoffOfRoughness(double roughness, double sigma, double sample_step_s, double grid_step_s) {
  const double omega6 = kHalfPower * roughness / (std::pow(grid_step_s, 5) * sigma * sigma * sample_step_s);
  return std::pow(omega6, 1.0 / 6) / (2 * std::numbers::pi);
}

}  // namespace lake
