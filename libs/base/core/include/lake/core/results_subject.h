// What a folder's results are of.
#pragma once

#include <filesystem>
#include <vector>

namespace lake {

// The files and folders that the runs in a folder were of, such as the study file of each of its steps, or the video of
// a trial: absolute paths, where they were then. Empty in a folder without results.
std::vector<std::filesystem::path> SubjectsOf(const std::filesystem::path& folder);

}  // namespace lake
