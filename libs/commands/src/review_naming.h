// Naming the markers of a video by clicks, and tracking it with these names.
#pragma once

#include <filesystem>

#include "lake/review/review.h"

namespace lake::commands {

review::NamingWork NamingOf(const std::filesystem::path& video, const std::filesystem::path& programs);

}  // namespace lake::commands
