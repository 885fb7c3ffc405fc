// The sit-to-stands of a trial, from onset to standing.
#include <cmath>
#include <map>

#include "lake/compare/registration.h"
#include "lake/core/error.h"
#include "sampling.h"

namespace lake::compare {

std::vector<StsInterval> FindStsIntervals(const TrialTables& trial) {
  const std::vector<double>& time_s = trial.motion.time_s;
  std::map<int, std::map<motion::StsEventKind, motion::StsEvent>> repetitions;
  for (const motion::StsEvent& event : trial.events) repetitions[event.repetition][event.kind] = event;
  if (time_s.empty() || repetitions.empty())
    throw Fail("{}: no sit-to-stand found in it (the hip must rise while the knee extends by 30° or more)", trial.name);
  std::vector<StsInterval> intervals;
  for (const auto& [repetition, events] : repetitions) {
    if (!events.contains(motion::StsEventKind::kOnset) || !events.contains(motion::StsEventKind::kStanding)) continue;
    const motion::StsEvent &onset = events.at(motion::StsEventKind::kOnset),
                           &standing = events.at(motion::StsEventKind::kStanding);
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
  if (intervals.empty())
    throw Fail(
        "{}: the recording is shorter than the motion: it ends at {:.3f} s, before the first rise reaches "
        "standing",
        trial.name, time_s.back());
  return intervals;
}

}  // namespace lake::compare
