// The front door: `lake track …` runs `lake-track …`, found beside this program.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lake/core/nearest_name.h"
#include "lake/core/provenance.h"
#include "lake/core/standard_output.h"
#include "programs.h"

using lake::kPrograms;
using lake::ListedProgram;
namespace fs = std::filesystem;

namespace {

std::vector<std::string> StepNames() {
  std::vector<std::string> names;
  for (const ListedProgram& step : kPrograms) names.emplace_back(step.name);
  return names;
}

bool IsInstalled(const fs::path& folder, std::string_view step) {
  return access((folder / fmt::format("lake-{}", step)).c_str(), X_OK) == 0;
}

void PrintHelp(const fs::path& folder) {
  fmt::print("lake: from two videos of a sit-to-stand to a better knee exoskeleton\n\nUsage: lake STEP [OPTIONS]\n\n");
  for (const ListedProgram& step : kPrograms)
    if (IsInstalled(folder, step.name)) fmt::print("  {:<10} {}\n", step.name, step.what);
  fmt::print(
      "\n`lake STEP --help` or `lake help STEP` shows the options of a step; each is also a program, lake-STEP.\n");
}

// Completes the steps, whose descriptions have no quotes; what follows is completed as lake-STEP completes it.
std::optional<std::string> Completion(const fs::path& folder, std::string_view shell) {
  std::string names, zsh, fish;
  for (const ListedProgram& step : kPrograms) {
    if (!IsInstalled(folder, step.name)) continue;
    names += fmt::format("{}{}", names.empty() ? "" : " ", step.name);
    zsh += fmt::format("    '{}:{}'\n", step.name, step.what);
    fish += fmt::format("complete -c lake -n __fish_use_subcommand -f -a {} -d '{}'\n", step.name, step.what);
  }
  if (shell == "bash")
    return fmt::format(
        "_lake() {{\n  local word=${{COMP_WORDS[COMP_CWORD]}}\n  if [ \"$COMP_CWORD\" -eq 1 ]; then\n"
        "    COMPREPLY=($(compgen -W '{}' -- \"$word\"))\n    return\n  fi\n  local step=lake-${{COMP_WORDS[1]}}\n"
        "  declare -F \"_${{step//-/_}}\" >/dev/null || _completion_loader \"$step\"\n"
        "  COMP_WORDS=(\"$step\" \"${{COMP_WORDS[@]:2}}\") COMP_CWORD=$((COMP_CWORD - 1))\n"
        "  \"_${{step//-/_}}\"\n}}\ncomplete -o filenames -F _lake lake\n",
        names);
  if (shell == "zsh")
    return fmt::format(
        "#compdef lake\nif (( CURRENT == 2 )); then\n  local -a steps=(\n{}  )\n  _describe step steps\nelse\n"
        "  words=(\"lake-$words[2]\" \"${{(@)words[3,-1]}}\")\n  (( CURRENT-- ))\n  _normal\nfi\n",
        zsh);
  if (shell == "fish")
    return fish +
           "complete -c lake -n 'not __fish_use_subcommand' -a "
           "'(complete -C (string replace -r \"^lake +\" lake- -- (commandline -cp)))'\n";
  return std::nullopt;
}

int Complain(const std::string& text) {
  fmt::print(stderr, "lake: {}; see lake --help\n", text);
  return 2;
}

// `words`: the step and what is given to it.
int BecomeStep(const fs::path& folder, std::vector<std::string> words) {
  words.front() = (folder / fmt::format("lake-{}", words.front())).string();
  std::vector<char*> arguments(words.size() + 1, nullptr);  // execv's list ends with a null pointer
  std::transform(words.begin(), words.end(), arguments.begin(), [](std::string& word) { return word.data(); });
  execv(arguments.front(), arguments.data());
  fmt::print(stderr, "lake: {} cannot be started: {}\n", words.front(), std::strerror(errno));
  return 1;
}

int PrintOrBecomeStep(int argc, char** argv) {
  const fs::path folder = fs::read_symlink("/proc/self/exe").parent_path();
  if (argc < 2) {
    const bool is_desktop = std::getenv("DISPLAY") || std::getenv("WAYLAND_DISPLAY");
    return is_desktop ? BecomeStep(folder, {"review", ".", "--open"}) : Complain("a step is missing");
  }
  std::string_view step = argv[1];
  if (step == "help" && argc > 2) {  // lake help STEP
    static std::string help = "--help";
    step = argv[2];
    argv[1] = argv[2];
    argv[2] = help.data();
    argc = 3;
  }
  if (step == "--help" || step == "--help-all" || step == "-h" || step == "help") {
    PrintHelp(folder);
    return 0;
  }
  if (step == "--completion") {
    const auto completion = Completion(folder, argc > 2 ? argv[2] : "");
    if (!completion) return Complain("--completion takes bash, zsh or fish");
    fmt::print("{}", *completion);
    return 0;
  }
  if (step == "--version") {
    fmt::print("lake {}\n", lake::VersionAndCommit());
    return 0;
  }
  if (step.starts_with("-")) return Complain(fmt::format("no option '{}'", step));
  if (step.find('/') != std::string_view::npos || !IsInstalled(folder, step))
    return Complain(fmt::format("no step '{}'{}", step, lake::DidYouMean(step, StepNames())));

  return BecomeStep(folder, {argv + 1, argv + argc});
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const int code = PrintOrBecomeStep(argc, argv);
    lake::FlushStdout();
    return code;
  } catch (const std::exception& error) {
    fmt::print(stderr, "lake: {}\n", error.what());
    return 1;
  }
}
