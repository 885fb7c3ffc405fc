// A rendering as files: video, truth, camera, scene.
#pragma once

#include <filesystem>

#include "lake/core/json.h"
#include "lake/synth/scene.h"

namespace lake::synth {

struct RecordingOptions {
  int crf = 17;           // H.264 quality
  bool lossless = false;  // luma kept to the bit; with a colour scene the colours are still subsampled
  bool pictures = false;  // frames/00000.png … instead of video.mp4
  // x264's, unless lossless: as weak as the encoders in cameras; "medium" takes three times as long
  const char* preset = "veryfast";
  bool quiet = true;  // no progress
};

struct RecordingSummary {
  int frames = 0;
  std::vector<std::string> markers;
  std::vector<int> hidden_frames;  // per marker
};

// Writes video.mp4 (or frames/), truth.csv, camera.yaml and scene.json into the folder, which must exist. truth.csv is
// as in the interfaces, followed per marker by M_covered (the part of its light that was taken away). Throws Error (a
// full disk).
RecordingSummary WriteRecording(const Scene& scene, const std::filesystem::path& folder,
                                const RecordingOptions& options);

// The table alone.
void WriteTruthCsv(const std::filesystem::path& path, const Scene& scene, const std::vector<FrameTruth>& truth);

}  // namespace lake::synth
