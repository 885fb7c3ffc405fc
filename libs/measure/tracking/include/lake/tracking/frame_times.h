// What the markers' motion says of the frames' times: which frames show the picture before them once more, how much
// time lies between two frames, where a recording is cut.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lake/motion/marker_recording.h"

namespace lake::tracking {

// Time between two neighbouring frames that their stamps do not tell of.
struct TimeJump {
  std::int64_t before = 0, after = 0;  // frames that show something new; those between them are repeated
  double stamped_s = 0;                // between the two, by their stamps
  double moved_s = 0, sigma_s = 0;     // by the motion, one standard deviation
  bool is_applied = false;             // beyond doubt (1 in 1000): all later times are set by it; else they stand
};

// Between two frames the markers come farther than a leg's motion explains, but not as far as behind a cut: a real
// jerk, a camera that was pushed, or a marker that something else was taken for.
struct PositionJump {
  std::int64_t before = 0, after = 0;  // frames
  double jump_mm = 0;                  // of two markers at least
};

struct FrameTimes {
  std::vector<std::int64_t> repeated;  // frames, increasing
  // Frames per second that were captured, if the recording shows them at a higher rate by repeating some and the motion
  // is smooth only at the times they were captured; 0 otherwise.
  double captured_hz = 0;
  // Frames per second of the film that these were chosen from, if the motion is smooth only at the times that they had
  // there, early or late by up to half a frame of it; 0 otherwise.
  double chosen_from_hz = 0;
  std::vector<TimeJump> jumps;
  std::vector<PositionJump> position_jumps;
  // How far the times of a converted rate's frames are from those at which they were taken, root mean square; 0
  // otherwise. They stand.
  double uneven_s = 0;
};

// Finds repeated frames, takes their samples out of the recording and sets the times of others where the motion leaves
// no doubt about them. `same_picture`: frames whose picture showed that they repeat the one before once more.
//
// Every decision compares named hypotheses by the likelihood of the markers' paths under white jerk (lake::dynamics),
// with these prior odds: a recording is cut 1e-3, its clock jumps 1e-2 (over all its frames), its rate was converted
// 0.1. A frame whose picture is the one before is repeated if the markers would otherwise have had to stop and start
// again; of who rests, it is a measurement. Throws Error where a recording is cut: where two markers at least jump by
// more than 100 mm and nothing else explains it.
FrameTimes CorrectFrameTimes(const std::vector<std::int64_t>& same_picture, motion::MarkerRecording& recording);

// One line for each finding, with frame numbers; `frame`: the recording's.
std::vector<std::string> Warnings(const FrameTimes& times, const std::vector<std::int64_t>& frame);

}  // namespace lake::tracking
