#include "lake/loads/clock_offset.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lake::loads {
namespace {

// NaN outside the times, and next to a value that is NaN.
double Interpolate(std::span<const double> time_s, std::span<const double> values, double at_s) {
  const auto after = static_cast<std::size_t>(std::ranges::lower_bound(time_s, at_s) - time_s.begin());
  if (after < time_s.size() && time_s[after] == at_s) return values[after];
  if (after == 0 || after == time_s.size()) return std::numeric_limits<double>::quiet_NaN();
  const double part = (at_s - time_s[after - 1]) / (time_s[after] - time_s[after - 1]);
  return std::lerp(values[after - 1], values[after], part);
}

// Sums of a window's pairs that are known.
struct Regression {
  void Add(double x, double y) {
    ++count;
    const double from_x = x - mean_x, from_y = y - mean_y;
    mean_x += from_x / count;
    mean_y += from_y / count;
    xx += from_x * (x - mean_x);
    yy += from_y * (y - mean_y);
    xy += from_x * (y - mean_y);
  }
  // The share of y's variance that a rising line through the pairs leaves.
  double Unexplained() const { return xy > 0 && yy > 0 ? 1 - xy * xy / (xx * yy) : 1; }

  int count = 0;
  double mean_x = 0, mean_y = 0, xx = 0, yy = 0, xy = 0;
};

struct Needed {
  std::vector<double> time_s, force_n;
  double variation = 0;  // sum of squares about the mean
};

// The part of what the motion needs that the forces do not follow with this added to their times: of all windows, each
// by its own line.
double UnexplainedAt(double add_s, const std::vector<Needed>& windows, std::span<const double> time_s,
                     std::span<const double> measured_n) {
  double unexplained = 0, all = 0;
  for (const Needed& window : windows) {
    Regression regression;
    for (std::size_t i = 0; i < window.time_s.size(); ++i)
      if (const double force_n = Interpolate(time_s, measured_n, window.time_s[i] - add_s); std::isfinite(force_n))
        regression.Add(force_n, window.force_n[i]);
    const bool is_seen = 2 * static_cast<std::size_t>(regression.count) > window.time_s.size();
    unexplained += window.variation * (is_seen ? regression.Unexplained() : 1);
    all += window.variation;
  }
  return all > 0 ? unexplained / all : 1;
}

}  // namespace

std::optional<ClockOffset> FindClockOffset(std::span<const double> time_s, std::span<const double> needed_n,
                                           std::span<const double> measured_n, std::span<const Window> windows,
                                           double cutoff_hz) {
  std::vector<Needed> needed;
  double duration_s = 0;
  for (const Window& window : windows) {
    Needed& of = needed.emplace_back();
    Regression own;
    for (std::size_t i = window.begin; i < window.end; ++i) {
      if (!std::isfinite(needed_n[i])) continue;
      of.time_s.push_back(time_s[i]);
      of.force_n.push_back(needed_n[i]);
      own.Add(needed_n[i], needed_n[i]);
    }
    of.variation = own.yy;
    if (!of.time_s.empty()) duration_s += of.time_s.back() - of.time_s.front();
  }
  constexpr double kReach_s = 1, kStep_s = 0.02;
  const int reach = static_cast<int>(kReach_s / kStep_s);
  std::vector<double> unexplained;
  for (int k = -reach; k <= reach; ++k) unexplained.push_back(UnexplainedAt(k * kStep_s, needed, time_s, measured_n));
  const auto best = std::ranges::min_element(unexplained);
  // Of signals below the cutoff there are two independent values per period; each window has its own line.
  const double freedom = 2 * cutoff_hz * duration_s - 2 * static_cast<double>(needed.size()) - 1;
  constexpr double kMostUnexplained = 0.3;  // 0.05 of a person on two plates; of other forces most is left
  if (best == unexplained.begin() || best + 1 == unexplained.end() || *best > kMostUnexplained || freedom < 1)
    return std::nullopt;
  // The parabola through the least and its neighbours.
  const double slope = (best[1] - best[-1]) / (2 * kStep_s),
               bend = (best[1] - 2 * best[0] + best[-1]) / (kStep_s * kStep_s);
  // Body segments from tables, markers on skin, weight that goes from foot to foot: of five rises on two plates whose
  // clock is the markers' it came to 0.003 and 0.012 s.
  constexpr double kModel_s = 0.01;
  const double at_s = (best - unexplained.begin() - reach) * kStep_s;
  return ClockOffset{at_s - slope / bend, std::hypot(kModel_s, std::sqrt(2 * *best / (freedom * bend)))};
}

}  // namespace lake::loads
