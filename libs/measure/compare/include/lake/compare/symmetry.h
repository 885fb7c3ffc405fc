// Both legs of one person: what differs between them in the rises, squats or strides that both made, with intervals
// that hold together.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "lake/compare/interval.h"
#include "lake/gait/field.h"
#include "lake/gait/leg_fit.h"

namespace lake::compare {

// A leg's values by the numbers of its repetitions.
using ByRepetition = std::map<int, gait::Measured>;

// What else is known of each side's repetitions, of one recording by the left leg's numbers (MatchRepetitions), as the
// force under its foot.
struct FurtherQuantity {
  std::string name;  // a column's, its unit at the end
  ByRepetition left, right;
  double relative_sd = 0;  // of the instrument of either side, which no number of repetitions makes smaller
};

struct SymmetryOptions {
  double replacement_sd_mm = 3;  // how well a marker is put on the same spot of either leg: in angles
  bool one_recording = false;    // repetitions are matched (MatchRepetitions); else those of two recordings are not
  std::vector<FurtherQuantity> further = {};
};

// A measure of each leg's own, or the knee angle at a percent of the repetition.
struct SideDifference {
  std::string name = {};  // its column in sit_to_stand.csv, squats.csv or gait_cycles.csv
  double left = 0, right = 0;
  double difference = 0;   // left less right
  Interval interval = {};  // of the difference
  // 100 (left − right) / ((left + right) / 2); Robinson et al. 1987. NaN where that mean is within the interval's reach
  // of zero.
  double index_percent = 0;
  Interval index_interval = {};
  bool IsAsymmetric() const { return interval.low > 0 || interval.high < 0; }
};

struct Symmetry {
  gait::MovementKind movement = gait::MovementKind::kSitToStand;
  std::vector<SideDifference> quantities = {};  // all their intervals hold together with 95 % (Bonferroni)
  std::vector<SideDifference> knee_deg = {};    // at 0 to 100 %, each by itself with 95 %
  std::size_t left_count = 0, right_count = 0;  // repetitions
  bool is_asymmetric = false;                   // some quantity's interval excludes zero
  std::vector<std::string> warnings = {};
};

// Of one recording, in which the legs need not have been found to move the same number of times: for each repetition of
// the right leg the left leg's number of the one that it overlaps longest, for a stride of the one in which it begins.
// One that has none is left out, and a warning names it.
struct MatchedRepetitions {
  std::map<int, int> left_by_right;
  std::vector<std::string> warnings;
};
MatchedRepetitions MatchRepetitions(const gait::LegFitResult& left, const gait::LegFitResult& right);

// Of rises phases, angles, peak speeds and the hip's rise; of squats the knee's; of strides phases, angles, ranges and
// toe clearance, in one recording the step times, too; and what is given besides. The interval is Student's between
// repetitions (paired, or Welch's), NaN of a single one. To angles it adds where the markers sit, to times of steps and
// stances half of the events' standard deviation. Throws Error where the legs move otherwise, a side has no whole
// repetition, and where none is matched.
Symmetry CompareSides(const gait::LegFitResult& left, const gait::LegFitResult& right, const SymmetryOptions& options);

}  // namespace lake::compare
