#include "lake/gait/corrected_events.h"

#include "lake/gait/sts_events.h"

namespace lake::gait {

void DescribeEvents(std::optional<std::filesystem::path>& file, OptionList& options) {
  options.Add("events", file,
              "repetition,event,time_s (or frame) rows that overrule the events found; empty: no such event");
}

void CorrectEvents(const std::vector<motion::EventCorrection>& corrections, LegFitResult& fit) {
  fit.events = motion::ApplyEventCorrections(corrections, fit.motion.frame, fit.motion.time_s, fit.events);
  SetRepetitions(fit.events, fit.motion);
}

}  // namespace lake::gait
