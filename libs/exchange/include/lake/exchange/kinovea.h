// Kinovea's CSV export of trajectories: quoted cells, columns Time, NAME/0/X, NAME/0/Y; separators after the writer's
// locale.
#pragma once

#include <filesystem>

#include "lake/exchange/point_recording.h"

namespace lake {

// "1.0","2.0" and "1,0";"2,0" alike. The file does not say its length unit: kPlane, in `mm_per_unit`. Times are in ms
// or s: a frame's duration lies between 1 ms and 1 s, which tells them apart. Throws Error naming file and line.
PointRecording ReadKinovea(const std::filesystem::path& path, double mm_per_unit = 1);

// With comma and point, times in ms.
void WriteKinovea(const std::filesystem::path& path, const PointRecording& points);

// Whether the header looks like Kinovea's.
bool IsKinovea(const std::filesystem::path& path);

}  // namespace lake
