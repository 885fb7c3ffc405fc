#include "noise.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <cmath>
#include <numbers>

#include "lake/compare/pointwise_error.h"
#include "lake/core/angles.h"
#include "lake/core/statistics.h"

namespace lake::compare {

using Eigen::Vector2d;

namespace {

void AddMarkerNoise(const StsCurve& curve, double width_percent, std::mt19937_64& random,
                    std::vector<Vector2d>& noise) {
  std::normal_distribution<double> normal;
  // White noise through a Gaussian window of half the width of the correlation wanted.
  const double width = width_percent / std::sqrt(2.0);
  const int reach = static_cast<int>(std::ceil(4 * width));
  std::vector<Vector2d> white;
  for (int i = 0; i < kPercentSamples + 2 * reach; ++i) {
    const double x = normal(random), y = normal(random);
    white.emplace_back(x, y);
  }
  std::vector<double> weights;
  double power = 0;
  for (int k = -reach; k <= reach; ++k) {
    weights.push_back(std::exp(-0.5 * std::pow(k / width, 2)));
    power += weights.back() * weights.back();
  }
  for (std::size_t i = 0; i < noise.size(); ++i) {
    Vector2d sum = Vector2d::Zero();
    for (std::size_t k = 0; k < weights.size(); ++k) sum += weights[k] * white[i + k];
    noise[i] += curve.knee_sigma_mm[i] / std::sqrt(power) * sum;
  }
}

// The path's change over one percent.
Vector2d ChangeAt(const std::vector<Vector2d>& path, std::size_t i) {
  const std::size_t before = i > 0 ? i - 1 : i, after = std::min(i + 1, path.size() - 1);
  return (path[after] - path[before]) / static_cast<double>(after - before);
}

double PercentOfSeconds(double s, const StsCurve& curve) {
  return curve.duration_s > 0 ? (kPercentSamples - 1) * s / curve.duration_s : 0;
}

// One repetition as far as it is not known from others: its markers' noise, its events' times and the person's own pace
// and lean.
std::vector<Vector2d> DrawKnown(const StsCurve& curve, const Variation& known, std::mt19937_64& random) {
  std::vector<Vector2d> noise(curve.knee.size(), Vector2d::Zero());
  AddMarkerNoise(curve, known.width_percent, random, noise);
  std::normal_distribution<double> normal;
  const double onset = PercentOfSeconds(std::hypot(known.event_sd_s, curve.onset_sd_s), curve) * normal(random),
               standing = PercentOfSeconds(std::hypot(known.event_sd_s, curve.standing_sd_s), curve) * normal(random),
               progress = known.progress_percent * normal(random),
               lean_rad = RadiansFromDegrees(known.lean_deg) * normal(random);
  for (std::size_t i = 0; i < noise.size(); ++i) {
    const double part = static_cast<double>(i) / (kPercentSamples - 1);
    const double late = std::lerp(onset, standing, part) + progress * std::sin(std::numbers::pi * part);
    const Vector2d shank = curve.knee[i] - curve.ankle[i];
    noise[i] += late * ChangeAt(curve.knee, i) + lean_rad * Vector2d(shank.y(), -shank.x());
  }
  return noise;
}

// The least k in 0..1 with which 2.5 % of the draws reach the estimate, to a thousandth; `size_of(k, draw)`.
template <typename SizeOf>
double LeastFactor(double estimate, std::size_t draws, const SizeOf& size_of) {
  constexpr double kHigh = 0.975;
  std::vector<double> sizes(draws);
  const auto reaches = [&](double k) {
    for (std::size_t draw = 0; draw < draws; ++draw) sizes[draw] = size_of(k, draw);
    return DrawnQuantile(sizes, kHigh) >= estimate;
  };
  if (reaches(0)) return 0;
  double low = 0, high = 1;
  for (int step = 0; step < 10; ++step) {
    const double middle = (low + high) / 2;
    (reaches(middle) ? high : low) = middle;
  }
  return low;
}

// The largest square that can be beneath an estimated one. A truth is as far from the estimate as the estimate from it,
// so that it is among the draws around the estimate, `squares`; noise of many dimensions, though, adds to every square,
// once to the estimate and once more to the draws: what it adds is taken off both times. `noise`: the squares of noise
// alone, whose dimensions are told by their spread (Satterthwaite 1946); up to three of them can cancel.
double LargestSquare(const std::vector<double>& squares, const std::vector<double>& noise) {
  constexpr double kHigh = 0.975, kFew = 3;
  const double mean = Mean(noise), deviation = StandardDeviation(noise),
               dimensions = deviation > 0 ? 2 * mean * mean / (deviation * deviation) : kFew;
  return DrawnQuantile(squares, kHigh) - 2 * mean * std::max(0.0, 1 - kFew / dimensions);
}

// |k curve + noise|² = k² curve² + k linear + noise².
struct Square {
  double curve = 0, linear = 0, noise = 0;

  double At(double k) const { return std::max(0.0, k * k * curve + k * linear + noise); }
};

Square SquareOf(const Vector2d& curve, const Vector2d& noise) {
  return {curve.squaredNorm(), 2 * curve.dot(noise), noise.squaredNorm()};
}

bool IsMean(const RegisteredTrial& trial) {
  return trial.repetitions.size() == 1 && trial.repetitions.front().repetition == 0;
}

}  // namespace

double DrawSteadiness(std::mt19937_64& random) {
  constexpr double kLeast = 1e-9;  // whose tails are finite
  return std::uniform_real_distribution<double>(kLeast, 1 - kLeast)(random);
}

std::vector<double> SquaredErrorOfMean(const RegisteredTrial& trial, const StsCurve& mean) {
  const auto n = static_cast<double>(trial.repetitions.size());
  std::vector<double> square(mean.knee.size(), 0);
  for (std::size_t i = 0; i < square.size(); ++i)
    if (trial.repetitions.size() == 1)
      square[i] = 2 * mean.knee_sigma_mm[i] * mean.knee_sigma_mm[i];
    else
      for (const StsCurve& curve : trial.repetitions)
        square[i] += (curve.knee[i] - mean.knee[i]).squaredNorm() / (n * (n - 1));
  return square;
}

std::vector<Vector2d> DrawErrorOfMean(const RegisteredTrial& trial, const StsCurve& mean, const Variation& known,
                                      double steadiness, std::mt19937_64& random) {
  if (IsMean(trial)) return DrawKnown(mean, {.width_percent = known.width_percent}, random);
  const auto n = static_cast<double>(trial.repetitions.size());
  const double own = n - 1, freedom = own + known.freedom;
  std::vector<Vector2d> error(mean.knee.size(), Vector2d::Zero());
  if (own == 0 || known.freedom > 0) {
    error = DrawKnown(trial.repetitions.front(), known, random);
    for (Vector2d& v : error) v *= std::sqrt((freedom > 0 ? known.freedom / freedom : 1) / n);
  }
  std::normal_distribution<double> normal;
  if (own > 0)
    for (const StsCurve& curve : trial.repetitions) {
      const double factor = normal(random) / std::sqrt(n * freedom);
      for (std::size_t i = 0; i < error.size(); ++i) error[i] += factor * (curve.knee[i] - mean.knee[i]);
    }
  if (freedom > 0) {
    const double tail = std::sqrt(freedom / quantile(boost::math::chi_squared(freedom), steadiness));
    for (Vector2d& v : error) v *= tail;
  }
  return error;
}

NoiseModel::NoiseModel(const RegisteredTrial& human, const RegisteredTrial& exo, const MisalignmentOptions& options)
    : human_(human),
      exo_(exo),
      options_(options),
      human_mean_(MeanCurve(human.repetitions)),
      exo_mean_(MeanCurve(exo.repetitions)) {}

MeanErrors NoiseModel::Draw(std::mt19937_64& random) const {
  const Variation known{.width_percent = options_.noise_width_percent,
                        .event_sd_s = options_.event_sd_s,
                        .progress_percent = options_.progress_sd_percent,
                        .lean_deg = options_.lean_sd_deg,
                        .freedom = options_.variation_freedom};
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random);
  const Vector2d replaced = options_.replacement_sd_mm * Vector2d(x, y);
  const double steadiness = DrawSteadiness(random);  // one person's in both trials
  MeanErrors errors{DrawErrorOfMean(human_, human_mean_, known, steadiness, random),
                    DrawErrorOfMean(exo_, exo_mean_, known, steadiness, random)};
  for (std::size_t i = 0; i < errors.exo.size(); ++i) errors.exo[i] += ShankAxes(human_mean_, i) * replaced;
  return errors;
}

std::vector<double> NoiseModel::Floor() const {
  std::vector<double> square = SquaredErrorOfMean(exo_, exo_mean_);
  const std::vector<double> human = SquaredErrorOfMean(human_, human_mean_);
  for (std::size_t i = 0; i < square.size(); ++i)
    square[i] += human[i] + 2 * options_.replacement_sd_mm * options_.replacement_sd_mm;
  return square;
}

std::vector<Vector2d> Sum(std::vector<Vector2d> a, const std::vector<Vector2d>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] += b[i];
  return a;
}

std::vector<Vector2d> Less(std::vector<Vector2d> a, const std::vector<Vector2d>& b) {
  for (std::size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
  return a;
}

Interval RmsInterval(const std::vector<Vector2d>& curve, const std::vector<std::vector<Vector2d>>& draws) {
  std::vector<Square> means;
  std::vector<double> squares, noises;
  const auto n = static_cast<double>(curve.size());
  for (const std::vector<Vector2d>& noise : draws) {
    Square& mean = means.emplace_back();
    for (std::size_t i = 0; i < curve.size(); ++i) {
      const Square square = SquareOf(curve[i], noise[i]);
      mean.curve += square.curve / n;
      mean.linear += square.linear / n;
      mean.noise += square.noise / n;
    }
    squares.push_back(mean.At(1));
    noises.push_back(mean.noise);
  }
  const double estimate = std::sqrt(MeanSquare(curve));
  const double least =
      LeastFactor(estimate, draws.size(), [&](double k, std::size_t draw) { return std::sqrt(means[draw].At(k)); });
  return {least * estimate, std::max(estimate, std::sqrt(std::max(0.0, LargestSquare(squares, noises))))};
}

Interval MaxInterval(const std::vector<Vector2d>& curve, const std::vector<std::vector<Vector2d>>& draws) {
  const auto largest = [&](double k, std::size_t draw) {
    double square = 0;
    for (std::size_t i = 0; i < curve.size(); ++i)
      square = std::max(square, (k * curve[i] + draws[draw][i]).squaredNorm());
    return std::sqrt(square);
  };
  double estimate = 0;
  for (const Vector2d& v : curve) estimate = std::max(estimate, v.norm());
  std::vector<double> drawn;
  for (std::size_t draw = 0; draw < draws.size(); ++draw) drawn.push_back(largest(1, draw));
  return {LeastFactor(estimate, draws.size(), largest) * estimate, std::max(estimate, PercentileInterval(drawn).high)};
}

}  // namespace lake::compare
