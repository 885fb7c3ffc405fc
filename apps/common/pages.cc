#include "pages.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "lake/core/csv.h"
#include "lake/core/provenance.h"

namespace lake {
namespace {

// As troff takes it: a '-' that can be copied, no request at a line's beginning.
std::string Troff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const bool begins_line = out.empty() || out.back() == '\n';
    if (begins_line && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else
      out += c;
  }
  return out;
}

bool IsShown(const CLI::Option& option) {
  return option.get_group() != "";
}

// The command line itself, its groups and its commands.
std::vector<const CLI::App*> Levels(const CLI::App& cli) {
  std::vector<const CLI::App*> levels = {&cli};
  for (const CLI::App* level : cli.get_subcommands([](const CLI::App*) { return true; })) levels.push_back(level);
  return levels;
}

std::string ManItem(const CLI::Option& option) {
  std::string item = fmt::format(".TP\n\\fB{}\\fR", Troff(option.get_name(option.get_positional(), true)));
  if (option.get_items_expected_max() > 0) item += fmt::format(" \\fI{}\\fR", Troff(option.get_type_name()));
  std::string help = option.get_description();
  if (!option.get_default_str().empty() && help.find("(default") == std::string::npos)
    help += fmt::format(" (default: {})", option.get_default_str());
  return fmt::format("{}\n{}\n", item, Troff(help));
}

std::string ManSection(const CLI::App& level, const std::string& title) {
  std::string section = fmt::format(".SH {}\n", title);
  if (!level.get_description().empty()) section += Troff(level.get_description()) + "\n";
  for (const CLI::Option* option : level.get_options())
    if (IsShown(*option)) section += ManItem(*option);
  return section;
}

std::string Upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

// "constant|free" as its parts; of MM, FILE and their like nothing.
std::vector<std::string> ChoicesOf(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const bool are_choices = type.find('|') != std::string::npos &&
                           std::none_of(type.begin(), type.end(), [](unsigned char c) { return std::isupper(c); });
  return are_choices ? SplitText(type, '|') : std::vector<std::string>{};
}

}  // namespace

std::string ManPage(const CLI::App& cli) {
  std::string page =
      fmt::format(".TH {} 1 \"\" \"lake {}\" \"lake\"\n.SH NAME\n{} \\- {}\n", Upper(Troff(cli.get_name())),
                  Troff(VersionAndCommit()), Troff(cli.get_name()), Troff(cli.get_description()));
  page += fmt::format(".SH SYNOPSIS\n\\fB{}\\fR [OPTIONS]", Troff(cli.get_name()));
  for (const CLI::Option* option : cli.get_options())
    if (option->get_positional()) page += fmt::format(" \\fI{}\\fR", Troff(option->get_name(true)));
  page += "\n";
  for (const CLI::App* level : Levels(cli)) {
    const bool is_group = level->get_name().empty();
    const std::string title =
        level == &cli ? "OPTIONS" : Troff(is_group ? level->get_group() : Upper(level->get_name()));
    page += ManSection(*level, title);
  }
  return page + fmt::format(".SH EXAMPLES\n.nf\n{}\n.fi\n", Troff(cli.get_footer()));
}

std::string BashCompletion(const CLI::App& cli) {
  std::vector<std::string> words;
  std::string cases;
  for (const CLI::App* level : Levels(cli)) {
    if (level != &cli && !level->get_name().empty()) words.push_back(level->get_name());
    for (const CLI::Option* option : level->get_options()) {
      if (!IsShown(*option)) continue;
      for (const std::string& name : option->get_lnames()) words.push_back("--" + name);
      const std::vector<std::string> choices = ChoicesOf(*option);
      if (!choices.empty() && !option->get_lnames().empty())
        cases += fmt::format("    --{}) COMPREPLY=($(compgen -W '{}' -- \"$word\")); return ;;\n",
                             option->get_lnames().front(), fmt::join(choices, " "));
    }
  }
  std::string function = "_" + cli.get_name();
  std::replace(function.begin(), function.end(), '-', '_');
  return fmt::format(
      "{0}() {{\n  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}}\n  case $before in\n"
      "{1}  esac\n  if [[ $word == -* ]]; then\n    COMPREPLY=($(compgen -W '{2}' -- \"$word\"))\n"
      "  else\n    COMPREPLY=($(compgen -f -- \"$word\"))\n  fi\n}}\ncomplete -o filenames -F {0} {3}\n",
      function, cases, fmt::join(words, " "), cli.get_name());
}

}  // namespace lake
