// corrections.csv: frame,marker,x_px,y_px; rows replace what the detector said.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "lake/motion/marker_recording.h"

namespace lake::commands {

struct Correction {
  std::int64_t frame = 0;
  std::string marker;
  motion::MarkerSample sample;  // clicked: detected, with a standard deviation of 0.5 px; empty cells: not visible
  std::string where;            // "corrections.csv:3"
};

// Throws Error naming file and line: a marker that is not among `names`, a frame that is none, half a position, one
// outside the picture.
std::vector<Correction> ReadCorrections(const std::filesystem::path& path, const std::vector<std::string>& names,
                                        int width, int height);

// Throws Error naming file and line for a frame that the recording does not have.
void ApplyCorrections(const std::vector<Correction>& corrections, motion::MarkerRecording& recording);

}  // namespace lake::commands
