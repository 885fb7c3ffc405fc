// A program that has no folder of results: one-line errors on stderr and the exit codes all programs share.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "lake/core/error.h"
#include "lake/core/provenance.h"

namespace lake {

inline int RunPlainProgram(CLI::App& cli, int argc, char** argv, const std::function<void()>& work) {
  const auto complain = [&](const std::string& text, int code) {
    fmt::print(stderr, "{}: {}\n", cli.get_name(), text);
    return code;
  };
  cli.set_version_flag("--version", fmt::format("{} {}", cli.get_name(), Version()));
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return cli.exit(error);
    return complain(fmt::format("{}; see {} --help", error.what(), cli.get_name()), 2);
  }
  try {
    work();
    return 0;
  } catch (const UsageError& error) {
    return complain(error.what(), 2);
  } catch (const std::exception& error) {
    return complain(error.what(), 1);
  }
}

}  // namespace lake
