#include <algorithm>
#include <cmath>

#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/sync/align.h"

namespace lake::sync {
namespace {

constexpr double kMostDrift = 1e-3;

// Rises of A and B that are one, by their order.
struct Matches {
  std::vector<double> a_s, b_s;
  double square = 0;  // of the differences from their mean
};

// With this offset, each rise of B and the nearest of A, as far as clocks may differ meanwhile.
Matches MatchesAt(double offset_s, double from_s, const std::vector<double>& rises_a,
                  const std::vector<double>& rises_b, double tolerance_s) {
  Matches matches;
  std::vector<double> apart;
  for (const double b : rises_b) {
    const auto nearest = std::ranges::min_element(rises_a, {}, [&](double a) { return std::abs(a - b - offset_s); });
    if (std::abs(*nearest - b - offset_s) > tolerance_s + kMostDrift * std::abs(b - from_s)) continue;
    matches.a_s.push_back(*nearest);
    matches.b_s.push_back(b);
    apart.push_back(*nearest - b);
  }
  for (const double d : apart) matches.square += std::pow(d - Mean(apart), 2);
  return matches;
}

Matches FindMatches(const std::vector<double>& rises_a, const std::vector<double>& rises_b, double tolerance_s,
                    const std::string& both) {
  Matches best;
  double best_s = 0, best_b = 0;
  bool is_one = true;
  for (const double a : rises_a)
    for (const double b : rises_b) {
      const Matches matches = MatchesAt(a - b, b, rises_a, rises_b, tolerance_s);
      const bool is_another = std::abs(a - b - best_s) > 2 * tolerance_s + kMostDrift * std::abs(b - best_b);
      if (matches.a_s.size() == best.a_s.size() && is_another) is_one = false;
      if (matches.a_s.size() < best.a_s.size() ||
          (matches.a_s.size() == best.a_s.size() && matches.square >= best.square))
        continue;
      if (matches.a_s.size() > best.a_s.size()) is_one = true;
      best = matches;
      best_s = a - b;
      best_b = b;
    }
  if (!is_one)
    throw Fail(
        "{}: cannot be aligned: the signal rises {} and {} times, and fits at several offsets; send it once, or at "
        "intervals that differ",
        both, rises_a.size(), rises_b.size());
  if (best.a_s.size() < 2 && std::min(rises_a.size(), rises_b.size()) > 1)
    throw Fail("{}: cannot be aligned: the signal rises {} and {} times, and no two of the intervals agree", both,
               rises_a.size(), rises_b.size());
  return best;
}

}  // namespace

Signal SampledSignal(std::vector<double> rises_s, const Movement& recording) {
  return {.rises_s = std::move(rises_s), .sd_s = MedianInterval(recording.time_s) / std::sqrt(12.0)};
}

Alignment AlignBySignal(const Signal& in_a, const Signal& in_b, const Movement& a, const Movement& b,
                        const AlignOptions& options) {
  const std::string both = fmt::format("{} and {}", a.file.string(), b.file.string());
  // As far as two that are uniform within intervals of these SDs can be apart.
  const double tolerance_s = std::sqrt(12.0) * (in_a.sd_s + in_b.sd_s);
  const Matches matches = FindMatches(in_a.rises_s, in_b.rises_s, tolerance_s, both);
  const double variance = in_a.sd_s * in_a.sd_s + in_b.sd_s * in_b.sd_s;
  const double from_s = b.time_s.front(), prior = 1e-6 * options.drift_sd_ppm;
  // a − b = offset + drift (b − from), least squares with the drift's prior; the offset at the rises' mean.
  const double middle_s = Mean(matches.b_s);
  double xx = 0, xy = 0, apart_s = 0;
  const auto count = static_cast<double>(matches.a_s.size());
  for (std::size_t i = 0; i < matches.a_s.size(); ++i) {
    const double x = matches.b_s[i] - middle_s, y = matches.a_s[i] - matches.b_s[i];
    xx += x * x;
    xy += x * y;
    apart_s += y / count;
  }
  const double weight = prior > 0 ? xx / variance + 1 / (prior * prior) : 0;
  const double drift = weight > 0 ? xy / variance / weight : 0, drift_variance = weight > 0 ? 1 / weight : 0;
  Alignment alignment;
  alignment.clock = {.offset_s = apart_s + drift * (from_s - middle_s),
                     .drift_ppm = 1e6 * drift,
                     .from_s = from_s,
                     .sd_s = 0,
                     .method = "signal"};
  alignment.drift_sd_ppm = 1e6 * std::sqrt(drift_variance);
  const double reach_s = std::max(middle_s - from_s, b.time_s.back() - middle_s);
  alignment.clock.sd_s = std::sqrt(variance / count + drift_variance * reach_s * reach_s);
  alignment.overlap_s = matches.b_s.back() - matches.b_s.front();
  alignment.comparison.name = fmt::format("rises of the signal: {}", matches.a_s.size());
  for (std::size_t i = 0; i < matches.a_s.size(); ++i)
    alignment.parts.push_back({.time_s = matches.a_s[i],
                               .departure_s = matches.a_s[i] - alignment.clock.FromB(matches.b_s[i]),
                               .sd_s = std::sqrt(variance)});
  return alignment;
}

}  // namespace lake::sync
