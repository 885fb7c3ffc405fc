#include "pages.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

#include "lake/core/csv.h"
#include "lake/core/error.h"

namespace lake {
namespace {

bool IsShown(const CLI::Option& option) {
  return option.get_group() != "";
}

// The command line itself, its groups and its commands.
std::vector<const CLI::App*> Levels(const CLI::App& cli) {
  std::vector<const CLI::App*> levels = {&cli};
  for (const CLI::App* level : cli.get_subcommands([](const CLI::App*) { return true; })) levels.push_back(level);
  return levels;
}

// "constant|free" as its parts; of MM, FILE and their like nothing.
std::vector<std::string> ChoicesOf(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const bool are_choices = type.find('|') != std::string::npos &&
                           std::none_of(type.begin(), type.end(), [](unsigned char c) { return std::isupper(c); });
  return are_choices ? SplitText(type, '|') : std::vector<std::string>{};
}

std::string ReplaceAll(std::string text, const std::string& what, const std::string& with) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += with.size())
    text.replace(at, what.size(), with);
  return text;
}

// An option that shells complete: one with a long name.
struct ShellOption {
  std::string name;        // --overlay
  std::string short_name;  // -o
  std::string help, value;
  bool takes_value = false, is_repeated = false;
  std::vector<std::string> choices;
};

// Of all levels; a name that several have only once, as the first has it.
std::vector<ShellOption> ShellOptions(const CLI::App& cli) {
  std::vector<ShellOption> options;
  std::set<std::string> known;
  for (const CLI::App* level : Levels(cli))
    for (const CLI::Option* option : level->get_options()) {
      if (!IsShown(*option)) continue;
      std::string short_name = option->get_snames().empty() ? "" : "-" + option->get_snames().front();
      for (const std::string& name : option->get_lnames()) {
        if (!known.insert(name).second) continue;
        const bool is_negation = name == "no-" + option->get_lnames().front();
        options.push_back({.name = "--" + name,
                           .short_name = std::exchange(short_name, ""),
                           .help = (is_negation ? "Not: " : "") + option->get_description(),
                           .value = option->get_type_name(),
                           .takes_value = option->get_items_expected_max() > 0,
                           .is_repeated = option->get_items_expected_max() > 1,
                           .choices = ChoicesOf(*option)});
      }
    }
  return options;
}

std::vector<const CLI::App*> CommandsOf(const CLI::App& cli) {
  return cli.get_subcommands([](const CLI::App* app) { return !app->get_name().empty(); });
}

// As _arguments of zsh takes it, in single quotes.
std::string ZshText(std::string text) {
  for (const char* special : {"\\", "[", "]", ":"}) text = ReplaceAll(text, special, std::string("\\") + special);
  return ReplaceAll(text, "'", "'\\''");
}

std::string ZshSpec(const ShellOption& option, const std::string& name) {
  std::string spec = (option.is_repeated ? "*" : "") + name;
  if (option.takes_value) spec += name.starts_with("--") ? "=" : "+";
  spec += fmt::format("[{}]", ZshText(option.help));
  if (option.takes_value)
    spec += fmt::format(":{}:{}", ZshText(option.value),
                        option.choices.empty() ? "_files" : fmt::format("({})", fmt::join(option.choices, " ")));
  return fmt::format("  '{}' \\\n", spec);
}

std::string FishText(const std::string& text) {
  return "'" + ReplaceAll(ReplaceAll(text, "\\", "\\\\"), "'", "\\'") + "'";
}

std::string FishLine(const std::string& program, const ShellOption& option) {
  std::string line = fmt::format("complete -c {} -l {}", program, option.name.substr(2));
  if (!option.short_name.empty()) line += " -s " + option.short_name.substr(1);
  if (!option.choices.empty())
    line += fmt::format(" -x -a '{}'", fmt::join(option.choices, " "));
  else if (option.takes_value)
    line += " -r";
  return fmt::format("{} -d {}\n", line, FishText(option.help));
}

std::string BashCompletion(const CLI::App& cli) {
  std::vector<std::string> names, commands;
  std::string cases;
  for (const ShellOption& option : ShellOptions(cli)) {
    names.push_back(option.name);
    if (!option.choices.empty())
      cases += fmt::format("    {}) COMPREPLY=($(compgen -W '{}' -- \"$word\")); return ;;\n", option.name,
                           fmt::join(option.choices, " "));
  }
  for (const CLI::App* command : CommandsOf(cli)) commands.push_back(command->get_name());
  std::string function = "_" + cli.get_name();
  std::replace(function.begin(), function.end(), '-', '_');
  return fmt::format(
      "{0}() {{\n  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}}\n  case $before in\n"
      "{1}  esac\n  if [[ $word == -* ]]; then\n    COMPREPLY=($(compgen -W '{2}' -- \"$word\"))\n"
      "  else\n    COMPREPLY=($(compgen -f -W '{3}' -- \"$word\"))\n  fi\n}}\ncomplete -o filenames -F {0} {4}\n",
      function, cases, fmt::join(names, " "), fmt::join(commands, " "), cli.get_name());
}

std::string ZshCompletion(const CLI::App& cli) {
  std::string specs;
  for (const ShellOption& option : ShellOptions(cli))
    for (const std::string& name : {option.name, option.short_name})
      if (!name.empty()) specs += ZshSpec(option, name);
  std::vector<std::string> commands;
  for (const CLI::App* command : CommandsOf(cli)) commands.push_back(command->get_name());
  const std::string operands =
      commands.empty()
          ? "_files"
          : fmt::format("{{ _alternative \"commands:command:({})\" \"files:file:_files\" }}", fmt::join(commands, " "));
  return fmt::format("#compdef {}\n_arguments -S \\\n{}  '*:file:{}'\n", cli.get_name(), specs, operands);
}

std::string FishCompletion(const CLI::App& cli) {
  std::string lines;
  for (const ShellOption& option : ShellOptions(cli)) lines += FishLine(cli.get_name(), option);
  for (const CLI::App* command : CommandsOf(cli))
    lines += fmt::format("complete -c {} -n __fish_use_subcommand -a {} -d {}\n", cli.get_name(), command->get_name(),
                         FishText(command->get_description()));
  return lines;
}

}  // namespace

std::string Completion(const CLI::App& cli, const std::string& shell) {
  if (shell == "bash") return BashCompletion(cli);
  if (shell == "zsh") return ZshCompletion(cli);
  if (shell == "fish") return FishCompletion(cli);
  throw UsageError("--completion '{}': bash, zsh or fish", shell);
}

}  // namespace lake
