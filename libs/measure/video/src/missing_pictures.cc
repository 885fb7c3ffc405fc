#include "missing_pictures.h"

#include <algorithm>

namespace lake::video {

void MissingPictures::Add(std::int64_t ticks) {
  const std::int64_t interval = ticks - previous_;
  const bool is_first = !has_previous_;
  previous_ = ticks;
  has_previous_ = true;
  if (is_first) return;
  std::int64_t usual = 0;
  if (intervals_ >= static_cast<std::int64_t>(kRemembered)) {
    std::array<std::int64_t, kRemembered> sorted = last_;
    std::ranges::nth_element(sorted, sorted.begin() + kRemembered / 2);
    usual = sorted[kRemembered / 2];
  }
  last_[static_cast<std::size_t>(intervals_++) % kRemembered] = interval;
  if (usual <= 0 || 2 * interval <= 3 * usual) {
    in_row_ = missing_in_row_ = 0;
    longest_before_row_ = longest_;
    return;
  }
  const std::int64_t missing = (interval + usual / 2) / usual - 1;
  ++gaps_;
  missing_ += missing;
  ++in_row_;
  missing_in_row_ += missing;
  // More than half of those remembered: from here on the usual interval is the new one.
  if (in_row_ > static_cast<std::int64_t>(kRemembered / 2)) {
    gaps_ -= in_row_;
    missing_ -= missing_in_row_;
    longest_ = longest_before_row_;
    in_row_ = missing_in_row_ = 0;
    return;
  }
  longest_ = std::max(longest_, interval);
}

}  // namespace lake::video
