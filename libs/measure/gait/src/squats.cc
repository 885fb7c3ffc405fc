#include "lake/gait/squats.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace lake::gait {
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

// Whether the ankle keeps its height from one event to another, as it does not in a jump.
bool FootStays(const LegFitResult& leg, const motion::StsEvent& from, const motion::StsEvent& to) {
  constexpr double kMostRise = 0.1;  // of the leg's length
  const motion::MarkerTrack* ankle = leg.trajectory.Find(leg.leg_markers.ankle);
  std::vector<double> heights;
  for (std::size_t i = 0; ankle && i < ankle->samples.size(); ++i)
    if (const double time_s = leg.motion.time_s[i];
        time_s >= from.time_s && time_s <= to.time_s && ankle->samples[i].IsKnown())
      heights.push_back(ankle->samples[i].position.dot(leg.up));
  if (heights.empty()) return false;
  const auto [low, high] = std::ranges::minmax(heights);
  return high - low < kMostRise * leg.signals.leg_length;
}

}  // namespace

std::vector<motion::StsEvent> FindSquats(const LegFitResult& leg) {
  const std::vector<motion::StsEvent> seen = FindStsEvents(leg.signals).squats;
  std::vector<motion::StsEvent> events;
  for (std::size_t i = 0; i < seen.size(); i += 3)
    if (FootStays(leg, seen[i], seen[i + 2]))
      for (std::size_t k = i; k < i + 3; ++k) {
        events.push_back(seen[k]);
        events.back().repetition = static_cast<int>((events.size() - 1) / 3) + 1;
      }
  return events;
}

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
