// The figure of lake-compare --left --right.
#pragma once

#include <filesystem>

#include "lake/compare/symmetry.h"

namespace lake::figure {

// PNG or SVG by the extension. Left: both knees' angles over the rise and, below, their difference with its 95 % band;
// right: the symmetry index of each quantity with its interval. Throws Error if it cannot be drawn.
void DrawSymmetry(const std::filesystem::path& path, const compare::Symmetry& symmetry);

}  // namespace lake::figure
