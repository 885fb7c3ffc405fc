// Kinovea (kinovea.org): its CSV export of trajectories and its annotation files.
#pragma once

#include <filesystem>

#include "lake/exchange/point_recording.h"

namespace lake::exchange {

// Quoted cells, columns Time, NAME/0/X, NAME/0/Y, separators after the writer's locale: "1.0","2.0" and "1,0";"2,0"
// alike. The file does not say its length unit: kPlane, in `mm_per_unit`. Times are in ms or s: a frame's duration lies
// between 1 ms and 1 s, which tells them apart. Throws Error naming file and line.
PointRecording ReadKinovea(const std::filesystem::path& path, double mm_per_unit = 1);

// With comma and point, times in ms.
void WriteKinovea(const std::filesystem::path& path, const PointRecording& points);

// A .kva annotation file: its tracks, in px of the image (Kinovea's 0.5 subtracted), times from the points' own stamps,
// the scale of a calibration line; a perspective calibration is a warning. Throws Error naming the file and what is
// wrong.
PointRecording ReadKva(const std::filesystem::path& path);

// Tracks over the video, with the scale if there is one. Throws Error unless the points are in px.
void WriteKva(const std::filesystem::path& path, const PointRecording& points);

}  // namespace lake::exchange
