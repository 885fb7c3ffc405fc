// The page on which a person changes the links of a design and sees at once what becomes of it.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "lake/review/background_job.h"
#include "lake/review/design_explorer.h"
#include "lake/review/page_options.h"

namespace lake::review {

struct DesignWork {
  // Saves it under a name that is free, and says which. Throws Error.
  std::function<std::filesystem::path(const linkage::Design&)> save;
  // The command line that optimises from these links. Throws Error where there is none that has the same limits.
  std::function<std::string(const linkage::Links&)> command;
  // Does so, and gives the optimum. Throws Error, also where there is none.
  std::function<linkage::Design(const linkage::Links&, const BackgroundJob::Control&)> optimise;
};

// Serves the page until its last window is closed. Throws Error where the port is taken, Interrupted once a signal has
// arrived.
void ServeDesign(const PageOptions& options, ExploredDesign explored, const DesignWork& work);

}  // namespace lake::review
