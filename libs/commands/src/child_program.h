// Another of the programs, started from a page: what it says is its progress.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/review/background_job.h"

namespace lake::commands {

struct ChildEnd {
  int code = 0;           // its exit status; 128 + the signal that ended it
  std::string last_line;  // that it said
};

enum class ChildSays { kProgress /* stderr */, kAll /* stdout too */ };

// Runs it to its end. Stopped, it is ended by SIGTERM and waited for before this throws. Throws Error naming the
// program where it cannot be started.
ChildEnd RunChild(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                  const review::BackgroundJob::Control& control, ChildSays says = ChildSays::kProgress);

}  // namespace lake::commands
