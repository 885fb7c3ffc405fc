// A program's manual page and completion, from its command line.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace lake {

// For man(1), section 1.
std::string ManPage(const CLI::App& cli);

// For a shell, bash, zsh or fish: completes options, the choices of those that have some, and files. Throws UsageError
// for another shell.
std::string Completion(const CLI::App& cli, const std::string& shell);

}  // namespace lake
