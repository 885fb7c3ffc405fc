// A folder with one file per marker, as Tracker and Kinovea export single tracks. Not part of the interface.
#pragma once

#include <filesystem>
#include <vector>

#include "lake/exchange/formats.h"

namespace lake::exchange {

// The .txt and .csv files of a folder that lake did not write, by name; empty for other paths.
std::vector<std::filesystem::path> MarkerFilesOf(const std::filesystem::path& path);

// Each file's only marker under the file's name without its ending. A frame that a file lacks is missing there; times
// less than a tenth of a frame apart are one frame's. Throws Error for a file with no marker or several, for points of
// different kinds, and for times that lie between those of the other files.
PointRecording ReadMarkerFiles(const std::vector<std::filesystem::path>& files, const ReadOptions& options);

// Recordings of one marker each, as one: frames are joined by their times. Throws Error, naming the `whole`, for times
// that lie between those of another.
PointRecording JoinMarkers(const std::vector<PointRecording>& files, const std::filesystem::path& whole);

}  // namespace lake::exchange
