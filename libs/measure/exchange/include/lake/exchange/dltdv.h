// DLTdv (Hedrick 2008, doi 10.1088/1748-3182/3/3/034001): its table of digitized points, *xypts.csv.
#pragma once

#include <filesystem>

#include "lake/exchange/point_recording.h"

namespace lake::exchange {

// Columns pt1_cam1_X, pt1_cam1_Y, …, one row per frame, NaN where missing; px from 1 at the top-left pixel, as DLTdv 8
// has them (older versions count y from below: a warning says so). The points of one camera are named pt1, pt2, …,
// those of several pt1_cam1, …. The file has no times. Throws Error naming file and line.
PointRecording ReadDltdv(const std::filesystem::path& path, double rate_hz);

// Whether the header looks like DLTdv's.
bool IsDltdv(const std::filesystem::path& path);

}  // namespace lake::exchange
