// Which part of a session's recording becomes its trial.
#pragma once

#include <optional>
#include <span>

namespace lake::live {

// Seconds of the recording; nullopt: its own begin or end.
struct TrialPart {
  std::optional<double> begin_s, end_s;
};

// Of what a person asked for, the part with one place of the joint: from the last move after which there was a rise to
// the move after it. Where there was no rise all that was asked for. `moves_s`: when the joint was moved, increasing;
// `onsets_s`: of the rises.
TrialPart PartOfTrial(const TrialPart& asked, std::span<const double> moves_s, std::span<const double> onsets_s);

}  // namespace lake::live
