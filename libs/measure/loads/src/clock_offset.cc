#include "lake/loads/clock_offset.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "lake/sync/lag.h"

namespace lake::loads {

std::optional<ClockOffset> FindClockOffset(std::span<const double> time_s, std::span<const double> needed_n,
                                           std::span<const double> measured_n, std::span<const Window> windows) {
  const std::vector<double> times(time_s.begin(), time_s.end());
  const sync::Band band = sync::BandOf(times, times);
  const auto series = [&](std::span<const double> force_n) {
    const Eigen::Map<const Eigen::VectorXd> column(force_n.data(), static_cast<Eigen::Index>(force_n.size()));
    return sync::Sample(times, column, band);
  };
  sync::Series needed = series(needed_n);
  for (std::size_t row = 0; row < needed.known.size(); ++row) {
    const double at_s = needed.TimeAt(static_cast<Eigen::Index>(row));
    if (std::ranges::none_of(windows, [&](const Window& window) {
          return at_s >= time_s[window.begin] && at_s <= time_s[window.end - 1];
        }))
      needed.known[row] = 0;
  }
  // Body segments from tables, markers on skin, weight that goes from foot to foot: of five rises on two plates whose
  // clock is the markers' it came to 0.003 and 0.012 s.
  constexpr double kModel_s = 0.01;
  const sync::Lag lag = sync::FindLag(needed, series(measured_n),
                                      {.reach_s = 1, .least_overlap_s = 1, .most_sd_s = 0.05, .tolerance_s = kModel_s});
  if (lag.refusal != sync::LagRefusal::kNone) return std::nullopt;
  return ClockOffset{-lag.offset_s, std::hypot(kModel_s, std::sqrt(lag.covariance(0, 0)))};
}

}  // namespace lake::loads
