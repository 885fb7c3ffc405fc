// A recorded motion from a file of markers, as seen by a camera beside the person.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/exchange/trial.h"
#include "lake/synth/marker_motion.h"

namespace lake::synth {

struct MotionFile {
  std::filesystem::path file;              // of any kind that ReadTrial reads, in mm
  exchange::TrialOptions reading;          // its names are the leg's
  std::vector<std::string> extra_markers;  // further ones of the file, shown under its own names
  double begin_s = 0;                      // after the file's first frame
  motion::Facing facing = motion::Facing::kRight;
};

// From begin_s on for `duration_s` (0: to the end). The camera stands on the side from which the subject looks to
// `facing`: nothing is mirrored, so a right leg that faces left is the far one. The plane is the sagittal plane through
// the leg's middle: the mean lateral coordinate of ankle, knee and hip. Throws Error as ReadTrial does, and for a
// marker that is missing in that time; UsageError for options that the file has no use for.
MotionTable ReadMotionFile(const MotionFile& motion, double duration_s);

}  // namespace lake::synth
