// What all programs share: the common options, the effective options beside the results, one-line errors, exit codes.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/run.h"

namespace lake {

// Parses (adding --version), then runs `work`, and returns the exit code that `work` returns or its error has, with one
// line on stderr.
int ParseAndRun(CLI::App& cli, int argc, char** argv, const std::function<int()>& work);

class Program {
 public:
  // `example` is a command line that --help shows.
  Program(std::string name, std::string what, std::string example);

  // Bind the program's own options to this; a default is what the bound variable holds.
  CLI::App& Cli() { return cli_; }

  // Parses, runs `work`, and returns the exit code. `result_name` names the folder under ./lake-out (or is an absolute
  // path) when --out is not given; it is called after parsing. `work` writes its files through the Run and returns the
  // results for summary.json; with --json the summary goes to stdout, else `report`, if given, says the main numbers
  // there.
  int Main(int argc, char** argv, const std::function<std::string()>& result_name,
           const std::function<Json(Run&)>& work, const std::function<std::string(const Json&)>& report = {});

 private:
  int Work(const std::string& command, const std::string& result_name, const std::function<Json(Run&)>& work,
           const std::function<std::string(const Json&)>& report);
  Json EffectiveOptions() const;

  // What the results will be of: the files and folders named without an option, else those that options name; absolute.
  std::vector<std::string> Subject() const;

  std::string name_;
  CLI::App cli_;
  std::string out_;
  bool quiet_ = false;
  bool json_ = false;
};

}  // namespace lake
