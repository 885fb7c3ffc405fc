#include "loads_model.h"

#include <algorithm>
#include <cmath>

namespace lake::loads {

double TimeOf(const Rise& rise, int percent) {
  return std::lerp(rise.onset_s, rise.standing_s, percent / 100.0);
}

bool SeatIsLeft(const Rise& rise, double at_s, const LoadsOptions& options) {
  return at_s >= rise.seat_off_s + options.seat_release_s;
}

std::size_t FrameFrom(const std::vector<double>& time_s, double at_s) {
  return static_cast<std::size_t>(std::lower_bound(time_s.begin(), time_s.end(), at_s) - time_s.begin());
}

Between Locate(const std::vector<double>& time_s, double at_s) {
  const std::size_t after = std::clamp<std::size_t>(FrameFrom(time_s, at_s), 1, time_s.size() - 1);
  return {after - 1, std::clamp((at_s - time_s[after - 1]) / (time_s[after] - time_s[after - 1]), 0.0, 1.0)};
}

}  // namespace lake::loads
