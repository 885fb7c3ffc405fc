// The work of lake-track: from a video to tracks, leg motion, figures and an annotated video.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/tracking/track_markers.h"

namespace lake {

struct TrackRunOptions {
  std::filesystem::path video;
  TrackOptions track;
};

// Writes everything that interfaces.md lists for lake-track through `run` and returns the results for the summary.
Json RunTrack(const TrackRunOptions& options, Run& run);

}  // namespace lake
