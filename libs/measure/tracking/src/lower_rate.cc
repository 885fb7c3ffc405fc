#include "lower_rate.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lake::tracking {

double LowerRate::Source(std::size_t i) const {
  return std::floor(ratio * static_cast<double>(i) + phase);
}

std::optional<LowerRate> FindLowerRate(const std::vector<ToldFrame>& told) {
  constexpr double kMayDisagree = 0.03, kReach = 0.04;
  constexpr int kLargestDenominator = 60, kPhases = 24;
  const auto found = static_cast<std::size_t>(std::ranges::count_if(told, &ToldFrame::is_repeated));
  if (found == 0 || found == told.size()) return std::nullopt;
  const auto frames = static_cast<double>(told.size()), share = static_cast<double>(found) / frames;
  // Where little moves, repetitions are found more seldom than new frames: the ratio may be less than it looks.
  const double most_ratio = kReach + 1 - share;
  const auto most = static_cast<std::size_t>(kMayDisagree * frames);
  // Logarithms of likelihoods: of a frame that agrees over one that does not, and of repetitions that recur in no way.
  const double disagreement = std::log((1 - kMayDisagree) / kMayDisagree),
               at_random = frames * (share * std::log(share) + (1 - share) * std::log(1 - share));
  const auto log_odds_of = [](int denominator) { return -3 * std::log(denominator); };  // n of as many phases, 1/n²
  std::optional<LowerRate> best;
  double least_cost = frames * std::log(1 - kMayDisagree) - at_random;  // without what agrees costs
  for (int denominator = 2; denominator <= kLargestDenominator; ++denominator)
    for (int numerator = 1; numerator < denominator; ++numerator) {
      if (std::gcd(numerator, denominator) != 1) continue;
      LowerRate rate{static_cast<double>(numerator) / denominator};
      if (rate.ratio > most_ratio) continue;
      const double left = (least_cost + log_odds_of(denominator)) / disagreement;  // of disagreements, for a better one
      if (left <= 0) return best;
      const std::size_t limit = std::min(most + 1, static_cast<std::size_t>(std::ceil(left)));
      std::size_t least = limit;
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
      if (least == limit) continue;
      rate.phase = best_phase;
      least_cost = disagreement * static_cast<double>(least) - log_odds_of(denominator);
      best = rate;
    }
  return best;
}

}  // namespace lake::tracking
