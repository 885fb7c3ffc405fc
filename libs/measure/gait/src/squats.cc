#include "lake/gait/squats.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "lake/core/statistics.h"

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
    const double by_frame_s = MedianInterval(s_.time_s) / std::sqrt(12);
    return {.repetition = repetition,
            .kind = kind,
            .frame = s_.frame[i],
            .time_s = s_.time_s[i],
            .sd_s = std::hypot(by_frame_s, (TimeToDeviation(i, -1) + TimeToDeviation(i, 1)) / 2)};
  }

 private:
  // From a frame, in this direction, until the hip's speed differs by its standard deviation: where it comes to rest
  // slowly that takes longer than its slope there says.
  double TimeToDeviation(std::size_t from, int direction) const {
    const double deviation = s_.sd.hip_up_speed[from];
    double passed = 0;
    for (std::size_t i = from; direction < 0 ? i > 0 : i + 1 < s_.frame.size();) {
      const std::size_t next = direction < 0 ? i - 1 : i + 1;
      const double change = std::abs(s_.hip_up_speed[next] - s_.hip_up_speed[from]);
      if (!std::isfinite(change)) return std::abs(s_.time_s[i] - s_.time_s[from]);
      if (change > deviation)
        return std::abs(std::lerp(s_.time_s[i], s_.time_s[next], (deviation - passed) / (change - passed)) -
                        s_.time_s[from]);
      passed = change;
      i = next;
    }
    return std::abs(s_.time_s[direction < 0 ? 0 : s_.time_s.size() - 1] - s_.time_s[from]);
  }

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

namespace {

constexpr const char* kSchoenfeld = "Schoenfeld 2010, J Strength Cond Res 24(12), 3497-3506";

constexpr auto kSquatFields = std::to_array<Field<Squat>>(
    {{"begin_s", "s", "time at which the descent begins", kLake, &Squat::begin_s, 3, FieldKind::kMoment},
     {"squat_s", "s", "from the beginning of the descent to standing", kLake, &Squat::squat_s, 3},
     {"descent_s", "s", "from the beginning of the descent to the bottom", kSchoenfeld, &Squat::descent_s, 3},
     {"ascent_s", "s", "from the bottom to standing", kSchoenfeld, &Squat::ascent_s, 3},
     {"depth_mm", "mm", "how far the hip goes down from the beginning of the descent to the bottom", kSchoenfeld,
      &Squat::depth, 0},
     {"knee_max_deg", "deg", "largest knee flexion", kSchoenfeld, &Squat::knee_max_deg, 1},
     {"trunk_max_deg", "deg", "largest forward lean of the trunk from the vertical", kSchoenfeld, &Squat::trunk_max_deg,
      1},
     {"descent_speed_mm_s", "mm/s", "largest speed of the hip downward", kLake, &Squat::descent_speed, 0},
     {"ascent_speed_mm_s", "mm/s", "largest speed of the hip upward", kLake, &Squat::ascent_speed, 0},
     {"knee_extension_max_deg_s", "deg/s", "largest speed of the knee's extension", kLake, &Squat::knee_extension_deg_s,
      0}});

// The largest of a signal between two frames, or with sign −1 of its opposite.
Measured Largest(const std::vector<double>& signal, const std::vector<double>& sd, std::size_t from, std::size_t to,
                 double sign = 1) {
  Measured largest;
  for (std::size_t i = from; i <= to; ++i)
    if (const double value = sign * signal[i]; std::isfinite(value) && !(value <= largest.value))
      largest = {value, sd[i]};
  return largest;
}

Measured BetweenEvents(const motion::StsEvent& from, const motion::StsEvent& to) {
  return {to.time_s - from.time_s, std::hypot(from.sd_s, to.sd_s)};
}

}  // namespace

std::span<const Field<Squat>> Squat::Fields() {
  return kSquatFields;
}

Measures<Squat> MeasureSquats(const LegFitResult& leg) {
  using enum motion::StsEventKind;
  const StsSignals& s = leg.signals;
  const auto at = [&](const motion::StsEvent& event) {
    const auto i = std::ranges::lower_bound(s.frame, event.frame) - s.frame.begin();
    return std::min(static_cast<std::size_t>(i), s.frame.size() - 1);
  };
  std::map<int, std::map<motion::StsEventKind, motion::StsEvent>> events;
  for (const motion::StsEvent& event : leg.events) events[event.repetition][event.kind] = event;
  std::vector<Squat> squats;
  for (const auto& [repetition, of] : events) {
    if (!of.contains(kDescent) || !of.contains(kBottom) || !of.contains(kStanding)) continue;
    const motion::StsEvent &descent = of.at(kDescent), &bottom = of.at(kBottom), &standing = of.at(kStanding);
    const std::size_t from = at(descent), low = at(bottom), to = at(standing);
    Squat& squat = squats.emplace_back();
    squat.repetition = repetition;
    squat.begin_s = {descent.time_s, descent.sd_s};
    squat.squat_s = BetweenEvents(descent, standing);
    squat.descent_s = BetweenEvents(descent, bottom);
    squat.ascent_s = BetweenEvents(bottom, standing);
    squat.depth = {s.hip_height[from] - s.hip_height[low],
                   std::hypot(s.sd.hip_height[from], s.sd.hip_height[low], s.hip_up_speed[from] * descent.sd_s)};
    squat.knee_max_deg = Largest(s.knee_deg, s.sd.knee_deg, from, to);
    squat.trunk_max_deg = Largest(s.trunk_deg, s.sd.trunk_deg, from, to);
    squat.descent_speed = Largest(s.hip_up_speed, s.sd.hip_up_speed, from, to, -1);
    squat.ascent_speed = Largest(s.hip_up_speed, s.sd.hip_up_speed, from, to);
    squat.knee_extension_deg_s = Largest(s.knee_deg_s, s.sd.knee_deg_s, from, to, -1);
  }
  return WithMeans(std::move(squats));
}

}  // namespace lake::gait
