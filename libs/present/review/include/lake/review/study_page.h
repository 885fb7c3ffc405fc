// The page that shows a study's report and the state of its steps, and does one of them again.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "lake/core/json.h"
#include "lake/review/background_job.h"
#include "lake/review/page_options.h"

namespace lake::review {

struct StudyWork {
  std::string name, command;     // for the page; `command` does all that is due
  std::filesystem::path report;  // need not be there
  std::filesystem::path folder;  // of the results; what lies in it is shown
  // As lake-run --plan says it. Throws Error.
  std::function<Json()> plan;
  // Does one step, or all that is due if the name is empty. Throws Error.
  std::function<void(const std::string& step, const BackgroundJob::Control& control)> run;
};

// Serves the page until its last window is closed. Throws Error where the port is taken, Interrupted once a signal has
// arrived.
void ServeStudy(const PageOptions& options, const StudyWork& work);

}  // namespace lake::review
