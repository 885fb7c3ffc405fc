#include "noise.h"

#include <cmath>

namespace lake::compare {

using Eigen::Vector2d;

namespace {

std::vector<Vector2d> DrawMarkerNoise(const StsCurve& curve, double width_percent, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  // White noise through a Gaussian window of half the width of the correlation wanted.
  const double width = width_percent / std::sqrt(2.0);
  const int reach = static_cast<int>(std::ceil(4 * width));
  std::vector<Vector2d> white;
  for (int i = 0; i < kPercentSamples + 2 * reach; ++i) {
    const double x = normal(random), y = normal(random);
    white.emplace_back(x, y);
  }
  std::vector<Vector2d> noise(kPercentSamples, Vector2d::Zero());
  double power = 0;
  for (int k = -reach; k <= reach; ++k) {
    const double weight = std::exp(-0.5 * std::pow(k / width, 2));
    power += weight * weight;
    for (int i = 0; i < kPercentSamples; ++i)
      noise[static_cast<std::size_t>(i)] += weight * white[static_cast<std::size_t>(i + k + reach)];
  }
  for (std::size_t i = 0; i < noise.size(); ++i) noise[i] *= curve.knee_sigma_mm[i] / std::sqrt(power);
  return noise;
}

}  // namespace

std::vector<Vector2d> DrawErrorOfMean(const RegisteredTrial& trial, const StsCurve& mean, double width_percent,
                                      std::mt19937_64& random) {
  const std::size_t n = trial.repetitions.size();
  if (n == 1) return DrawMarkerNoise(mean, width_percent, random);
  std::uniform_int_distribution<std::size_t> pick(0, n - 1);
  std::vector<Vector2d> noise(kPercentSamples, Vector2d::Zero());
  const double share = std::sqrt(static_cast<double>(n) / static_cast<double>(n - 1)) / static_cast<double>(n);
  for (std::size_t draw = 0; draw < n; ++draw) {
    const StsCurve& curve = trial.repetitions[pick(random)];
    for (std::size_t i = 0; i < noise.size(); ++i) noise[i] += share * (curve.knee[i] - mean.knee[i]);
  }
  return noise;
}

NoiseModel::NoiseModel(const RegisteredTrial& human, const RegisteredTrial& exo, const MisalignmentOptions& options)
    : human_(human),
      exo_(exo),
      options_(options),
      human_mean_(MeanCurve(human.repetitions)),
      exo_mean_(MeanCurve(exo.repetitions)) {}

std::vector<Vector2d> NoiseModel::Draw(std::mt19937_64& random) const {
  std::normal_distribution<double> normal;
  const double x = normal(random), y = normal(random);
  const Vector2d replaced = options_.replacement_sd_mm * Vector2d(x, y);
  std::vector<Vector2d> noise = DrawErrorOfMean(exo_, exo_mean_, options_.noise_width_percent, random);
  const std::vector<Vector2d> human = DrawErrorOfMean(human_, human_mean_, options_.noise_width_percent, random);
  for (std::size_t i = 0; i < noise.size(); ++i) noise[i] += ShankAxes(human_mean_, i) * replaced - human[i];
  return noise;
}

}  // namespace lake::compare
