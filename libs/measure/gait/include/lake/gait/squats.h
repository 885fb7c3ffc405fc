// Squats: their events, and what is measured of each. Terms: Schoenfeld 2010, Squatting kinematics and kinetics,
// doi:10.1519/JSC.0b013e3181bac2d7.
#pragma once

#include <span>
#include <vector>

#include "lake/gait/field.h"
#include "lake/gait/leg_fit.h"

namespace lake::gait {

// Descent, bottom and standing of each rise without a seat (FoundStsEvents): the hip is lowest at the bottom, and comes
// down, or goes up, at more than 5 % of its peak speed between the others. Their SDs are the time in which the hip's
// speed changes by its own, and half a frame. A squat that the recording cuts off is left out, and so is one in which
// the ankle rises as in a jump.
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
