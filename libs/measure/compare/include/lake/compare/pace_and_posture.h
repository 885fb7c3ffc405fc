// What an exoskeleton does to its person's pace and posture: what the difference between two trials' paths at equal
// percent holds beside the joint's place.
#pragma once

#include <optional>

#include "lake/compare/interval.h"
#include "lake/compare/registration.h"

namespace lake::compare {

// Means over a trial's repetitions, and what the exoskeleton trial has more. The intervals of the means (95 %, Student
// 1908) need two repetitions, that of the difference (Welch 1947) two of each.
struct Difference {
  double human = 0, exo = 0;
  std::optional<Interval> interval{}, human_interval{}, exo_interval{};

  double Value() const { return exo - human; }
};

// Durations, s; the phases are absent where a trial has no seat-off, as walking.
struct Pace {
  Difference repetition;  // onset to standing; of walking a stride
  std::optional<Difference> onset_to_seat_off, seat_off_to_standing;
};

// An angle over the repetition, at equal percent.
struct AngleDifference {
  Difference mean_deg;
  double rms_deg = 0, max_deg = 0;  // of the difference between the trials' means
};

// Forward lean, degrees; absent where a trial does not show it, as the trunk's without a waist.
struct Posture {
  std::optional<AngleDifference> shank, trunk;
};

// Both trials have at least one repetition.
Pace ComparePace(const RegisteredTrial& human, const RegisteredTrial& exo);
Posture ComparePosture(const RegisteredTrial& human, const RegisteredTrial& exo);

}  // namespace lake::compare
