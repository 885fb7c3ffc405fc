// What steps that are no one person's have left, kept by content: LAKE_CACHE names the folder.
#pragma once

#include <filesystem>
#include <string>

#include "file_state.h"
#include "lake/core/file_lock.h"
#include "lake/steps/study_steps.h"

namespace lake::steps {

// The place of one step's outputs. Its name is the SHA-256 of all that they are made of: the program (version and
// content), the step's name and options, and the content of its inputs. While the object lives no other process has
// the same entry, so what several ask for at the same time is done once.
class CacheEntry {
 public:
  // Makes the folder where it is missing; waits for other processes. Throws Error where it cannot be written, and
  // Interrupted.
  CacheEntry(const std::filesystem::path& folder, const StudyStep& step, const std::vector<FileState>& inputs,
             const std::string& made_by);

  // Writes the outputs through the run as the step's work would, with the run's own summary. false, and nothing is
  // written, where there is no entry or one that is not as it was stored.
  bool Restore(Run& run) const;

  // Keeps what the step's work left in this run, in one file that is there whole or not at all.
  void Store(const Run& run) const;

 private:
  static std::filesystem::path PathIn(const std::filesystem::path& folder, const StudyStep& step,
                                      const std::vector<FileState>& inputs, const std::string& made_by);

  const StudyStep& step_;
  std::filesystem::path path_;
  FileLock lock_;
};

}  // namespace lake::steps
