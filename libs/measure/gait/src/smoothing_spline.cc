#include "lake/gait/smoothing_spline.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "scatter.h"

namespace lake::gait {
namespace {

constexpr std::array<double, 4> kThirdDifference = {-1, 3, -3, 1};
constexpr double kHalfPower = std::numbers::sqrt2 - 1;  // g of 1 / (1 + g) = √½

struct Sample {
  std::size_t index;
  SplineGrid::Place place;
  double time_s, value, precision;
  double noise_share = 1;  // of the scatter about the curve

  double Weight() const { return precision * noise_share; }
};

// One round at a given roughness: coefficients, and what the next step needs.
struct Round {
  std::vector<double> coefficients;
  BandedMatrix covariance{0, 3};
  std::vector<double> jerk_square;    // (Δ³c)²
  std::vector<double> jerk_variance;  // their posterior variances
  double slope_square = 0;            // mean f′² + variance
  std::vector<Residual> residuals;    // one per sample, σ without it
  double effective_parameters = 0;
};

std::vector<Sample> CollectSamples(const SplineGrid& grid, std::span<const double> time_s,
                                   std::span<const double> values, std::span<const double> sigmas) {
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    if (!(sigmas[i] > 0)) throw Fail("smoothing: the sigma {} of sample {} is not positive", sigmas[i], i);
    samples.push_back({i, grid.At(time_s[i]), time_s[i], values[i], 1 / (sigmas[i] * sigmas[i])});
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

// The longest step, and after which time.
struct LongestStep {
  double step_s = 0, after_s = 0;
};

LongestStep FindLongestStep(std::span<const double> time_s) {
  LongestStep longest;
  for (std::size_t i = 1; i < time_s.size(); ++i)
    if (const double step_s = time_s[i] - time_s[i - 1]; step_s > longest.step_s) longest = {step_s, time_s[i - 1]};
  return longest;
}

Error Undetermined(std::span<const double> time_s, std::span<const double> values) {
  std::vector<double> times;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::isfinite(values[i])) times.push_back(time_s[i]);
  const double usual_s = MedianInterval(times);
  const LongestStep longest = FindLongestStep(times);
  return Fail(
      "smoothing: {} samples over {} s do not determine a curve; they are {} s apart{}: are the times in "
      "seconds, and of one recording?",
      times.size(), SignificantText(times.back() - times.front(), 3), SignificantText(usual_s, 3),
      longest.step_s > 2 * usual_s
          ? fmt::format(" (median), with a gap of {} s after {} s", SignificantText(longest.step_s, 3),
                        SignificantText(longest.after_s, 6))
          : "");
}

// nullopt where the samples do not determine the curve.
std::optional<Round> RunRound(const SplineGrid& grid, const std::vector<Sample>& samples,
                              const std::vector<double>& roughness) {
  BandedMatrix normal(grid.count, 3);
  Round round;
  round.coefficients.assign(grid.count, 0.0);
  for (const Sample& sample : samples) {
    const double weight = sample.Weight();
    AddSquare(normal, sample.place.first, sample.place.value, weight);
    for (std::size_t a = 0; a < 4; ++a)
      round.coefficients[sample.place.first + a] += weight * sample.value * sample.place.value[a];
  }
  for (std::size_t k = 0; k + 3 < grid.count; ++k) AddSquare(normal, k, kThirdDifference, 1 / roughness[k]);
  if (!Factorize(normal)) return std::nullopt;
  Solve(normal, round.coefficients);

  round.covariance = SelectedInverse(std::move(normal));
  for (std::size_t k = 0; k + 3 < grid.count; ++k) {
    double jerk = 0;
    for (std::size_t a = 0; a < 4; ++a) jerk += kThirdDifference[a] * round.coefficients[k + a];
    round.jerk_square.push_back(jerk * jerk);
    round.jerk_variance.push_back(Variance(round.covariance, k, kThirdDifference));
  }
  for (const Sample& sample : samples) {
    const double residual = sample.value - ValueAt(sample.place, round.coefficients);
    const double leverage = sample.Weight() * VarianceAt(sample.place, round.covariance);
    round.residuals.push_back({sample.time_s, sample.precision * residual * residual, 1 - leverage});
    round.effective_parameters += leverage;
    const double slope = SlopeAt(sample.place, round.coefficients);
    round.slope_square += slope * slope + Variance(round.covariance, sample.place.first, sample.place.slope);
  }
  round.slope_square /= static_cast<double>(samples.size());
  return round;
}

// Of change, in the middle of each difference.
std::vector<double> ChancesAtDifferences(const SplineGrid& grid, const std::vector<Sample>& samples, double memory_s) {
  std::vector<double> at_s, seen_s;
  seen_s.reserve(samples.size());
  for (const Sample& sample : samples) seen_s.push_back(sample.time_s);
  at_s.reserve(grid.count);
  for (std::size_t k = 0; k + 3 < grid.count; ++k)
    at_s.push_back(grid.start_s + (static_cast<double>(k) + 0.5) * grid.step_s);  // the middle of its jerk
  return ChancesOfChange(at_s, seen_s, MedianInterval(seen_s), memory_s);
}

// Of n differences, n − Σ V/q are determined by the data: their squares add up to that many times the variance q. In a
// window around each, with a share of the whole.
std::vector<double> RoughnessIn(const Round& round, const std::vector<double>& roughness, std::size_t reach,
                                double common) {
  const std::size_t n = roughness.size();
  std::vector<double> squares(n + 1, 0.0), determined(n + 1, 0.0);  // running sums
  for (std::size_t k = 0; k < n; ++k) {
    squares[k + 1] = squares[k] + round.jerk_square[k];
    determined[k + 1] = determined[k] + std::clamp(1 - round.jerk_variance[k] / roughness[k], 1e-6, 1.0);
  }
  const double whole = squares[n] / determined[n];
  std::vector<double> next(n);
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t begin = k > reach ? k - reach : 0, end = std::min(n, k + reach + 1);
    next[k] = (squares[end] - squares[begin] + common * whole) / (determined[end] - determined[begin] + common);
  }
  return next;
}

// What a person did in a gap nobody saw: it went on as beside it, or was any movement of the recording; so that the
// error is known of quick ones too, the quickest.
void SetInGaps(double quickest, const std::vector<double>& chances_of_change, std::vector<double>& roughness) {
  for (std::size_t k = 0; k < roughness.size(); ++k) roughness[k] += chances_of_change[k] * (quickest - roughness[k]);
}

double GeometricMean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += std::log(value);
  return std::exp(sum / static_cast<double>(values.size()));
}

// The largest relative change, as a logarithm.
double LargestChange(const std::vector<double>& from, const std::vector<double>& to) {
  double change = 0;
  for (std::size_t k = 0; k < from.size(); ++k) change = std::max(change, std::abs(std::log(to[k] / from[k])));
  return change;
}

// At the given times; one share for all where a cutoff says what motion is.
std::vector<double> FindNoiseShares(const Round& round, std::span<const double> time_s, bool alike) {
  if (!alike) return NoiseShares(round.residuals, time_s);
  double square = 0, free = 0;
  for (const Residual& residual : round.residuals) {
    square += residual.square;
    free += residual.free;
  }
  return std::vector<double>(time_s.size(), std::min(1.0, std::max(free, 1.0) / square));
}

// Root mean square, of the noise's deviation.
double ScatterOf(const std::vector<Sample>& samples) {
  double sum = 0;
  for (const Sample& sample : samples) sum += 1 / sample.noise_share;
  return std::sqrt(sum / static_cast<double>(samples.size()));
}

double RootMeanSigma(const std::vector<Sample>& samples) {
  double variance = 0;
  for (const Sample& sample : samples) variance += 1 / sample.precision;
  return std::sqrt(variance / static_cast<double>(samples.size()));
}

double Combine(std::size_t first, const std::array<double, 4>& weights, std::span<const double> coefficients) {
  double sum = 0;
  for (std::size_t a = 0; a < 4; ++a) sum += weights[a] * coefficients[first + a];
  return sum;
}

}  // namespace

SplineGrid::Place SplineGrid::At(double time_s) const {
  const double position = (time_s - start_s) / step_s;
  Place place;
  place.first = static_cast<std::size_t>(std::clamp(std::floor(position), 0.0, static_cast<double>(count - 4)));
  const double u = position - static_cast<double>(place.first), v = 1 - u;
  place.value = {v * v * v / 6, (3 * u * u * u - 6 * u * u + 4) / 6, (-3 * u * u * u + 3 * u * u + 3 * u + 1) / 6,
                 u * u * u / 6};
  place.slope = {-v * v / 2 / step_s, (3 * u * u - 4 * u) / 2 / step_s, (-3 * u * u + 2 * u + 1) / 2 / step_s,
                 u * u / 2 / step_s};
  const double step2 = step_s * step_s;
  place.curve = {v / step2, (3 * u - 2) / step2, (1 - 3 * u) / step2, u / step2};
  return place;
}

SplineGrid MakeSplineGrid(std::span<const double> time_s, double step_s) {
  const double length = time_s.back() - time_s.front(), pieces = std::max(1.0, std::ceil(length / step_s * (1 - 1e-9)));
  if (!(step_s > 0) || pieces > 50 * static_cast<double>(time_s.size()) + 50) {
    const LongestStep longest = FindLongestStep(time_s);
    throw Fail(
        "smoothing: the time stamps run over {} s, but a step is {} s: they have holes too large to bridge, "
        "the "
        "longest of {} s after {} s",
        SignificantText(length, 4), SignificantText(step_s, 4), SignificantText(longest.step_s, 4),
        SignificantText(longest.after_s, 6));
  }
  return {time_s.front(), step_s, static_cast<std::size_t>(pieces) + 3};
}

double ValueAt(const SplineGrid::Place& place, std::span<const double> coefficients) {
  return Combine(place.first, place.value, coefficients);
}

double VarianceAt(const SplineGrid::Place& place, const BandedMatrix& covariance) {
  return Variance(covariance, place.first, place.value);
}

double SlopeAt(const SplineGrid::Place& place, std::span<const double> coefficients) {
  return Combine(place.first, place.slope, coefficients);
}

double CurveAt(const SplineGrid::Place& place, std::span<const double> coefficients) {
  return Combine(place.first, place.curve, coefficients);
}

SmoothSignal FitSmoothingSpline(const SplineGrid& grid, std::span<const double> time_s, std::span<const double> values,
                                std::span<const double> sigmas, const SmoothingOptions& options) {
  std::vector<Sample> samples = CollectSamples(grid, time_s, values, sigmas);
  const double sigma = RootMeanSigma(samples);
  const double sample_step_s = (time_s.back() - time_s.front()) / static_cast<double>(time_s.size() - 1);
  const auto roughness_of = [&](double cutoff_hz, double scale) {
    return RoughnessOfCutoff(cutoff_hz, scale * sigma, sample_step_s, grid.step_s);
  };
  constexpr double kFirstCutoffHz = 8;  // where the search starts; a few Hz above human motion
  constexpr double kConverged = 0.05,
                   kNearlyConverged = 0.5;  // of logarithms; a window's own error is ten times larger
  const auto reach = static_cast<std::size_t>(std::lround(options.window_s / grid.step_s));
  SmoothSignal signal;
  signal.roughness.assign(grid.count - 3, roughness_of(options.cutoff_hz.value_or(kFirstCutoffHz), 1));
  signal.noise_share.assign(time_s.size(), 1);
  signal.change = ChancesAtDifferences(grid, samples, options.memory_s);
  const bool has_gaps = std::ranges::any_of(signal.change, [](double chance) { return chance > 0; });
  Round round;
  // What the path can follow is the path's: scatter is looked for when the roughness is nearly known.
  bool seeks_scatter = false;
  for (; signal.iterations < options.max_iterations && !signal.converged; ++signal.iterations) {
    ThrowIfInterrupted();
    std::optional<Round> next_round = RunRound(grid, samples, signal.roughness);
    if (!next_round) throw Undetermined(time_s, values);
    round = *std::move(next_round);
    std::vector<double> shares = signal.noise_share;
    if (options.cutoff_hz || seeks_scatter) shares = FindNoiseShares(round, time_s, options.cutoff_hz.has_value());
    const double shares_change = LargestChange(signal.noise_share, shares);
    signal.noise_share = std::move(shares);
    for (Sample& sample : samples) sample.noise_share = signal.noise_share[sample.index];
    signal.noise_scale = ScatterOf(samples);
    std::vector<double> next = RoughnessIn(round, signal.roughness, reach, options.common);
    signal.quickest_roughness = *std::ranges::max_element(next);
    if (has_gaps) SetInGaps(signal.quickest_roughness, signal.change, next);
    const double least = roughness_of(options.least_cutoff_hz, signal.noise_scale);
    for (double& q : next)
      q = options.cutoff_hz ? roughness_of(*options.cutoff_hz, signal.noise_scale) : std::max(q, least);
    const double change = LargestChange(signal.roughness, next);
    signal.converged = (options.cutoff_hz || seeks_scatter) && change < kConverged && shares_change < kConverged;
    seeks_scatter |= change < kNearlyConverged;
    signal.roughness = std::move(next);
  }
  signal.coefficients = std::move(round.coefficients);
  signal.covariance = std::move(round.covariance);
  signal.slope_square = round.slope_square;
  signal.effective_parameters = round.effective_parameters;
  signal.risk = 2 * round.effective_parameters;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double share = samples[i].noise_share;
    signal.risk += share * round.residuals[i].square - std::log(share);
  }
  signal.cutoff_hz =
      CutoffOfRoughness(GeometricMean(signal.roughness), signal.noise_scale * sigma, sample_step_s, grid.step_s);
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

}  // namespace lake::gait
