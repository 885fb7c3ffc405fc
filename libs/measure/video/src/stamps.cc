#include "stamps.h"

#include <algorithm>

#include "lake/core/error.h"

namespace lake::video {

bool Stamps::Add(std::int64_t ticks, std::int64_t duration) {
  const bool is_first = last_ == AV_NOPTS_VALUE;
  if (duration <= 0) duration = usual_ticks_;
  if (ticks == AV_NOPTS_VALUE && (is_first || duration <= 0)) {
    problem_ = "has no time stamp";
    return false;
  }
  if (ticks == AV_NOPTS_VALUE) {
    ticks = last_ + duration;
    ++repaired_;
  }
  if (is_first) {
    first_ = last_ = ticks;
    return true;
  }
  if (ticks <= last_) {
    problem_ = fmt::format("has time stamp {:.6f} s, not after the frame before it ({:.6f} s)",
                           libav::Seconds(ticks, time_base_), Last());
    return false;
  }
  const std::int64_t interval = ticks - last_;
  shortest_ = intervals_ == 0 ? interval : std::min(shortest_, interval);
  longest_ = std::max(longest_, interval);
  ++intervals_;
  last_ = ticks;
  return true;
}

void Stamps::Describe(VideoInfo& info) const {
  info.repaired_stamps = repaired_;
  if (intervals_ == 0) return;
  info.shortest_interval_s = libav::Seconds(shortest_, time_base_);
  info.longest_interval_s = libav::Seconds(longest_, time_base_);
  // A regular recording's intervals, rounded to ticks, differ by one tick; two if its stamps were rounded twice.
  const double mean = static_cast<double>(last_ - first_) / static_cast<double>(intervals_);
  info.irregular_stamps = static_cast<double>(longest_ - shortest_) > 0.1 * mean + 2;
}

std::optional<double> Stamps::First() const {
  if (first_ == AV_NOPTS_VALUE) return std::nullopt;
  return libav::Seconds(first_, time_base_);
}

}  // namespace lake::video
