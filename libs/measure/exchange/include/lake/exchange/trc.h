// TRC, the marker format of OpenSim and Motion Analysis: tab-separated text, positions in three dimensions.
#pragma once

#include <filesystem>
#include <string>

#include "lake/exchange/point_recording.h"

namespace lake::exchange {

// Understands the dialects in use: one to three tabs after a name, with or without a blank line after the labels,
// trailing tabs, missing cells as blanks or NaN, units mm, cm or m. Frames of the file count from 1. Y is up, as is the
// custom. Throws Error naming file and line: another header, a count that does not agree with the header (a truncated
// file), a cell that is no number. A rate in the header that the time column contradicts is a warning; the time column
// is believed.
PointRecording ReadTrc(const std::filesystem::path& path);

// In mm, cm or m; z = 0 for points of a plane, points in space are turned so that y is up. Throws Error for points in
// px.
void WriteTrc(const std::filesystem::path& path, const PointRecording& points, const std::string& unit = "mm");

}  // namespace lake::exchange
