// Sit-to-stands in a recording: their events, and the percent of each. The events are those of the path that hip, knee
// and trunk take: every limit is a fraction of what the rise itself does, so that neither its pace nor a pause in it
// moves them.
#pragma once

#include <string>
#include <vector>

#include "lake/motion/leg_motion.h"

namespace lake::gait {

// Standard deviations of the signals below, one value per frame; empty where not known.
struct StsDeviations {
  std::vector<double> hip_height, hip_up_speed, knee_deg, knee_deg_s, trunk_deg, trunk_deg_s;
  std::vector<double> shank_deg, shank_deg_s, hip_deg, hip_deg_s;
};

// What the events, and the times and speeds of sit_to_stand.h, are read from, one value per frame; NaN where not known.
// Lengths are in the unit of the recording's plane.
struct StsSignals {
  std::vector<std::int64_t> frame;
  std::vector<double> time_s;
  std::vector<double> hip_height;              // along the vertical
  std::vector<double> hip_up_speed;            // its derivative, per s
  std::vector<double> hip_behind;              // of the ankle, horizontally
  std::vector<double> knee_deg, knee_deg_s;    // flexion positive
  std::vector<double> trunk_deg, trunk_deg_s;  // forward positive; NaN without a waist marker
  double leg_length = 0;                       // |AK| + |KH|
  std::vector<double> shank_deg, shank_deg_s;  // forward positive; no event is read from these, nor from the next
  std::vector<double> hip_deg_s;               // flexion positive; NaN without a waist marker
  StsDeviations sd;
};

struct StsOptions {
  // Speeds at which an event is, as fractions of the peak in this rise (or lowering).
  double onset_fraction = 0.03;     // of the trunk's angular speed
  double seat_off_fraction = 0.10;  // of the hip's upward speed
  double standing_fraction = 0.05;  // of the knee's extension speed
  double onset_height = 0.005;      // the onset is earlier where the hip has left rest by this fraction of its rise
  // Rest: for this long, and for this fraction of the time that the hip takes for the middle 90 % of its rise, hip,
  // knee and trunk keep within these fractions of what they travel in the rise. What stops for less is a pause.
  double rest_s = 2, rest_fraction = 0.5;
  double first_rest_s = 0.25;  // what the beginning of the recording leaves of a rest: from less, it is not known
  double rest_hip = 0.04, rest_knee = 0.04, rest_trunk = 0.10;
  // A movement between two stops belongs to the rise, or to the lowering, if it brings this fraction of it, and is not
  // undone. Whoever has stood up gives way at the knee a little, and whoever has sat down sinks in.
  double least_of_rise = 0.01, least_of_lowering = 0.03;
  double kept = 0.75;           // of a movement that is not undone
  double standing_left = 0.15;  // nobody stands, however long the stop, with this fraction of the extension to come
  double least_rise = 0.15;     // of the leg's length: a hip that rises less has not stood up (in gait it moves by 5 %)
  double least_extension_deg = 30;  // the knee's extension during the rise
  // A seat differs from a squat, in which the body is balanced over the feet: before the rise the hip is …
  double least_behind = 0.28;  // … this far behind the ankle, of the leg's length: 0.40 to 0.46 in sit-to-stands with
                               // markers (0.31 with the feet drawn back), 0.20 to 0.23 in squats; or …
  double seat_rest_s = 1;      // … it rests for this long (and for rest_fraction), to seat_still of its rise; or …
  double seat_still = 0.01;
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
  // Descent, bottom and standing of each such rise whose lowering is recorded too, numbered from 1: where the hip
  // turns, and goes down, or up, at more than `standing_fraction` of its peak speed.
  std::vector<motion::StsEvent> squats;
};

// Events of every repetition in the order of time, each when its limit is crossed, which is between two frames; its
// frame is the nearer of them. Its sd_s is the SD of what crosses the limit, over its slope; at an onset with the sway
// of the rest before it and what is not seen of the lean, at an end with a stop that may be it too. A rise of the hip
// with an extension of the knee, from a seat, is a repetition; its `descent` and `seated` are those of the following
// lowering. A repetition that the recording cuts off has only the events that are in it. Empty if there is no
// sit-to-stand.
FoundStsEvents FindStsEvents(const StsSignals& signals, const StsOptions& options = {});

// To be said once events are corrected: a sentence for each onset or standing whose SD is known and more than a tenth
// of the time between the two: the percent of such a rise, and all that is read over it, hang on it.
std::vector<std::string> UncertainEvents(const std::vector<motion::StsEvent>& events);

// Likewise to be said then: a sentence naming the rises before whose onset no marker shows the trunk lean: it is
// the hip's, or is where a marker first shows the lean. Empty without such a rise; an onset that a person gave is
// none.
std::string OnsetsWithoutLean(const StsSignals& signals, const std::vector<motion::StsEvent>& events);

// Sets `repetition` and `percent` of the samples between the events that are 0 and 100 % of their movement
// (movement.h), and clears them elsewhere.
void SetRepetitions(const std::vector<motion::StsEvent>& events, motion::LegMotion& motion);

}  // namespace lake::gait
