// The page to begin with, over a folder of films and results.
#pragma once

#include <filesystem>

#include "lake/review/start_page.h"

namespace lake::reviewing {

// Of the present folder; pages of what is found there are served as `page` is, by programs in the folder `programs`.
review::StartWork StartWorkOf(const review::PageOptions& page, const std::filesystem::path& programs);

}  // namespace lake::reviewing
