// What the markers' motion says of the frames' times: which frames show the picture before them once more, where time
// is missing from a recording, where it stands still.
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
};

struct FrameTimes {
  std::vector<std::int64_t> repeated;  // frames, increasing
  // Frames per second that were captured, if the recording shows them at a higher rate by repeating some and the motion
  // is smooth only at the times they were captured; 0 otherwise.
  double captured_hz = 0;
  std::vector<TimeJump> jumps;
};

// Finds repeated frames (`known`: those whose picture told already), takes their samples out of the recording and
// corrects the times of the others where the motion tells what they are.
//
// A frame is repeated when all markers stand still in it at once that move on before and after it, in the same
// direction. Repeated frames that recur as those of a lower rate do (Beatty's sequence) may stand for frames that were
// lost, with the others' stamps right, or for frames that were captured more seldom, equally far apart: the times at
// which the markers' paths are smoother are taken. Missing time is a jump of all markers along their paths; how long it
// was follows from positions, velocities and accelerations on both sides (two-point Taylor expansion: Δx = T (v₀ + v₁)
// / 2 + T² (a₀ − a₁) / 12, exact up to the fifth power of time). Throws Error where two markers or more jump farther
// than a person can move and no time explains it (a cut), where the motion jumps so often that no times can be trusted,
// or where all markers together are early and late by more than 8 % of the time between frames.
FrameTimes CorrectFrameTimes(const std::vector<std::int64_t>& known, motion::MarkerRecording& recording);

// One line for each thing found, with frame numbers; `frame`: the recording's.
std::vector<std::string> Warnings(const FrameTimes& times, const std::vector<std::int64_t>& frame);

}  // namespace lake::tracking
