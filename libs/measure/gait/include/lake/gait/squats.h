// Squats: their events, and what is measured of each. Terms: Schoenfeld 2010, Squatting kinematics and kinetics,
// doi:10.1519/JSC.0b013e3181bac2d7.
#pragma once

#include <span>
#include <vector>

#include "lake/gait/field.h"
#include "lake/gait/leg_fit.h"

namespace lake::gait {

// Those of FoundStsEvents in which the ankle does not rise as in a jump.
std::vector<motion::StsEvent> FindSquats(const LegFitResult& leg);

// Lengths are in the plane's unit; standard deviations are the fit's and those of the events' times.
struct Squat {
  static std::span<const Field<Squat>> Fields();

  int repetition = 0;
  Measured begin_s, squat_s, descent_s, ascent_s;
  Measured depth, knee_max_deg, trunk_max_deg;
  Measured descent_speed, ascent_speed, knee_extension_deg_s;
};

// Of a fit whose movement is squat.
Measures<Squat> MeasureSquats(const LegFitResult& leg);

}  // namespace lake::gait
