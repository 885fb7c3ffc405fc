// A comparison to be looked at: the two trials that lake-compare was given, with their videos.
#pragma once

#include <filesystem>

#include "lake/review/comparison_page.h"

namespace lake::reviewing {

// Throws Error: not a folder of lake-compare's, a trial that has no video or is not to be found.
review::ComparedPair ReadComparedPair(const std::filesystem::path& folder);

}  // namespace lake::reviewing
