// Other programs, run to their end for a page.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/core/child_program.h"
#include "lake/core/error.h"
#include "lake/review/background_job.h"

namespace lake::reviewing {

// Throws Error with the program's last words where it fails, and what stops the job.
inline void RunProgram(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                       const review::BackgroundJob::Control& control) {
  const ChildEnd end = RunChild(program, arguments, control.say, control.throw_if_stopped);
  if (end.code != 0) throw Fail("{} ended with code {}: {}", program.filename().string(), end.code, end.last_line);
}

}  // namespace lake::reviewing
