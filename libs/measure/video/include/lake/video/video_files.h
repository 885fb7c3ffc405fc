// Properties of a recording that need no decoding.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "lake/video/video_reader.h"

namespace lake::video {

// The files that a path given for a recording stands for: itself, or the folder of an image sequence's pictures
// (frames/%05d.png), which is the working folder where the pattern names none.
std::filesystem::path FilesOfVideo(const std::filesystem::path& path);

// Whether the file has time stamps. An image sequence and a stream without a container have none and need a capture
// rate. Throws Error as VideoReader::Open does.
bool HasTimes(const std::filesystem::path& path);

// The time stamps of the frames that a reader with these options would return, s, increasing, from the container's
// packets or an image sequence's count and rate. nullopt where the container's stamps are incomplete or differ from the
// decoder's; then the video must be decoded. Throws Error as VideoReader::Open does, but not where a rate is missing.
std::optional<std::vector<double>> StampsInContainer(const std::filesystem::path& path,
                                                     const VideoReaderOptions& options = {});

}  // namespace lake::video
