// What lake review saves in a lake-track folder, and whether the folder's results were made with it.
#pragma once

#include <filesystem>
#include <string>

namespace lake::motion {

inline constexpr const char* kSavedCorrections = "corrections.csv";
inline constexpr const char* kSavedEvents = "events_corrected.csv";
inline constexpr const char* kReviewFile = "review.json";  // its `command` tracks again with both

// A warning that names the folder, how many corrections it was not tracked with, and the command that applies them.
// Empty where it was tracked with all that are saved, as the hashes of its inputs say, and for a folder of another
// program's. Throws Error for a file that cannot be read.
std::string UnappliedCorrections(const std::filesystem::path& folder);

}  // namespace lake::motion
