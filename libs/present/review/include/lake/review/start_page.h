// The page to begin with: the films and results of a folder, and the way from a board and two films to a study.
#pragma once

#include <functional>
#include <string>

#include "lake/core/json.h"
#include "lake/review/background_job.h"
#include "lake/review/page_options.h"

namespace lake::review {

struct StartWork {
  std::string folder;           // for the page
  std::function<Json()> found;  // a list of FoundMessage in page/messages.ts
  // Serves the page of what was found and returns its address. Throws Error.
  std::function<std::string(const std::string& path)> open;
  std::function<bool()> has_open_pages;
  // Makes the camera or the study that the page asks for (MakeQuestion there). Throws Error.
  std::function<void(const Json& asked, const BackgroundJob::Control& control)> make;
};

// Serves the page until its last window and the last page opened from it are closed. Throws Error where the port is
// taken, Interrupted once a signal has arrived.
void ServeStart(const PageOptions& options, const StartWork& work);

}  // namespace lake::review
