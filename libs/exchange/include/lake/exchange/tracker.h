// Tracker (physlets.org/tracker): its text tables and its project files.
#pragma once

#include <filesystem>

#include "lake/exchange/point_recording.h"

namespace lake {

// A text table: `#multi:` if there are several tracks, a row of names, a row `t x y x y …`, then numbers;
// tab-separated, decimal point or comma, empty cells missing. Which unit it is in the file does not say: kPlane, in
// `mm_per_unit`. Throws Error naming file and line.
PointRecording ReadTrackerText(const std::filesystem::path& path, double mm_per_unit = 1);

// Points in the image are written in px with Tracker's pixel centres at 0.5.
void WriteTrackerText(const std::filesystem::path& path, const PointRecording& points);

// A .trk project: the point masses, in px of the image (Tracker's 0.5 subtracted); time from the clip's frame duration;
// the scale from the coordinate system if its length unit is known.
PointRecording ReadTrk(const std::filesystem::path& path);

}  // namespace lake
