#include "scatter.h"

#include <algorithm>
#include <cmath>

namespace lake::gait {

std::vector<double> NoiseShares(std::span<const Residual> residuals, std::span<const double> time_s) {
  constexpr double kReach_s = 0.2;  // skin swings and heels strike within about this time
  // The mean of n squares scatters by 1/√n of itself (two axes); half of that is taken for chance.
  constexpr double kForgiven = 0.5;
  const auto share_of = [](double square, double free) { return square > free ? free / square : 1; };
  double all_square = 0, all_free = 0;
  for (const Residual& residual : residuals) all_square += residual.square, all_free += residual.free;
  std::vector<double> shares;
  shares.reserve(time_s.size());
  std::size_t begin = 0;
  for (const double now_s : time_s) {
    while (begin < residuals.size() && residuals[begin].time_s < now_s - kReach_s) ++begin;
    double square = 0, free = 0, weights = 0, weights2 = 0;
    for (std::size_t k = begin; k < residuals.size() && residuals[k].time_s < now_s + kReach_s; ++k) {
      const double weight = 1 - std::abs(residuals[k].time_s - now_s) / kReach_s;
      square += weight * residuals[k].square, free += weight * residuals[k].free;
      weights += weight, weights2 += weight * weight;
    }
    const double chance = weights2 > 0 ? kForgiven * std::sqrt(weights2) / weights : 0;
    shares.push_back(free > 0 ? share_of(square, free * (1 + chance)) : share_of(all_square, all_free));
  }
  return shares;
}

}  // namespace lake::gait
