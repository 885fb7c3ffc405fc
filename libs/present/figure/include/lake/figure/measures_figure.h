// The figure of --angle, --distance and --speed.
#pragma once

#include <filesystem>
#include <vector>

#include "lake/gait/marker_measures.h"

namespace lake::figure {

// PNG or SVG by the extension: one above the other, the first six over time with their ± 2 SD. Throws Error if it
// cannot be drawn.
void DrawMeasures(const std::filesystem::path& path, const motion::MarkerRecording& recording,
                  const std::vector<gait::MeasuredCourse>& courses);

}  // namespace lake::figure
