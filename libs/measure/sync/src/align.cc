#include "lake/sync/align.h"

#include <fmt/format.h>

#include <cmath>

#include "lake/core/error.h"
#include "lake/sync/lag.h"
#include "pairing.h"

namespace lake::sync {
namespace {

// Why there is no offset; `sign`: of an offset to add to B's times in the lag's.
std::string ReasonOf(const Lag& lag, double sign, double drift_sd_ppm, const std::string& compared) {
  switch (lag.refusal) {
    case LagRefusal::kUnexplained:
      return fmt::format(
          "at the best offset {:.0f} % of the movement of one ({}) is not predicted by that of the other; are these "
          "recordings of one movement?",
          100 * lag.unexplained, compared);
    case LagRefusal::kTooShort:
      return "at no offset do both show a common movement for long enough; it takes some 4 s of movement in both";
    case LagRefusal::kAnother:
      return fmt::format(
          "offsets of {:.2f} and {:.2f} s are about as likely; are these recordings of one movement? If so, record one "
          "that does not repeat itself, or give a signal that both have (--signal-a, --signal-b)",
          sign * lag.offset_s, sign * lag.second_s);
    case LagRefusal::kDrift:
      return fmt::format(
          "their clocks would run {:+.0f} ppm apart, where {:.0f} ppm is one standard deviation; are these recordings "
          "of one movement? If a rate is that wrong, say so: --drift-sd",
          1e6 * sign * lag.free_drift, drift_sd_ppm);
    case LagRefusal::kUncertain:
      return fmt::format(
          "the offset of {:.2f} s would be uncertain by {:.0f} ms (1 SD); are these recordings of one movement? If so, "
          "record more of it, or give a signal that both have (--signal-a, --signal-b)",
          sign * lag.offset_s, 1000 * lag.LargestSdS());
    default: {
      std::string departures;
      for (const BlockLag& block : lag.blocks)
        departures += fmt::format("{}{:+.3f}", departures.empty() ? "" : ", ", sign * block.departure_s);
      return fmt::format(
          "parts of the overlap contradict one another, by {} s from the best offset; are these recordings of one "
          "movement?",
          departures);
    }
  }
}

// Of A's times from B's, at B's first.
Clock ClockOf(const Lag& lag, bool y_is_a, double from_s) {
  const double a_s = y_is_a ? lag.from_s + (from_s - lag.offset_s - lag.from_s) / (1 + lag.drift) : lag.At(from_s);
  return {.offset_s = a_s - from_s,
          .drift_ppm = 1e6 * (y_is_a ? 1 / (1 + lag.drift) - 1 : lag.drift),
          .from_s = from_s,
          .method = "motion"};
}

}  // namespace

Alignment AlignByMotion(const Movement& a, const Movement& b, const AlignOptions& options) {
  const Pairing pairing = PairingOf(a, b);
  const Lag lag = FindLag(pairing.y, pairing.x, {.drift_sd = 1e-6 * options.drift_sd_ppm});
  const double sign = pairing.y_is_a ? -1 : 1;
  if (lag.refusal != LagRefusal::kNone)
    throw Fail("{} and {}: cannot be aligned: {}", a.file.string(), b.file.string(),
               ReasonOf(lag, sign, options.drift_sd_ppm, pairing.name));
  Alignment alignment{.clock = ClockOf(lag, pairing.y_is_a, b.time_s.front()),
                      .drift_sd_ppm = 1e6 * std::sqrt(lag.covariance(1, 1)),
                      .unexplained = lag.unexplained,
                      .overlap_s = lag.overlap_s,
                      .offset_s = lag.search_s,
                      .log_likelihood = lag.log_likelihood,
                      .comparison = {pairing.name, lag.time_s, lag.measured, lag.predicted}};
  alignment.clock.sd_s = std::hypot(pairing.model_sd_s, lag.LargestSdS());
  const auto on_a = [&](double y_time_s) { return pairing.y_is_a ? y_time_s : lag.At(y_time_s); };
  for (const BlockLag& block : lag.blocks)
    alignment.parts.push_back({on_a(block.time_s), sign * block.departure_s, block.sd_s});
  for (double& time_s : alignment.comparison.time_s) time_s = on_a(time_s);
  for (double& offset_s : alignment.offset_s) offset_s *= sign;
  return alignment;
}

}  // namespace lake::sync
