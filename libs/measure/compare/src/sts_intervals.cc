// The repetitions of a trial: sit-to-stands from onset to standing, strides from heel strike to heel strike.
#include <algorithm>
#include <cmath>
#include <map>

#include "lake/compare/registration.h"
#include "lake/core/error.h"
#include "sampling.h"

namespace lake::compare {

gait::MovementKind MovementIn(const TrialTables& trial) {
  const bool is_walking = std::ranges::any_of(
      trial.events, [](const motion::StsEvent& event) { return event.kind == motion::StsEventKind::kHeelStrike; });
  return is_walking ? gait::MovementKind::kWalking : gait::MovementKind::kSitToStand;
}

std::vector<StsInterval> FindStsIntervals(const TrialTables& trial) {
  const std::vector<double>& time_s = trial.motion.time_s;
  std::map<int, std::map<motion::StsEventKind, motion::StsEvent>> repetitions;
  for (const motion::StsEvent& event : trial.events) repetitions[event.repetition][event.kind] = event;
  if (time_s.empty() || repetitions.empty())
    throw Fail("{}: no sit-to-stand found in it (the hip must rise while the knee extends by 30° or more), and no walk",
               trial.name);
  const gait::Movement& movement = gait::MovementOf(MovementIn(trial));
  std::vector<StsInterval> intervals;
  for (const auto& [repetition, events] : repetitions) {
    const auto last_events = repetitions.find(repetition + (movement.ends_in_next ? 1 : 0));
    if (last_events == repetitions.end() || !events.contains(movement.begin) ||
        !last_events->second.contains(movement.end))
      continue;
    const motion::StsEvent &onset = events.at(movement.begin), &standing = last_events->second.at(movement.end);
    const double onset_s = onset.time_s, standing_s = standing.time_s;
    if (standing_s > time_s.back() || onset_s < time_s.front())
      throw Fail(
          "{}: repetition {} lasts from {:.3f} to {:.3f} s, but the recording from {:.3f} to {:.3f} s: it is shorter "
          "than the motion",
          trial.name, repetition, onset_s, standing_s, time_s.front(), time_s.back());
    const std::size_t first = FrameAfter(time_s, onset_s), last = FrameAfter(time_s, standing_s);
    if (last < first + 3) throw Fail("{}: repetition {} has only {} frames", trial.name, repetition, last - first + 1);
    intervals.push_back({repetition, onset_s, standing_s});
    if (std::isfinite(onset.sd_s)) intervals.back().onset_sd_s = onset.sd_s;
    if (std::isfinite(standing.sd_s)) intervals.back().standing_sd_s = standing.sd_s;
    if (const auto seat_off = events.find(motion::StsEventKind::kSeatOff); seat_off != events.end())
      intervals.back().seat_off_s = seat_off->second.time_s;
  }
  if (intervals.empty() && std::ranges::count(trial.events, motion::StsEventKind::kBottom, &motion::StsEvent::kind) > 0)
    throw Fail("{}: it is of squats, which lake gait measures: sit-to-stands and walks are compared", trial.name);
  if (intervals.empty() && movement.ends_in_next)
    throw Fail("{}: no {} is whole, from one heel strike to the next of the same leg: record a longer walk", trial.name,
               movement.repetition);
  if (intervals.empty())
    throw Fail(
        "{}: the recording is shorter than the motion: it ends at {:.3f} s, before the first rise reaches "
        "standing",
        trial.name, time_s.back());
  return intervals;
}

}  // namespace lake::compare
