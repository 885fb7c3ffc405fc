#include "squat.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace lake::gait {
namespace {

constexpr double kFraction = 0.05;  // of the peak speed, as of standing in a sit-to-stand

class SquatFinder {
 public:
  explicit SquatFinder(const LegFitResult& leg) : leg_(leg), s_(leg.signals) {}

  // From the bottom to the last frame, in this direction, before the hip stops; nullopt where it does not.
  std::optional<std::size_t> Stop(std::size_t bottom, int direction) const {
    double peak = 0;
    for (std::size_t i = bottom;;) {
      const double speed = direction * s_.hip_up_speed[i];  // away from the bottom
      if (!std::isfinite(speed)) return std::nullopt;
      peak = std::max(peak, speed);
      const double risen = s_.hip_height[i] - s_.hip_height[bottom];
      if (risen > kLeastDepth * s_.leg_length && speed < kFraction * peak) return i;
      if (direction < 0 ? i == 0 : i + 1 == s_.frame.size()) return std::nullopt;
      i = direction < 0 ? i - 1 : i + 1;
    }
  }

  // Where the hip is lowest before the rise is under way.
  std::size_t Bottom(const motion::StsEvent& rise) const {
    auto i = static_cast<std::size_t>(std::ranges::lower_bound(s_.frame, rise.frame) - s_.frame.begin());
    while (i > 0 && s_.hip_height[i - 1] < s_.hip_height[i]) --i;
    return i;
  }

  bool FootStays(std::size_t from, std::size_t to) const {
    constexpr double kMostRise = 0.1;  // of the leg's length
    const motion::MarkerTrack* ankle = leg_.trajectory.Find(leg_.leg_markers.ankle);
    std::vector<double> heights;
    for (std::size_t i = from; ankle && i <= to; ++i)
      if (ankle->samples[i].IsKnown()) heights.push_back(ankle->samples[i].position.dot(leg_.up));
    if (heights.empty()) return false;
    const auto [low, high] = std::ranges::minmax(heights);
    return high - low < kMostRise * s_.leg_length;
  }

  motion::StsEvent Event(int repetition, motion::StsEventKind kind, std::size_t i) const {
    return {.repetition = repetition, .kind = kind, .frame = s_.frame[i], .time_s = s_.time_s[i]};
  }

 private:
  static constexpr double kLeastDepth = 0.1;  // of the leg's length
  const LegFitResult& leg_;
  const StsSignals& s_;
};

}  // namespace

std::vector<motion::StsEvent> FindSquats(const LegFitResult& leg) {
  using enum motion::StsEventKind;
  const SquatFinder finder(leg);
  std::vector<motion::StsEvent> events;
  int repetition = 0;
  for (const motion::StsEvent& rise : leg.without_seat) {
    const std::size_t bottom = finder.Bottom(rise);
    const auto descent = finder.Stop(bottom, -1), standing = finder.Stop(bottom, 1);
    if (!descent || !standing || !finder.FootStays(*descent, *standing)) continue;
    ++repetition;
    events.push_back(finder.Event(repetition, kDescent, *descent));
    events.push_back(finder.Event(repetition, kBottom, bottom));
    events.push_back(finder.Event(repetition, kStanding, *standing));
  }
  return events;
}

}  // namespace lake::gait
