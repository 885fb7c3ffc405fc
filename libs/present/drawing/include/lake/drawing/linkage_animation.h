// The linkage in motion: the actuator runs through its used range at constant speed, out and (in the video) back.
#pragma once

#include <filesystem>

#include "lake/drawing/linkage_figures.h"

namespace lake::drawing {

// Writes an H.264 MP4 and an endless GIF. Throws Error if one cannot be written.
void WriteLinkageAnimation(const std::filesystem::path& mp4, const std::filesystem::path& gif, const LinkageLook& look);

}  // namespace lake::drawing
