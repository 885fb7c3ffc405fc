// Events that a person corrected: rows as in events.csv, each with time_s, frame or both. They replace the events
// found. A row with neither removes the event. Of walking, whose events belong together, they replace all that were
// found, but for those whose column `others` says `stay`, as lake review moves and adds single ones.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lake/motion/leg_motion.h"

namespace lake::motion {

struct EventCorrection {
  int repetition = 1;  // from 1; of walking 0 before the first heel strike
  StsEventKind kind = StsEventKind::kOnset;
  std::optional<std::int64_t> frame;  // without a time, the event is at this frame's
  std::optional<double> time_s;       // without a frame, the event's is the one nearest to this
  std::string where = {};             // "events.csv:3"
  double sd_s = LegSample::kUnknown;  // of the time; only of walking, as in events.csv
  bool others_stay = false;           // likewise
};

// The row of a recording whose time is nearest.
std::size_t NearestRow(const std::vector<double>& times, double time_s);

// nullopt for an unknown name.
std::optional<StsEventKind> FindEventKind(std::string_view name);

// Throws Error naming file and line: an unknown event, a repetition or frame that is no whole number, the same event
// twice.
std::vector<EventCorrection> ReadEventCorrections(const std::filesystem::path& path);

// Single events, so of walking the others stay. Throws Error if the file cannot be written.
void WriteEventCorrections(const std::filesystem::path& path, const std::vector<EventCorrection>& corrections);

// Throws Error naming file and line for a row that is outside a recording with these frames and times, or whose frame
// is not the one nearest to its time.
void CheckAreInside(const std::vector<EventCorrection>& corrections, const std::vector<std::int64_t>& frame,
                    const std::vector<double>& time_s);

// The found events with those of the corrections in their places, in the order of events.csv. Throws Error naming file
// and line as CheckAreInside, and where events are not in their order (onset, seat_off, standing, descent, seated, then
// the next repetition's), a rise takes no time, or a repetition has no onset; of walking, where heel strikes are not in
// the order of their numbers.
std::vector<StsEvent> ApplyEventCorrections(const std::vector<EventCorrection>& corrections,
                                            const std::vector<std::int64_t>& frame, const std::vector<double>& time_s,
                                            const std::vector<StsEvent>& found);

}  // namespace lake::motion
