// From a recording to a trial: the ordinary lake-track, and how far the live positions are from its own.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
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

// What lake-track is told beside the video and the folder. `more`: seeds and the part of the recording.
std::vector<std::string> TrackArguments(const LiveRunOptions& options, const std::vector<std::string>& more);

// Runs lake-track in the folder. Throws Error with its last line where it fails; what `check` throws passes on.
void TrackTrial(const std::filesystem::path& programs, const std::filesystem::path& folder,
                const std::vector<std::string>& arguments, const std::function<void(const std::string& line)>& say,
                const std::function<void()>& check);

// Live positions less lake-track's, where both were measured: root mean square and largest distance, px, in all and by
// marker. Null figures where no frame has both.
Json DifferenceJson(const motion::MarkerRecording& told, const std::filesystem::path& folder);

}  // namespace lake::live
