// People as they stand up again and again, seen with noise: what intervals must hold.
#pragma once

#include "closed_form.h"
#include "lake/compare/misalignment.h"

namespace lake {

// A bump to and fro across the path, which neither placement nor timing makes.
inline void AddShape(double size_mm, compare::StsCurve& exo) {
  const compare::StsCurve before = exo;
  for (std::size_t i = 0; i < compare::kPercentSamples; ++i)
    exo.knee[i] +=
        compare::ShankAxes(before, i).col(1) * size_mm * std::sin(6 * std::numbers::pi * static_cast<double>(i) / 100);
}

inline constexpr double kSigma_mm = 0.3;

// Noise of a marker's sigma, alike over 2 % of the rise as the options have it: white noise through a window.
inline void AddFilteredNoise(compare::StsCurve& curve, std::mt19937& random) {
  constexpr int kReach = 6;
  const double width = compare::MisalignmentOptions{}.noise_width_percent / std::sqrt(2.0);
  std::normal_distribution<double> normal(0, kSigma_mm);
  std::vector<Eigen::Vector2d> white;
  for (int i = 0; i < compare::kPercentSamples + 2 * kReach; ++i) {
    const double x = normal(random), y = normal(random);
    white.emplace_back(x, y);
  }
  double power = 0;
  for (int k = -kReach; k <= kReach; ++k) power += std::exp(-std::pow(k / width, 2));
  for (int i = 0; i < compare::kPercentSamples; ++i)
    for (int k = -kReach; k <= kReach; ++k)
      curve.knee[static_cast<std::size_t>(i)] +=
          std::exp(-0.5 * std::pow(k / width, 2)) / std::sqrt(power) * white[static_cast<std::size_t>(i + k + kReach)];
  curve.knee_sigma_mm.assign(compare::kPercentSamples, kSigma_mm);
}

// A person as they stand up again and again: half of the rise is reached earlier or later, the shank leans more or
// less, onset and standing are told with an error. How much a person varies is itself drawn, around what others do.
class Person {
 public:
  explicit Person(std::mt19937& random) : random_(random) {
    constexpr double kFreedom = 4;
    std::chi_squared_distribution<double> chi_squared(kFreedom);
    variation_ = std::sqrt(kFreedom / chi_squared(random_));
  }

  // The mean of many would be the truth.
  compare::StsCurve Rise(const std::function<double(double)>& registration, const Eigen::Vector2d& offset_mm,
                         double shape_mm) {
    constexpr double kProgress = 0.04, kLean_deg = 1.5, kEvent = 0.01;
    std::normal_distribution<double> normal;
    const double half = variation_ * kProgress * normal(random_), lean_deg = variation_ * kLean_deg * normal(random_),
                 onset = kEvent * normal(random_), standing = kEvent * normal(random_);
    ClosedFormLeg leg;
    for (double* shank_deg : {&leg.seated_shank_deg, &leg.peak_shank_deg, &leg.standing_shank_deg})
      *shank_deg += lean_deg;
    const auto at = [&](double s) {
      return registration(s) + std::lerp(onset, standing, s) + half * std::sin(std::numbers::pi * s);
    };
    compare::StsCurve curve = MakeCurve(leg, at, offset_mm);
    curve.leg_knee = MakeCurve(leg, at).knee;
    AddShape(shape_mm, curve);
    AddFilteredNoise(curve, random_);
    return curve;
  }

 private:
  std::mt19937& random_;
  double variation_ = 1;
};

}  // namespace lake
