// Common to all programs: options from their descriptions, the effective options in the summary, one-line errors, exit
// codes.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/core/run.h"

// CLI11 is declared only: its headers take the compiler seconds.
namespace CLI {
class App;
}

namespace lake {

using SharedOptions = std::shared_ptr<OptionList>;

// Adds the options to a command line, which keeps them; they are set by OptionList::Apply() once it is parsed. `group`
// is a heading of their own in --help.
SharedOptions AddOptions(CLI::App& cli, OptionList options, const std::string& group = "");

// All options of a command line that was parsed, given or not: name → text, or texts where several may be given; those
// of `lists` with the values that they have without one.
Json EffectiveOptions(const CLI::App& cli, const std::vector<SharedOptions>& lists);

// Parses (adding --version), then runs `work`. Returns its exit code, or that of its error after one line on stderr.
// `lists`: what was added by AddOptions().
int ParseAndRun(CLI::App& cli, const std::vector<SharedOptions>& lists, int argc, char** argv,
                const std::function<int()>& work);

// A program that leaves no folder of results: parses, sets the options, runs `work`, and returns the exit code.
// `examples` are command lines that --help shows.
int RunTool(const std::string& name, const std::string& what, const std::string& examples, OptionList options, int argc,
            char** argv, const std::function<void()>& work);

class Program {
 public:
  // `example` is a command line that --help shows.
  Program(std::string name, std::string what, std::string example);
  ~Program();

  // The program's own options, which stay bound to their struct; and those of a command of it, with the question, once
  // the command line is parsed, whether that command was given.
  SharedOptions Add(OptionList options, const std::string& group = "");
  std::function<bool()> AddCommand(const std::string& name, const std::string& what, const std::string& example,
                                   OptionList options);

  // Whether --json was given; for a program that writes its summary itself (null results).
  bool SaysJson() const { return json_; }

  // The folder for the results is given by its place on the command line, after what was added before, not by --out.
  void TakeOutByPlace();

  // Parses, runs `work`, and returns the exit code. `result_name` names the folder under ./lake-out (or is an absolute
  // path) when --out is not given; it is called after parsing. `work` writes its files through the Run and returns the
  // results for summary.json; with --json the summary goes to stdout, else the run's report. Null results: there is no
  // summary, and nothing more is written or said.
  int Main(int argc, char** argv, const std::function<std::string()>& result_name,
           const std::function<Json(Run&)>& work);

 private:
  int Work(const std::string& command, const std::string& result_name, const std::function<Json(Run&)>& work);

  // Those of the command line itself and of the command that was given.
  std::vector<SharedOptions> GivenLists() const;

  // The inputs of the results: the files and folders named without an option, else those that options name; absolute.
  std::vector<std::string> Subject() const;

  std::string name_;
  std::unique_ptr<CLI::App> cli_;
  std::vector<std::pair<const CLI::App*, SharedOptions>> lists_;
  std::string out_;
  std::optional<int> threads_;
  bool quiet_ = false;
  bool json_ = false;
};

}  // namespace lake
