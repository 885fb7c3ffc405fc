#include "lake/gait/corrected_events.h"

#include <algorithm>

#include "lake/gait/sts_events.h"

namespace lake::gait {

void DescribeEvents(std::optional<std::filesystem::path>& file, OptionList& options) {
  options.Add(
      "events", file,
      "repetition,event,time_s (or frame) rows that overrule the events found (of walking: all of them); empty: no "
      "such event");
}

void CorrectEvents(const std::vector<motion::EventCorrection>& corrections, LegFitResult& fit) {
  fit.events = motion::ApplyEventCorrections(corrections, fit.motion.frame, fit.motion.time_s, fit.events);
  using enum motion::StsEventKind;
  const auto find = [&](motion::StsEventKind kind, int repetition) {
    return std::ranges::any_of(fit.events, [&](const motion::StsEvent& event) {
      return event.kind == kind && event.repetition == repetition;
    });
  };
  Walk& walk = fit.movement.walk;
  walk.strides = walk.incomplete = 0;
  for (const motion::StsEvent& event : fit.events) {
    if (event.kind < kHeelStrike) continue;
    fit.movement.kind = MovementKind::kWalking;
    if (event.kind != kHeelStrike) continue;
    walk.strides += find(kToeOff, event.repetition) && find(kHeelStrike, event.repetition + 1) ? 1 : 0;
    walk.incomplete +=
        (find(kHeelStrike, event.repetition - 1) ? 0 : 1) + (find(kHeelStrike, event.repetition + 1) ? 0 : 1);
  }
  SetRepetitions(fit.events, fit.motion);
}

}  // namespace lake::gait
