#include "lower_rate.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace lake::tracking {
namespace {

// A ratio of the rates, and the logarithm of its odds.
struct RatioCandidate {
  double ratio = 0, log_odds = 0;
};

std::vector<RatioCandidate> RatioCandidates(double shown_hz, double most_ratio) {
  constexpr int kLargestDenominator = 12;
  std::map<double, double> odds;
  const auto add = [&](double ratio, double its_odds) {
    const auto same = odds.lower_bound(ratio - 1e-9);
    odds[same != odds.end() && same->first < ratio + 1e-9 ? same->first : ratio] += its_odds;
  };
  for (const double film_hz : kFilmRates_hz) add(film_hz / shown_hz, 1.0 / static_cast<double>(kFilmRates_hz.size()));
  for (int n = 2; n <= kLargestDenominator; ++n)
    for (int m = 1; m < n; ++m)
      if (std::gcd(m, n) == 1) add(static_cast<double>(m) / n, 1.0 / (n * n));
  std::vector<RatioCandidate> candidates;
  for (const auto& [ratio, its_odds] : odds)
    if (ratio <= most_ratio) candidates.push_back({ratio, std::log(its_odds)});
  return candidates;
}

std::size_t Disagreements(const std::vector<JudgedFrame>& judged, const LowerRate& rate, std::size_t limit) {
  std::size_t count = 0;
  for (const JudgedFrame& frame : judged)
    if ((count += rate.Repeats(frame.frame) != frame.is_repeated) >= limit) break;
  return count;
}

}  // namespace

double LowerRate::Source(std::size_t i) const {
  return std::floor(ratio * static_cast<double>(i) + phase);
}

std::optional<LowerRate> FindLowerRate(const std::vector<JudgedFrame>& judged, double shown_hz) {
  constexpr double kMayDisagree = 0.03, kReach = 0.04;
  constexpr int kPhases = 1200;
  const auto found = static_cast<std::size_t>(std::ranges::count_if(judged, &JudgedFrame::is_repeated));
  if (found == 0 || found == judged.size()) return std::nullopt;
  const auto frames = static_cast<double>(judged.size()), share = static_cast<double>(found) / frames;
  // Logarithms of likelihoods: of a frame that agrees over one that does not, and of repetitions that recur in no way.
  const double disagreement = std::log((1 - kMayDisagree) / kMayDisagree),
               at_random = frames * (share * std::log(share) + (1 - share) * std::log(1 - share));
  const auto most = static_cast<std::size_t>(kMayDisagree * frames);
  std::optional<LowerRate> best;
  double best_log = at_random - frames * std::log(1 - kMayDisagree);  // over that of frames that all agree
  // Where little moves, repetitions are found more seldom than new frames: the ratio may be less than it looks.
  for (const auto& [ratio, log_odds] : RatioCandidates(shown_hz, 1 - share + kReach)) {
    const double left = (log_odds - best_log) / disagreement;
    if (left <= 0) continue;
    std::size_t least = std::min(most + 1, static_cast<std::size_t>(std::ceil(left)));
    // Halfway between the phases at which the pattern changes, so that rounding decides nothing, and in the middle of
    // those that agree as well.
    const auto rate_at = [&ratio = ratio](double step) { return LowerRate{ratio, (step + 0.5) / kPhases}; };
    int first = 0, last = -2;
    for (int step = 0; step < kPhases; ++step) {
      const std::size_t disagree = Disagreements(judged, rate_at(step), least + 1);
      if (disagree < least) first = step;
      if (disagree < least || (disagree == least && last == step - 1)) last = step;
      least = std::min(least, disagree);
    }
    if (last < 0) continue;
    best = rate_at(0.5 * (first + last));
    best_log = log_odds - disagreement * static_cast<double>(least);
  }
  return best;
}

}  // namespace lake::tracking
