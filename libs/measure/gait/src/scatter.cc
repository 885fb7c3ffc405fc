#include "scatter.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "lake/core/statistics.h"
#include "sizes.h"

namespace lake::gait {
namespace {

// Weighted means around a moment, and by which part of itself the mean of the squares is off by chance; all 0 where no
// residual is within reach.
struct Around {
  double square = 0, free = 0, chance = 0;
};

std::vector<Around> MeansAround(std::span<const Residual> residuals, std::span<const double> time_s) {
  std::vector<Around> all;
  all.reserve(time_s.size());
  std::size_t begin = 0;
  for (const double now_s : time_s) {
    while (begin < residuals.size() && residuals[begin].time_s < now_s - kMovement_s) ++begin;
    Around around;
    double weights = 0, weights2 = 0;
    for (std::size_t k = begin; k < residuals.size() && residuals[k].time_s < now_s + kMovement_s; ++k) {
      const double weight = 1 - std::abs(residuals[k].time_s - now_s) / kMovement_s;
      around.square += weight * residuals[k].square;
      around.free += weight * residuals[k].free;
      weights += weight;
      weights2 += weight * weight;
    }
    // The mean of n squares scatters by 1/√n of itself (two axes).
    if (weights > 0)
      around = {around.square / weights, around.free / weights, kForgiven * std::sqrt(weights2) / weights};
    all.push_back(around);
  }
  return all;
}

}  // namespace

std::vector<double> NoiseShares(std::span<const Residual> residuals, std::span<const double> time_s) {
  const auto share_of = [](double square, double free) { return square > free ? free / square : 1; };
  double all_square = 0, all_free = 0;
  for (const Residual& residual : residuals) {
    all_square += residual.square;
    all_free += residual.free;
  }
  std::vector<double> shares;
  shares.reserve(time_s.size());
  for (const Around& around : MeansAround(residuals, time_s))
    shares.push_back(around.free > 0 ? share_of(around.square, around.free * (1 + around.chance))
                                     : share_of(all_square, all_free));
  return shares;
}

std::vector<double> ChancesOfChange(std::span<const double> at_s, std::span<const double> seen_s, double usual_s,
                                    double memory_s) {
  std::vector<double> chances;
  chances.reserve(at_s.size());
  std::size_t next = 0;
  for (const double now_s : at_s) {
    while (next < seen_s.size() && seen_s[next] < now_s) ++next;
    const double after_s = next < seen_s.size() ? seen_s[next] - now_s : INFINITY,
                 before_s = next > 0 ? now_s - seen_s[next - 1] : INFINITY;
    chances.push_back(-std::expm1(-std::max(0.0, std::min(before_s, after_s) - usual_s / 2) / memory_s));
  }
  return chances;
}

std::vector<double> ScatterInGaps(std::span<const double> noise_shares, std::span<const char> seen,
                                  std::span<const double> time_s, double memory_s) {
  constexpr double kUsually = 0.95;  // of the moments in which it is seen it does less
  const auto extra = [&](std::size_t i) { return 1 / noise_shares[i] - 1; };
  std::vector<double> seen_s, extra_seen;
  seen_s.reserve(seen.size());
  extra_seen.reserve(seen.size());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    if (!seen[i]) continue;
    seen_s.push_back(time_s[i]);
    extra_seen.push_back(extra(i));
  }
  const double most = Quantile(std::move(extra_seen), kUsually);
  const std::vector<double> chances = ChancesOfChange(time_s, seen_s, MedianInterval(time_s), memory_s);
  std::vector<double> scatter(seen.size(), 0.0);
  for (std::size_t i = 0; i < seen.size(); ++i)
    if (!seen[i]) scatter[i] = extra(i) + chances[i] * std::max(0.0, most - extra(i));
  return scatter;
}

double LimitedShare(double share, double deviations) {
  return share * deviations > kTranslation ? kTranslation / deviations : share;
}

std::vector<double> SlowNoise(std::span<const Residual> residuals, std::span<const double> time_s) {
  std::vector<double> slow;
  slow.reserve(time_s.size());
  for (const Around& around : MeansAround(residuals, time_s))
    slow.push_back(std::max(0.0, around.free * (1 - around.chance) - around.square));
  return slow;
}

}  // namespace lake::gait
