#include "lake/gait/corrected_events.h"

#include <algorithm>

#include "lake/gait/sts_events.h"
#include "strides.h"

namespace lake::gait {

void DescribeEvents(std::optional<std::filesystem::path>& file, OptionList& options) {
  options.Add(
      "events", file,
      "repetition,event,time_s (or frame) rows that overrule the events found (of walking: all of them); empty: no "
      "such event");
}

void CorrectEvents(const std::vector<motion::EventCorrection>& corrections, LegFitResult& fit) {
  fit.events = motion::ApplyEventCorrections(corrections, fit.motion.frame, fit.motion.time_s, fit.events);
  CountStrides(fit.events, fit.movement.walk);
  if (std::ranges::any_of(fit.events,
                          [](const auto& event) { return event.kind >= motion::StsEventKind::kHeelStrike; }))
    fit.movement.kind = MovementKind::kWalking;
  SetRepetitions(fit.events, fit.motion);
}

}  // namespace lake::gait
