// A program's manual page and completion, from its command line.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace lake {

// For man(1), section 1.
std::string ManPage(const CLI::App& cli);

// For bash: completes options, the choices of those that have some, and files.
std::string BashCompletion(const CLI::App& cli);

}  // namespace lake
