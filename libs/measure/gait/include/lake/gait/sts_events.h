// Sit-to-stands in a recording: their events, and the percent of each.
#pragma once

#include <vector>

#include "lake/motion/leg_motion.h"

namespace lake::gait {

// What the events are read from, one value per frame; NaN where not known. Lengths are in the unit of the recording's
// plane.
struct StsSignals {
  std::vector<std::int64_t> frame;
  std::vector<double> time_s;
  std::vector<double> hip_height;    // along the vertical
  std::vector<double> hip_speed;     // of the hip in the plane, per s
  std::vector<double> hip_up_speed;  // its vertical part, upward positive, per s
  std::vector<double> hip_behind;    // of the ankle, horizontally; empty: not known
  std::vector<double> knee_deg_s;    // flexion positive
  std::vector<double> trunk_deg_s;   // empty or NaN without a waist marker
  double leg_length = 0;             // |AK| + |KH|
  double units_per_mm = 1;           // of the lengths above
};

struct StsOptions {
  double rest_speed_mm_s = 20;          // rest: the hip is slower than this …
  double rest_duration_s = 0.1;         // … for at least this long
  double rest_trunk_deg_s = 10;         // before the first rise the trunk turns slower than this, too, …
  double first_rest_duration_s = 0.25;  // … for this long: from less, what leaves rest cannot be told from rest
  double onset_deviations = 3;          // rest is left by this many SD of the rest, and at least …
  double onset_height_mm = 2;           // … by this of the hip's height, or …
  double onset_trunk_deg_s = 2;         // … by this of the trunk's angular speed
  double seat_off_fraction = 0.10;      // of the hip's peak upward speed
  double standing_fraction = 0.05;      // of the knee's peak extension speed
  double least_rise = 0.15;  // of the leg's length: a hip that rises less has not stood up (in gait it moves by 5 %)
  double least_extension_deg = 30;  // the knee's extension during the rise
  // What tells a seat from a squat, in which the body is balanced over the feet. Before the rise the hip is …
  double least_behind = 0.28;  // … this far behind the ankle, of the leg's length: 0.40 to 0.46 in sit-to-stands with
                               // markers (0.31 with the feet drawn back), 0.20 to 0.23 in squats; or …
  double seat_rest_s = 1;      // … it rests for this long; or …
  double same_seat_height = 0.02;  // … it is as low as before a rise for which one of these holds, to this of the leg
};

struct FoundStsEvents {
  std::vector<motion::StsEvent> events;
  // Whether the seat was left before the recording began: that rise is left out.
  bool begins_during_rise = false;
  // Whether the seat was left afterwards, but the rest before it is not recorded: that rise has no onset.
  bool begins_during_lean = false;
  // Where rises without a seat begin, as from a squat: they are left out.
  std::vector<motion::StsEvent> without_seat;
};

// Events of every repetition in the order of time. A rise of the hip with an extension of the knee, from a seat, is a
// repetition; its `descent` and `seated` are those of the following lowering. A repetition that the recording
// cuts off has only the events that are in it. Empty if there is no sit-to-stand.
FoundStsEvents FindStsEvents(const StsSignals& signals, const StsOptions& options = {});

// Sets `repetition` and `percent` (0 at onset, 100 at standing) of the samples between the two, and clears them
// elsewhere.
void SetRepetitions(const std::vector<motion::StsEvent>& events, motion::LegMotion& motion);

}  // namespace lake::gait
