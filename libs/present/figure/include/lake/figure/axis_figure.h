// The figure of lake-axis.
#pragma once

#include <filesystem>
#include <vector>

#include "lake/axis/functional_axis.h"

namespace lake::figure {

// PNG or SVG by the extension. Where the axis is on the shank, seen along it: windows and whole with their 95 %
// ellipses, and where the axis is frame by frame; beside it, that over the knee angle with its 95 % band.
// Throws Error if it cannot be drawn.
void DrawAxis(const std::filesystem::path& path, const axis::SegmentMotion& motion, const axis::MeanAxesResult& axes,
              const std::vector<axis::InstantaneousCentre>& centres);

}  // namespace lake::figure
