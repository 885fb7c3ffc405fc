// An actuator along a load profile: force, speed and power at each percent of the rise, and the shortest duration.
//
//   F = assist M / r        r = |dd / dtheta|, the moment arm
//   v = r |dtheta / ds| / T  s = 0..1, run through evenly in the duration T
//   F within what the actuator lifts, v within its speed under F  =>  T >= r |dtheta / ds| / v(F)
//
// M is the moment of a rise in T, as far as the profile says what pace adds to it (AtPace in load_profile.h), else as
// it was measured.
#pragma once

#include <limits>
#include <optional>
#include <vector>

#include "lake/linkage/linkage.h"
#include "lake/problem/problem.h"

namespace lake::problem {

// Indices of the profile's samples that are not straighter than standing_deg.
std::vector<int> SamplesInUse(const SynthesisProblem& problem);

// The stroke for a knee angle of the profile; nullopt beyond the used range.
std::optional<double> ProfileStroke(const linkage::Links& links, const linkage::UsedRange& range, double knee_rad);

// One sample; NaN where not known or, of the linkage, beyond the used range.
struct AssistanceRow {
  static constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
  double percent = 0, time_s = 0, knee_deg = 0;
  double knee_nm = kUnknown;  // of the profile
  double stroke_mm = kUnknown;
  double moment_arm_mm = kUnknown;  // per rad
  double force_n = kUnknown;        // of the actuator, positive when it pushes
  double speed_mm_s = kUnknown;     // positive when it grows
  double power_w = kUnknown;        // force x speed, positive where it drives
  // Of the whole rise, by the actuator's speed under this force; an unknown moment counts as none. Infinite where the
  // actuator does not lift it.
  double least_duration_s = kUnknown;
};

struct Assistance {
  std::vector<AssistanceRow> rows;
  double duration_s = 0;  // of force, speed and power in the rows
  double moments_s = 0;   // of the rise whose moments these are: the same, where the profile says what pace adds
  // The shortest that the actuator allows under the moments of a rise in that time, and the percent that decides; NaN
  // without a known speed, infinite where it cannot lift its share at any pace.
  double shortest_s = AssistanceRow::kUnknown, limiting_percent = AssistanceRow::kUnknown;
  bool force_is_limit = false;             // a quicker rise takes more than it lifts; else its speed decides
  bool speed_under_load_is_known = false;  // else `shortest_s` is a lower bound
  // Lower bound over all linkages, by the actuator's power. NaN as above.
  double bound_s = AssistanceRow::kUnknown, bound_percent = AssistanceRow::kUnknown;

  // The row with the largest magnitude of a column; nullptr if none is known.
  const AssistanceRow* Largest(double AssistanceRow::*column) const;
};

// The shortest duration under the moments that the profile is given with, whatever pace they are of; NaN without a
// known speed, infinite where the actuator cannot lift its share.
double DurationUnderMoments(const linkage::Links& links, const SynthesisProblem& problem);

// Of a design, for problem.duration_s if there is one, else the shortest duration, else the profile's own: this is the
// pace of a design wherever its forces are computed. Needs a load profile; throws Error if the linkage cannot be
// assembled at d_min.
Assistance FindAssistance(const linkage::Links& links, const SynthesisProblem& problem);

}  // namespace lake::problem
