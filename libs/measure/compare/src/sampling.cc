#include "sampling.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lake::compare {
namespace {

// The frames of the nearest known samples, up to `each_side` before or at t, and as many after.
std::vector<std::size_t> KnownAround(const std::vector<double>& time_s, const std::vector<double>& values, double t,
                                     std::size_t each_side) {
  const auto after = static_cast<std::size_t>(std::upper_bound(time_s.begin(), time_s.end(), t) - time_s.begin());
  std::vector<std::size_t> frames;
  for (std::size_t i = after; i-- > 0 && frames.size() < each_side;)
    if (std::isfinite(values[i])) frames.insert(frames.begin(), i);
  const std::size_t before = frames.size();
  for (std::size_t i = after; i < time_s.size() && frames.size() < before + each_side; ++i)
    if (std::isfinite(values[i])) frames.push_back(i);
  return frames;
}

double Interpolate(const std::vector<double>& time_s, const std::vector<double>& values, double t,
                   std::size_t each_side) {
  const std::vector<std::size_t> frames = KnownAround(time_s, values, t, each_side);
  double value = frames.empty() ? std::numeric_limits<double>::quiet_NaN() : 0;
  for (const std::size_t j : frames) {
    double weight = 1;
    for (const std::size_t m : frames)
      if (m != j) weight *= (t - time_s[m]) / (time_s[j] - time_s[m]);
    value += weight * values[j];
  }
  return value;
}

}  // namespace

std::size_t FrameAfter(const std::vector<double>& time_s, double t) {
  const auto found = std::lower_bound(time_s.begin(), time_s.end(), t);
  return std::min(static_cast<std::size_t>(found - time_s.begin()), time_s.size() - 1);
}

double ValueAt(const std::vector<double>& time_s, const std::vector<double>& values, double t) {
  return Interpolate(time_s, values, t, 2);
}

double LinearValueAt(const std::vector<double>& time_s, const std::vector<double>& values, double t) {
  return Interpolate(time_s, values, t, 1);
}

double LongestGap(const std::vector<double>& time_s, const std::vector<double>& values, double from_s, double to_s) {
  constexpr double kTouch = 1e-9;
  double longest = 0;
  bool enclosed = false;
  std::size_t last = time_s.size();  // the last known frame; none yet
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    if (!std::isfinite(values[i])) continue;
    const bool starts_inside = last == time_s.size() && time_s[i] > from_s + kTouch;
    if (starts_inside) return std::numeric_limits<double>::infinity();
    if (last < time_s.size() && i > last + 1 && time_s[i] > from_s && time_s[last] < to_s)
      longest = std::max(longest, time_s[i] - time_s[last]);
    last = i;
    enclosed = time_s[i] >= to_s - kTouch;
    if (enclosed) break;
  }
  return enclosed ? longest : std::numeric_limits<double>::infinity();
}

}  // namespace lake::compare
