// TRC, the marker format of OpenSim and Motion Analysis: tab-separated text, positions in three dimensions.
#pragma once

#include <filesystem>

#include "lake/exchange/point_recording.h"

namespace lake {

// Understands the dialects in use: one to three tabs after a name, with or without a blank line after the labels,
// trailing tabs, missing cells as blanks or NaN, units mm, cm or m. Frames of the file count from 1. Y is up, as is the
// custom. Throws Error naming file and line: another header, a count that does not agree with the header (a truncated
// file), a cell that is no number.
PointRecording ReadTrc(const std::filesystem::path& path);

// In mm; z = 0 for points of a plane. Throws Error for points in px.
void WriteTrc(const std::filesystem::path& path, const PointRecording& points);

}  // namespace lake
