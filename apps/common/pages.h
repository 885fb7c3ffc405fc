// A program's completion, from its command line.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace lake {

// For a shell, bash, zsh or fish: completes options, the choices of those that have some, and files. Throws UsageError
// for another shell.
std::string Completion(const CLI::App& cli, const std::string& shell);

}  // namespace lake
