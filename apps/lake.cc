// The front door: `lake track …` runs `lake-track …`, found beside this program.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
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

namespace fs = std::filesystem;

namespace {

struct Step {
  std::string_view name, what;
};
constexpr std::array kSteps = {
    Step{"run", "a whole study, from two videos to a better exoskeleton"},
    Step{"cohort", "the studies of many people, and what they say as a group"},
    Step{"calibrate", "camera and sagittal plane from pictures of a board"},
    Step{"check", "in seconds: is a recording fit, and what to change"},
    Step{"track", "markers, leg vectors and knee angle from a video"},
    Step{"review", "in the browser: correct a trial, name markers, explore a design"},
    Step{"live", "an exoskeleton aligned while it is worn, by where its joint sits after each rise"},
    Step{"anonymise", "a copy of a recording with the head blurred"},
    Step{"gait", "the leg fit on tracks made before, or by another program"},
    Step{"compare", "misalignment between a human trial and an exoskeleton trial"},
    Step{"loads", "the moments at ankle, knee and hip over the rise"},
    Step{"axis", "the axis about which shank and thigh turn"},
    Step{"sync", "the clocks of two recordings of one movement, aligned"},
    Step{"optimize", "the links that give the largest range of rotation"},
    Step{"simulate", "poses, angle against stroke and animation of a design"},
    Step{"export", "a design for simulators, CAD and cutters"},
    Step{"stroke", "stroke program and firmware for the actuator"},
    Step{"convert", "a trial file in another format"},
    Step{"info", "what is inside a trial file"},
    Step{"synth", "a rendered recording with its ground truth"},
};

std::vector<std::string> StepNames() {
  std::vector<std::string> names;
  for (const Step& step : kSteps) names.emplace_back(step.name);
  return names;
}

bool IsInstalled(const fs::path& folder, std::string_view step) {
  return access((folder / fmt::format("lake-{}", step)).c_str(), X_OK) == 0;
}

void PrintHelp(const fs::path& folder) {
  fmt::print("lake: from two videos of a sit-to-stand to a better knee exoskeleton\n\nUsage: lake STEP [OPTIONS]\n\n");
  for (const Step& step : kSteps)
    if (IsInstalled(folder, step.name)) fmt::print("  {:<10} {}\n", step.name, step.what);
  fmt::print(
      "\n`lake STEP --help` or `lake help STEP` shows the options of a step; each is also a program, lake-STEP.\n");
}

// Completes the steps, whose descriptions have no quotes; what follows is completed as lake-STEP completes it.
std::optional<std::string> Completion(const fs::path& folder, std::string_view shell) {
  std::string names, zsh, fish;
  for (const Step& step : kSteps) {
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
