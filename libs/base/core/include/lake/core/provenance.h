// What made a result: version, commit, content hashes.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace lake {

std::string_view Version();

// Of which the program was built: 40 hexadecimal digits, or "unknown" (built from a tarball, or without git).
std::string_view Commit();

// Whether the programs' sources were as in that commit: "clean", "changed" or "unknown".
std::string_view SourceTree();

// For --version: "0.2.0 (commit 3cc32445d0f1, clean)".
std::string VersionAndCommit();

// Lower-case hexadecimal SHA-256 of a file's content; of a folder, the hash of its files' sorted names and hashes.
// A file hashed before by this process and untouched since is not read again. Throws Error if it cannot be read.
std::string Sha256OfFile(const std::filesystem::path& path);

// Lower-case hexadecimal SHA-256 of one of the project's programs and of the project's shared libraries beside it
// (../lib/lake), but for the commit that they name: programs of several commits that have the same code have the same.
// Throws Error if it cannot be read.
std::string Sha256OfProgram(const std::filesystem::path& program);

std::string Sha256OfText(std::string_view text);

// A path or a text with the user's home folder written as "~", so that what is passed on with results does not say
// whose folder it was.
std::string WithoutHome(const std::string& text, std::string_view written = "~");

// The path with its leading "~" as the user's home folder again.
std::filesystem::path FromHome(const std::filesystem::path& path);

}  // namespace lake
