// The figure of markers that are no leg: where they were over time.
#pragma once

#include <filesystem>
#include <string>

#include "lake/motion/marker_recording.h"

namespace lake::figure {

// PNG or SVG by the extension: horizontal and vertical position of every marker over time, gaps left open.
void DrawTracksFigure(const std::filesystem::path& path, const motion::MarkerRecording& recording,
                      const std::string& title);

}  // namespace lake::figure
