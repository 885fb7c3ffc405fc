// corrections.csv: frame,marker,x_px,y_px and perhaps sigma_px; rows replace what the detector said.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "lake/motion/marker_recording.h"

namespace lake::motion {

// Standard deviation per axis of a clicked position, px, for rows without a sigma_px.
inline constexpr double kClickSigmaPx = 0.5;

struct Correction {
  std::int64_t frame = 0;
  std::string marker;
  MarkerSample sample;     // detected, px; missing: not visible
  std::string where = {};  // "corrections.csv:3"
};

// Throws Error naming file and line: a marker that is not among `names`, a frame that is none, half a position, one
// outside the picture, a sigma that is not positive, a marker that is corrected twice in a frame.
std::vector<Correction> ReadCorrections(const std::filesystem::path& path, const std::vector<std::string>& names,
                                        int width, int height);

// With sigma_px, so that reading gives the same samples. Throws Error if the file cannot be written.
void WriteCorrections(const std::filesystem::path& path, const std::vector<Correction>& corrections);

// Throws Error naming file and line for a frame that the recording does not have.
void ApplyCorrections(const std::vector<Correction>& corrections, MarkerRecording& recording);

}  // namespace lake::motion
