// Both legs of one person: what differs between them in the rises that both made, with intervals that hold together.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "lake/compare/interval.h"
#include "lake/gait/leg_fit.h"
#include "lake/gait/sit_to_stand.h"

namespace lake::compare {

// What else is known of each side's rises, by their numbers, of one recording by the left leg's (MatchRises), as the
// force under its foot. Where the SD of a rise is not known (NaN), it takes two rises to tell a difference.
struct RiseQuantity {
  std::string name;  // a column's, its unit at the end
  std::map<int, gait::Measured> left, right;
  double relative_sd = 0;  // of the instrument of either side, which no number of rises makes smaller
};

struct SymmetryOptions {
  double replacement_sd_mm = 3;  // how well a marker is put on the same spot of either leg: in angles
  bool one_recording = false;    // rises are matched (MatchRises); else those of two recordings are not
  std::vector<RiseQuantity> further = {};
};

// A quantity of sit_to_stand.csv, or the knee angle at a percent of the rise.
struct SideDifference {
  std::string name = {};  // its column
  double left = 0, right = 0;
  double difference = 0;     // left less right
  Interval interval = {};    // of the difference
  double index_percent = 0;  // 100 (left − right) / ((left + right) / 2); Robinson et al. 1987
  Interval index_interval = {};
  bool IsAsymmetric() const { return interval.low > 0 || interval.high < 0; }
};

struct Symmetry {
  std::vector<SideDifference> quantities = {};  // all their intervals hold together with 95 % (Bonferroni)
  std::vector<SideDifference> knee_deg = {};    // at 0 to 100 %, each by itself with 95 %
  std::size_t left_rises = 0, right_rises = 0;
  bool is_asymmetric = false;  // some quantity's interval excludes zero
  std::vector<std::string> warnings = {};
};

// Of one recording, whose legs need not have been found to rise the same number of times: the right leg with the
// numbers of the left leg's rises that its own overlap in time. A rise that overlaps none is left out, and a warning
// names it.
struct MatchedRises {
  gait::LegFitResult right;
  std::vector<std::string> warnings = {};
};
MatchedRises MatchRises(const gait::LegFitResult& left, gait::LegFitResult right);

// Angles at seat-off and at most, peak speeds, phases, the hip's rise and what is given besides, aligned by the rises'
// events. Between rises the interval is Student's (paired, or Welch's); of one rise each it is the fits'. To angles it
// adds where the markers sit. Throws Error where a side has no rise with an onset and a standing, and for rises that
// are matched and none is.
Symmetry CompareSides(const gait::LegFitResult& left, const gait::LegFitResult& right, const SymmetryOptions& options);

}  // namespace lake::compare
