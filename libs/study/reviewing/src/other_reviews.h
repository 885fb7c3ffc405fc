// Pages from which others are opened, each by a lake-review of its own.
#pragma once

#include <filesystem>

#include "lake/review/pages.h"

namespace lake::reviewing {

// Of the present folder; pages of what is found there are served as `page` is, by programs in the folder `programs`.
review::StartWork StartWorkOf(const review::PageOptions& page, const std::filesystem::path& programs);

// Of a folder of lake-run's. Throws Error where it is none.
review::StudyWork StudyWorkOf(const std::filesystem::path& folder, const review::PageOptions& page,
                              const std::filesystem::path& programs);

// The lake-track folder of a trial: of a folder of lake-gait's the one that its trial is of. Throws Error where it is
// of none, or that is not to be found.
std::filesystem::path TrackedTrialOf(const std::filesystem::path& folder);

}  // namespace lake::reviewing
