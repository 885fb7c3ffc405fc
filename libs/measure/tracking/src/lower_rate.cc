#include "lower_rate.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lake::tracking {

double LowerRate::Source(std::size_t i) const {
  return std::floor(ratio * static_cast<double>(i) + phase);
}

std::optional<LowerRate> FindLowerRate(const std::vector<ToldFrame>& told) {
  constexpr std::size_t kFewest = 6;
  constexpr double kMayDisagree = 0.03, kReach = 0.04;
  constexpr int kLargestDenominator = 60, kPhases = 24;
  const auto found = static_cast<std::size_t>(std::ranges::count_if(told, &ToldFrame::is_repeated));
  if (found < kFewest || 25 * found < told.size()) return std::nullopt;
  // Where little moves, repetitions are found more seldom than new frames: the ratio may be less than it looks.
  const double most_ratio = kReach + 1 - static_cast<double>(found) / static_cast<double>(told.size());
  const auto most = static_cast<std::size_t>(kMayDisagree * static_cast<double>(told.size()));
  for (int denominator = 2; denominator <= kLargestDenominator; ++denominator)
    for (int numerator = 1; numerator < denominator; ++numerator) {
      if (std::gcd(numerator, denominator) != 1) continue;
      LowerRate rate{static_cast<double>(numerator) / denominator};
      if (rate.ratio > most_ratio) continue;
      std::size_t least = most + 1;
      double best_phase = 0;
      for (int step = 0; step < kPhases * denominator; ++step) {
        // Halfway between the phases at which the pattern changes, so that rounding decides nothing.
        rate.phase = (step + 0.5) / (kPhases * denominator);
        std::size_t disagree = 0;
        for (const ToldFrame& frame : told)
          if ((disagree += rate.Repeats(frame.frame) != frame.is_repeated) >= least) break;
        if (disagree >= least) continue;
        least = disagree;
        best_phase = rate.phase;
      }
      rate.phase = best_phase;
      if (least <= most) return rate;
    }
  return std::nullopt;
}

}  // namespace lake::tracking
