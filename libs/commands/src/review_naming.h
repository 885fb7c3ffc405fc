// Naming the markers of a video by clicks, and tracking it with these names.
#pragma once

#include <filesystem>

#include "lake/review/review.h"
#include "tracked_folder.h"

namespace lake::commands {

// The trial of a folder that was tracked, for the page.
review::ReviewedTrial ReviewedTrialOf(TrackedFolder folder);

review::NamingWork NamingOf(const std::filesystem::path& video, const std::filesystem::path& programs);

}  // namespace lake::commands
