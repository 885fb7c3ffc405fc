#include "lake/gait/plate_loads.h"

#include <algorithm>
#include <cmath>

#include "lake/core/statistics.h"

namespace lake::gait {

std::vector<PlateLoad> LoadsOf(const std::vector<double>& force_n, const std::vector<double>& time_s) {
  constexpr double kLeast_n = 20, kShortest_s = 0.1, kShortestGap_s = 0.05, kMostEmpty_n = 100, kLowest = 0.02;
  std::vector<double> empty_n;
  if (force_n.size() < 2) return {};
  const double lowest_n = Quantile(force_n, kLowest);
  std::ranges::copy_if(force_n, std::back_inserter(empty_n), [&](double n) {
    return std::abs(lowest_n) < kMostEmpty_n && std::abs(n - lowest_n) < kLeast_n;
  });
  const double limit_n = (empty_n.empty() ? 0 : Median(empty_n)) + kLeast_n;
  const double noise_n = empty_n.size() > 1 ? RobustDeviation(empty_n) : 0;
  const auto crossing = [&](std::size_t after, double& sd_s) {
    const double step_s = time_s[after] - time_s[after - 1], step_n = force_n[after] - force_n[after - 1];
    sd_s = std::hypot(step_s / 2 / std::sqrt(12), noise_n * step_s / step_n);
    return time_s[after - 1] + (limit_n - force_n[after - 1]) / step_n * step_s;
  };
  std::vector<PlateLoad> loads;
  for (std::size_t i = 0; i < force_n.size();) {
    if (force_n[i] <= limit_n) {
      ++i;
      continue;
    }
    PlateLoad load{NAN, NAN, NAN, NAN};
    if (i > 0) load.begin_s = crossing(i, load.begin_sd_s);
    while (i < force_n.size() && force_n[i] > limit_n) ++i;
    if (i < force_n.size()) load.end_s = crossing(i, load.end_sd_s);
    if (!loads.empty() && load.begin_s - loads.back().end_s < kShortestGap_s) {
      loads.back().end_s = load.end_s;
      loads.back().end_sd_s = load.end_sd_s;
    } else {
      loads.push_back(load);
    }
  }
  std::erase_if(loads, [](const PlateLoad& load) { return load.end_s - load.begin_s < kShortest_s; });
  return loads;
}

}  // namespace lake::gait
