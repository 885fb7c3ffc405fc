// The list of files that a run left in its folder.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace lake {

inline constexpr const char* kSummary = "summary.json";

struct ResultsList {
  std::string program, command;
  std::vector<std::string> subject;
  std::string step;
  std::set<std::string> files;  // relative to the folder, none outside it

  // "lake-track (/data/human.mp4)"
  std::string Describe() const;
};

std::filesystem::path ResultsListPath(const std::filesystem::path& folder, const std::string& program);

// Empty if there is none, or none that can be read.
ResultsList ReadResultsList(const std::filesystem::path& folder, const std::string& program);

// Of all programs.
std::vector<ResultsList> ResultsListsIn(const std::filesystem::path& folder);

void WriteResultsList(const std::filesystem::path& folder, const ResultsList& list);

// Removes the files, the summary first, folders of theirs that are left empty, and the list. Throws Error if a file
// cannot be removed; what is left stands in the list then.
void RemoveResults(const std::filesystem::path& folder, const ResultsList& list);

}  // namespace lake
