// How a person who keeps still moves: slowly, 0.1 to 0.5 Hz.
#pragma once

#include <cmath>
#include <numbers>
#include <random>

namespace lake {

// Standard deviations of the trunk's and the knee's angle, and of the hip's place in each direction.
struct Sway {
  double trunk_deg = 0, knee_deg = 0, hip_mm = 0;
  unsigned seed = 1;
};

// A sum of sines of random phase with a standard deviation of 1.
class SlowNoise {
 public:
  explicit SlowNoise(std::mt19937& random) {
    std::uniform_real_distribution<double> phase(0, 2 * std::numbers::pi), rate_hz(0.1, 0.5);
    for (Wave& wave : waves_) wave = {2 * std::numbers::pi * rate_hz(random), phase(random)};
  }

  double At(double time_s) const {
    double sum = 0;
    for (const Wave& wave : waves_) sum += std::sin(wave.rad_s * time_s + wave.phase);
    return sum * Scale();
  }

  double SlopeAt(double time_s) const {
    double sum = 0;
    for (const Wave& wave : waves_) sum += wave.rad_s * std::cos(wave.rad_s * time_s + wave.phase);
    return sum * Scale();
  }

 private:
  struct Wave {
    double rad_s, phase;
  };

  double Scale() const { return std::sqrt(2.0 / std::size(waves_)); }

  Wave waves_[6];
};

}  // namespace lake
