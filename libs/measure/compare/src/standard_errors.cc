#include "standard_errors.h"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "lake/core/angles.h"
#include "lake/core/interrupt.h"

namespace lake::compare {
namespace {

using Eigen::ArrayXd;
using Eigen::Vector2d;

using Change = std::function<void(StsCurve&)>;

constexpr double kKnownExactly = 1e6;  // degrees of freedom

RegisteredTrial Changed(RegisteredTrial trial, const Change& change) {
  for (StsCurve& curve : trial.repetitions) change(curve);
  return trial;
}

RegisteredTrial Without(RegisteredTrial trial, std::size_t repetition) {
  trial.repetitions.erase(trial.repetitions.begin() + static_cast<std::ptrdiff_t>(repetition));
  return trial;
}

template <typename Value>
void ShiftInTime(std::vector<Value>& series, const std::function<double(double)>& late_percent) {
  const std::vector<Value> before = series;
  for (std::size_t i = 0; i < series.size(); ++i) {
    const std::size_t first = i > 0 ? i - 1 : i, last = std::min(i + 1, series.size() - 1);
    const Value change = (before[last] - before[first]) / static_cast<double>(last - first);
    series[i] += late_percent(static_cast<double>(i) / (kPercentSamples - 1)) * change;
  }
}

// `late_percent` of the part of the repetition, 0..1.
void ShiftInTime(StsCurve& curve, const std::function<double(double)>& late_percent) {
  for (auto* path : {&curve.ankle, &curve.knee, &curve.hip, &curve.leg_knee}) ShiftInTime(*path, late_percent);
  ShiftInTime(curve.knee_deg, late_percent);
}

// About the point that the paths are relative to: the ankle, of walking the hip.
void Lean(StsCurve& curve, double rad, gait::MovementKind movement) {
  const Eigen::Rotation2Dd turn(rad);
  const std::vector<Vector2d> pivot = movement == gait::MovementKind::kWalking ? curve.hip : curve.ankle;
  for (auto* path : {&curve.ankle, &curve.knee, &curve.hip, &curve.leg_knee})
    for (std::size_t i = 0; i < path->size(); ++i) (*path)[i] = pivot[i] + turn * ((*path)[i] - pivot[i]);
}

double PercentOfSeconds(double s, const StsCurve& curve) {
  return curve.duration_s > 0 ? (kPercentSamples - 1) * s / curve.duration_s : 0;
}

// Unit variance, correlated over `width_percent`: white noise through a Gaussian window of half that width.
std::vector<double> SmoothNoise(double width_percent, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  const double width = width_percent / std::numbers::sqrt2;
  const int reach = static_cast<int>(std::ceil(4 * width));
  std::vector<double> white(static_cast<std::size_t>(kPercentSamples + 2 * reach)), noise(kPercentSamples);
  for (double& value : white) value = normal(random);
  double power = 0;
  for (int k = -reach; k <= reach; ++k) {
    const double weight = std::exp(-0.5 * std::pow(k / width, 2));
    power += weight * weight;
    for (std::size_t i = 0; i < noise.size(); ++i) noise[i] += weight * white[i + static_cast<std::size_t>(k + reach)];
  }
  for (double& value : noise) value /= std::sqrt(power);
  return noise;
}

void AddMarkerNoise(StsCurve& curve, double width_percent, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const std::vector<double> x = SmoothNoise(width_percent, random), y = SmoothNoise(width_percent, random),
                            angle = SmoothNoise(width_percent, random);
  for (std::size_t i = 0; i < curve.knee.size(); ++i) {
    const double deg_per_mm =
        DegreesFromRadians(1 / (curve.knee[i] - curve.ankle[i]).norm() + 1 / (curve.hip[i] - curve.knee[i]).norm());
    curve.knee[i] += curve.knee_sigma_mm[i] * Vector2d(x[i], y[i]);
    curve.knee_deg[i] += deg_per_mm * curve.knee_sigma_mm[i] * angle[i];
  }
}

// A mean that another comparison wrote, or a predicted path.
bool IsMean(const RegisteredTrial& trial) {
  return trial.repetitions.size() == 1 && trial.repetitions.front().repetition == 0;
}

Error Zero(Eigen::Index quantities) {
  return {ArrayXd::Zero(quantities), ArrayXd::Zero(quantities)};
}

// Of estimates that deviate from `value` by one draw each.
void AddMean(const std::vector<ArrayXd>& drawn, const ArrayXd& value, Error& error) {
  for (const ArrayXd& estimate : drawn) {
    error.variance += (estimate - value).square() / static_cast<double>(drawn.size());
    error.bias += (estimate - value) / static_cast<double>(drawn.size());
  }
}

Error NoiseError(const OfTrial& estimate, const RegisteredTrial& trial, const ArrayXd& value,
                 const MisalignmentOptions& options) {
  constexpr std::uint64_t kDraws = 12;  // the standard deviation to 20 %; it is the least of the sources
  std::vector<ArrayXd> drawn;
  drawn.reserve(kDraws);
  for (std::uint64_t draw = 0; draw < kDraws; ++draw) {
    std::uint64_t seed = options.seed + draw * 1000;  // each repetition has its own
    drawn.push_back(
        estimate(Changed(trial, [&](StsCurve& c) { AddMarkerNoise(c, options.noise_width_percent, ++seed); })));
  }
  Error error = Zero(value.size());
  AddMean(drawn, value, error);
  return error;
}

// Of one repetition, as far as it is known without any other one: one standard deviation to each side.
Error KnownError(const OfTrial& estimate, const RegisteredTrial& trial, const ArrayXd& value,
                 const MisalignmentOptions& options) {
  using Deviation = std::function<void(StsCurve & curve, double deviations)>;
  const auto event_percent = [&](double own_s, const StsCurve& curve) {
    return PercentOfSeconds(std::hypot(options.event_sd_s, own_s), curve);
  };
  const std::vector<Deviation> all = {
      [&](StsCurve& c, double k) {
        ShiftInTime(c, [&](double s) { return k * options.progress_sd_percent * std::sin(std::numbers::pi * s); });
      },
      [&](StsCurve& c, double k) { Lean(c, k * RadiansFromDegrees(options.lean_sd_deg), trial.movement); },
      [&](StsCurve& c, double k) {
        ShiftInTime(c, [&](double s) { return k * (1 - s) * event_percent(c.onset_sd_s, c); });
      },
      [&](StsCurve& c, double k) {
        ShiftInTime(c, [&](double s) { return k * s * event_percent(c.standing_sd_s, c); });
      }};
  Error error = Zero(value.size());
  for (const Deviation& deviation : all) {
    const auto to = [&](double k) { return estimate(Changed(trial, [&](StsCurve& c) { deviation(c, k); })); };
    AddMean({to(1), to(-1)}, value, error);
  }
  return error;
}

// How many repetitions' knowledge of other people counts for.
double KnownFreedom(const RegisteredTrial& trial, const MisalignmentOptions& options) {
  return static_cast<int>(trial.repetitions.size()) < kLeastRepetitionsOfParts ? options.variation_freedom : 0;
}

Error TrialError(const OfTrial& estimate, const RegisteredTrial& trial, const ArrayXd& value,
                 const MisalignmentOptions& options) {
  if (IsMean(trial)) return NoiseError(estimate, trial, value, options);
  const auto n = static_cast<double>(trial.repetitions.size());
  const double own = n - 1, known = KnownFreedom(trial, options);
  Error error = Zero(value.size());
  if (known > 0) {
    const Error noise = NoiseError(estimate, trial, value, options),
                people = KnownError(estimate, trial, value, options);
    error = {known * (noise.variance + people.variance / n), known * (noise.bias + people.bias / n)};
  }
  if (own > 0) {
    const Error of_trial = JackknifeError(estimate, trial, value);
    error.variance += own * of_trial.variance;
    error.bias += own * of_trial.bias;
  }
  return {error.variance / (own + known), error.bias / (own + known)};
}

// Those of the trial with fewer, whichever of both varies more.
double LeastFreedom(const RegisteredTrial& human, const RegisteredTrial& exo, const MisalignmentOptions& options) {
  double least = kKnownExactly;
  for (const RegisteredTrial* trial : {&human, &exo})
    if (!IsMean(*trial))
      least = std::min(least, static_cast<double>(trial->repetitions.size()) - 1 + KnownFreedom(*trial, options));
  return least;
}

// By one offset in the human's shank frame, along each axis.
Error ReplacementError(const Estimate& estimate, const RegisteredTrial& human, const RegisteredTrial& exo,
                       const ArrayXd& value, const MisalignmentOptions& options) {
  const StsCurve mean = MeanCurve(human.repetitions);
  const auto put_back = [&](const Vector2d& offset_mm) {
    return estimate(human, Changed(exo, [&](StsCurve& curve) {
                      for (std::size_t i = 0; i < curve.knee.size(); ++i)
                        curve.knee[i] += ShankAxes(mean, i) * offset_mm;
                    }));
  };
  Error error = Zero(value.size());
  const double sd = options.replacement_sd_mm;
  AddMean({put_back({sd, 0}), put_back({-sd, 0})}, value, error);
  AddMean({put_back({0, sd}), put_back({0, -sd})}, value, error);
  return error;
}

}  // namespace

Error JackknifeError(const OfTrial& estimate, const RegisteredTrial& trial, const ArrayXd& value) {
  const auto n = static_cast<double>(trial.repetitions.size());
  std::vector<ArrayXd> without_one;
  without_one.reserve(trial.repetitions.size());
  for (std::size_t i = 0; i < trial.repetitions.size(); ++i) without_one.push_back(estimate(Without(trial, i)));
  ArrayXd mean = ArrayXd::Zero(value.size()), squares = mean;
  for (const ArrayXd& other : without_one) mean += other / n;
  for (const ArrayXd& other : without_one) squares += (other - mean).square();
  return {(n - 1) / n * squares, (n - 1) * (mean - value)};
}

Interval StandardErrors::Around(double value, Eigen::Index quantity) const {
  const Interval interval = StudentInterval(value, error.variance[quantity], freedom[quantity]);
  const double bias = error.bias[quantity];
  return {interval.low - std::max(0.0, bias), interval.high - std::min(0.0, bias)};
}

StandardErrors FindStandardErrors(const Estimate& estimate, const RegisteredTrial& human, const RegisteredTrial& exo,
                                  const MisalignmentOptions& options) {
  const auto careful = [&](const RegisteredTrial& h, const RegisteredTrial& e) {
    ThrowIfInterrupted();
    return estimate(h, e);
  };
  const ArrayXd value = careful(human, exo);
  const Error of_human =
                  TrialError([&](const RegisteredTrial&trial) { return careful(trial, exo); }, human, value, options),
              of_exo =
                  TrialError([&](const RegisteredTrial&trial) { return careful(human, trial); }, exo, value, options),
              replaced = ReplacementError(careful, human, exo, value, options);
  const ArrayXd drawn = of_human.variance + of_exo.variance, all = drawn + replaced.variance;
  // Without any variance the degrees of freedom do not matter.
  const ArrayXd freedom =
      (drawn > 0).select(all.square() / drawn.square() * LeastFreedom(human, exo, options), kKnownExactly);
  return {{all, of_human.bias + of_exo.bias + replaced.bias}, freedom.min(kKnownExactly)};
}

}  // namespace lake::compare
