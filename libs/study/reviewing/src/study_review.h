// A study to be looked at: its steps as they are planned, one of them done by lake-run --only.
#pragma once

#include <filesystem>

#include "lake/core/json.h"
#include "lake/gait/movement.h"
#include "lake/review/study_page.h"

namespace lake::reviewing {

// The study file of a folder of lake-run's with this summary, as it is now: it may have been edited since. Throws Error
// where it is not to be found.
std::filesystem::path StudyFileOf(const Json& summary, const std::filesystem::path& folder);

// Of a folder of lake-run's. Throws Error: its study file is not to be found or has changed.
review::StudyWork StudyWorkOf(const std::filesystem::path& folder, const std::optional<gait::MovementKind>& movement,
                              const std::filesystem::path& programs);

}  // namespace lake::reviewing
