// The figure of lake-loads.
#pragma once

#include <filesystem>
#include <string>

#include "lake/loads/loads.h"

namespace lake::figure {

// PNG or SVG by the extension. The knee's moment over the rise, each rise and their mean with its 95 % band, before
// seat-off the bounds; the three joints' mean moments; where the ground's force acts, with the foot; the knee's power.
// Throws Error if it cannot be drawn.
void DrawLoads(const std::filesystem::path& path, const loads::LoadsResult& result, const std::string& title);

}  // namespace lake::figure
