// What made a result: version, content hashes.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace lake {

std::string_view Version();

// Lower-case hexadecimal SHA-256 of a file's content; of a folder, the hash of its files' sorted names and hashes.
// Throws Error if it cannot be read.
std::string Sha256OfFile(const std::filesystem::path& path);

std::string Sha256OfText(std::string_view text);

}  // namespace lake
