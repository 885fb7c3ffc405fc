// What a step was made of and what it left: a file beside its outputs.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/file_stamp.h"
#include "lake/core/json.h"
#include "lake/steps/study_steps.h"

namespace lake::steps {

// The content of a file, found again without reading it where that is certain.
struct FileState {
  std::filesystem::path path;
  std::string sha256;  // "absent" if there is none
  FileStamp stamp;     // looked up before its content was read

  bool IsAbsent() const;
};

// Of a file, a folder (its files) or nothing. The hash of `known` is taken over without reading where the file is
// untouched since (IsUntouched).
FileState StateOf(const std::filesystem::path& path, const FileState* known = nullptr);

struct StepStamp {
  std::string made_by = {};
  Json options = {};
  std::vector<FileState> inputs = {}, outputs = {};
  StepCost cost = {};
};

// nullopt if there is none, or none that can be read: the step is then done again.
std::optional<StepStamp> ReadStamp(const std::filesystem::path& folder, const std::string& step);
void WriteStamp(const std::filesystem::path& folder, const std::string& step, const StepStamp& stamp);

// Leaves the reason for which a step failed in the place of its stamp, where that can be written.
void WriteFailure(const std::filesystem::path& folder, const std::string& step, const std::string& error);
std::optional<std::string> ReadFailure(const std::filesystem::path& folder, const std::string& step);

// The stamp alone: the outputs are the run's, whose list of results says which they are.
void RemoveStamp(const std::filesystem::path& folder, const std::string& step);

}  // namespace lake::steps
