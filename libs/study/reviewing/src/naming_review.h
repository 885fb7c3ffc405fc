// Naming the markers of a video by clicks, and tracking it with these names.
#pragma once

#include <filesystem>

#include "lake/review/review.h"

namespace lake::reviewing {

// `given`: options of lake-track's beside those that the page asks for.
review::NamingWork NamingOf(const std::filesystem::path& video, const Json& given,
                            const std::filesystem::path& programs);

}  // namespace lake::reviewing
