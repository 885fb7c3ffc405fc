// Where files lie.
#pragma once

#include <filesystem>

namespace lake {

// Whether a file or folder lies in a folder, or is that folder; symbolic links are followed, and neither has to exist.
bool LiesIn(const std::filesystem::path& path, const std::filesystem::path& folder);

}  // namespace lake
