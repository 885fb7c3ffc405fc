// Tracker (physlets.org/tracker): its text tables and its project files.
#pragma once

#include <filesystem>

#include "lake/exchange/point_recording.h"

namespace lake::exchange {

// A text table: `#multi:` if there are several tracks, a row of names, a row `t x y x y …`, then numbers;
// tab-separated, decimal point or comma, empty cells missing. Which unit it is in the file does not say: kPlane, in
// `mm_per_unit`. Throws Error naming file and line.
PointRecording ReadTrackerText(const std::filesystem::path& path, double mm_per_unit = 1);

// Points in the image are written in px from the picture's top-left corner, y up.
void WriteTrackerText(const std::filesystem::path& path, const PointRecording& points);

// A .trk project, or the first one of a .trz archive: the point masses, in px of the image (Tracker's 0.5 subtracted);
// times as Tracker shows them (start time, start frame, frame duration); the axes, and the scale if the project's
// length unit is known. Throws Error naming the file and what is wrong.
PointRecording ReadTrk(const std::filesystem::path& path);

// A .trk project that shows the points over the video, with axes and scale. Tracker's frames are all equally long.
// Throws Error unless the points are in px.
void WriteTrk(const std::filesystem::path& path, const PointRecording& points);

}  // namespace lake::exchange
