// Where time is missing from a recording or stands still, and where a recording is cut, by the markers' motion.
#pragma once

#include <vector>

#include "lake/motion/marker_recording.h"
#include "lake/tracking/frame_times.h"
#include "repeated_frames.h"

namespace lake::tracking {

// Finds the jumps and corrects the times of all later frames; frames that stand still about a jump and explain it are
// marked as repeated instead. `at_lower_rate`: times are RepeatedFrames::TakeLowerRate()'s, from which frames may be
// off by a part of their interval. Throws Error where the recording is cut, or jumps too often for its times to be
// trusted.
std::vector<TimeJump> TakeTimeJumps(bool at_lower_rate, RepeatedFrames& frames, motion::MarkerRecording& recording);

}  // namespace lake::tracking
