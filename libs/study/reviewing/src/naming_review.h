// Naming the markers of a video by clicks, and tracking it with these names.
#pragma once

#include <filesystem>

#include "lake/review/review.h"

namespace lake::reviewing {

// The capture rate is lake-track's; 0: the file's own times.
review::NamingWork NamingOf(const std::filesystem::path& video, double capture_rate_hz,
                            const std::filesystem::path& programs);

}  // namespace lake::reviewing
