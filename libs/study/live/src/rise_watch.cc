#include "rise_watch.h"

#include <algorithm>

namespace lake::live {

bool RiseWatch::Add(double time_s, double knee_deg) {
  constexpr double kStill_s = 0.5, kStill_deg = 3;
  constexpr double kExtension_deg = 30;  // the least of a rise, as the events have it
  constexpr double kAgain_s = 0.5;       // a rest that was too short is longer then
  constexpr int kMostLooks = 8;
  last_.emplace_back(time_s, knee_deg);
  while (last_.front().first < time_s - kStill_s) last_.pop_front();
  most_deg_ = std::max(most_deg_, knee_deg);
  least_deg_ = std::min(least_deg_, knee_deg);
  const bool sits_down = knee_deg > least_deg_ + kExtension_deg;
  if (looks_ > 0 && sits_down) {
    looks_ = 0;
    most_deg_ = least_deg_ = knee_deg;
  }
  const auto [least, most] = std::ranges::minmax(last_, {}, &std::pair<double, double>::second);
  const bool is_still = most.second - least.second < kStill_deg && time_s - last_.front().first > 0.8 * kStill_s;
  if (!is_still || knee_deg > most_deg_ - kExtension_deg || looks_ == kMostLooks) return false;
  if (looks_ > 0 && time_s - looked_s_ < kAgain_s) return false;
  if (looks_ == 0) least_deg_ = knee_deg;
  ++looks_, looked_s_ = time_s;
  return true;
}

}  // namespace lake::live
