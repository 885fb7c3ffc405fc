// What can be said of a recording before its frames are decoded.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "lake/video/video_reader.h"

namespace lake::video {

// The files that a path given for a recording stands for: itself, or the folder of an image sequence's pictures
// (frames/%05d.png), which is the working folder where the pattern names none.
std::filesystem::path FilesOfVideo(const std::filesystem::path& path);

// The time stamps of the frames that a reader with these options would hand out, s, increasing, from the container's
// packets. nullopt where the container leaves some out or counts them otherwise: then only decoding tells. Throws Error
// as VideoReader::Open does.
std::optional<std::vector<double>> StampsInContainer(const std::filesystem::path& path,
                                                     const VideoReaderOptions& options = {});

}  // namespace lake::video
