// Pages from which others are opened: to begin in a folder of films and results, and a study's report with its trials.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "lake/core/json.h"
#include "lake/review/background_job.h"
#include "lake/review/page_options.h"

namespace lake::review {

// Each is served until its last window is closed.
struct OtherPages {
  // Serves the page of a film or of results and returns its address. Throws Error.
  std::function<std::string(const std::string& path)> open;
  std::function<bool()> are_open;
};

struct StartWork {
  std::string folder;           // for the page
  std::function<Json()> found;  // a list of FoundMessage in page/messages.ts
  OtherPages pages;
  // Makes the camera or the study that the page asks for (MakeQuestion there). Throws Error.
  std::function<void(const Json& asked, const BackgroundJob::Control& control)> make;
};

struct StudyWork {
  std::string name, command;     // for the page; `command` made the results
  std::filesystem::path report;  // need not be there
  Json parts;                    // what can be opened: a list of StudyPart in page/messages.ts
  OtherPages pages;
};

// Serve the page until its last window and the last page opened from it are closed. Throw Error where the port is
// taken, Interrupted once a signal has arrived.
void ServeStart(const PageOptions& options, const StartWork& work);
void ServeStudy(const PageOptions& options, const StudyWork& work);

}  // namespace lake::review
