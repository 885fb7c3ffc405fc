// The list of files that a run left in its folder.
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace lake {

inline constexpr const char* kSummary = "summary.json";

// Where a run keeps its results until they are complete, and where those of one that failed go.
std::filesystem::path UnfinishedFolder(const std::filesystem::path& folder, const std::string& program);
inline constexpr const char* kFailedFolder = "failed";

struct ResultsList {
  std::string program, command;
  std::vector<std::string> subject;
  std::string step;
  std::set<std::string> files;  // relative to the folder, none outside it
  bool is_complete = false;     // the run did not fail

  // "lake-track (/data/human.mp4)"
  std::string Describe() const;
};

std::filesystem::path ResultsListPath(const std::filesystem::path& folder, const std::string& program);

// Empty if there is none, or none that can be read.
ResultsList ReadResultsList(const std::filesystem::path& folder, const std::string& program);

// Of all programs.
std::vector<ResultsList> ResultsListsIn(const std::filesystem::path& folder);

void WriteResultsList(const std::filesystem::path& folder, const ResultsList& list);

// Removes the files, the summary first, and folders of theirs that are left empty. Throws Error if a file cannot be
// removed.
void RemoveResultFiles(const std::filesystem::path& folder, const std::set<std::string>& files);

// The same, then the list; where a file cannot be removed the list stays.
void RemoveResults(const std::filesystem::path& folder, const ResultsList& list);

// In the place of what is there, making the folder. Throws Error.
void MoveResult(const std::filesystem::path& from, const std::filesystem::path& to);

}  // namespace lake
