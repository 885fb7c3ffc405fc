// From a recording to a trial: the ordinary lake-track, and how far the live positions are from its own.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lake/core/json.h"
#include "lake/live/run_live.h"
#include "lake/motion/marker_recording.h"

namespace lake::live {

inline constexpr const char* kVideo = "video.mkv";
inline constexpr const char* kTracks = "live_tracks.csv";
inline constexpr const char* kRises = "rises.csv";
inline constexpr const char* kMoves = "moves.csv";
inline constexpr const char* kLive = "live.json";
inline constexpr const char* kSummary = "summary.json";  // lake-track's, written last: with it the folder is a trial

// The arguments of lake-track beside the video and the folder. `more`: seeds and the part of the recording.
std::vector<std::string> TrackArguments(const LiveRunOptions& options, const std::vector<std::string>& more);

// Runs lake-track in the folder. Throws Error with its last line where it fails; what `check` throws passes on.
void TrackTrial(const std::filesystem::path& programs, const std::filesystem::path& folder,
                const std::vector<std::string>& arguments, const std::function<void(const std::string& line)>& say,
                const std::function<void()>& check);

// Live positions less lake-track's, px, where both were measured.
struct Distances {
  double squares = 0, largest_px = 0;  // a sum
  std::int64_t count = 0;

  std::optional<double> RmsPx() const;
  std::optional<double> LargestPx() const;
};

struct LiveDifference {
  Distances all;
  std::vector<std::pair<std::string, Distances>> markers;
};

LiveDifference FindDifference(const motion::MarkerRecording& recorded, const std::filesystem::path& folder);

// rms_px and largest_px, null where no frame has both, in all and by marker.
Json DifferenceJson(const LiveDifference& difference);

}  // namespace lake::live
