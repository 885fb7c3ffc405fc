#include "stamps.h"

#include <algorithm>

namespace lake {

bool StampCheck::Add(std::int64_t ticks) {
  if (ticks == AV_NOPTS_VALUE) return false;
  if (last_ == AV_NOPTS_VALUE) {
    first_ = last_ = ticks;
    return true;
  }
  if (ticks <= last_) return false;
  const std::int64_t interval = ticks - last_;
  shortest_ = intervals_ == 0 ? interval : std::min(shortest_, interval);
  longest_ = std::max(longest_, interval);
  ++intervals_;
  last_ = ticks;
  return true;
}

void StampCheck::Describe(VideoInfo& info) const {
  if (intervals_ == 0) return;
  info.shortest_interval_s = libav::Seconds(shortest_, time_base_);
  info.longest_interval_s = libav::Seconds(longest_, time_base_);
  // A regular recording's stamps, rounded to ticks, differ by one tick; two allow for a stamp that was rounded twice.
  const double mean = static_cast<double>(last_ - first_) / static_cast<double>(intervals_);
  info.irregular_stamps = static_cast<double>(longest_ - shortest_) > 0.1 * mean + 2;
}

std::optional<double> StampCheck::Time_s(std::int64_t ticks) const {
  return ticks == AV_NOPTS_VALUE ? std::nullopt : std::optional(libav::Seconds(ticks, time_base_));
}

}  // namespace lake
