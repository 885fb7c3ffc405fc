#include "lake/core/option_template.h"

#include <fmt/ranges.h>

#include <algorithm>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"

namespace lake {
namespace {

// A scalar that YAML reads back as this text.
std::string Scalar(const std::string& text) {
  const bool is_plain = !text.empty() && text.find_first_of(":#,[]{}&*!|>'\"%@`?") == std::string::npos &&
                        text.front() != '-' && text.front() != ' ' && text.back() != ' ';
  return is_plain ? text : fmt::format("'{}'", text);
}

std::string ValueOf(const Option& option) {
  const std::string text = option.Text();
  if (text.empty()) return "";
  const OptionTexts parts = option.Split({text});
  if (!option.IsRepeated() && parts.size() < 2) return Scalar(text);
  OptionTexts scalars;
  for (const std::string& part : parts) scalars.push_back(Scalar(part));
  return fmt::format("[{}]", fmt::join(scalars, ", "));
}

std::string MeaningOf(const Option& option) {
  const bool says_values =
      option.Value().find('|') != std::string::npos || option.Value().find('=') != std::string::npos;
  return says_values ? fmt::format("{}: {}", option.Value(), option.Help()) : option.Help();
}

}  // namespace

std::string TemplateLine(std::string_view key, std::string_view value, std::string_view meaning, int indent) {
  constexpr int kMeaningColumn = 44;
  const std::string entry = fmt::format("{:{}}{}:{}{}", "", indent, key, value.empty() ? "" : " ", value);
  return fmt::format("{:<{}} # {}\n", entry, kMeaningColumn, meaning);
}

std::string OptionTemplate(const OptionList& options, int indent) {
  std::string text;
  for (const Option& option : options.All())
    text += TemplateLine(option.Key(), ValueOf(option), MeaningOf(option), indent);
  return text;
}

std::string AsComment(std::string_view text, int indent) {
  std::string commented;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size()),
                      column = begin + static_cast<std::size_t>(indent);
    commented += fmt::format("{}#{}\n", text.substr(begin, column - begin), text.substr(column, end - column));
    begin = end + 1;
  }
  return commented;
}

void WriteTemplateFile(const std::filesystem::path& path, std::string_view text) {
  if (std::filesystem::exists(path)) throw Fail("{}: is there already; give --template another name", path.string());
  WriteTextFile(path, text);
}

}  // namespace lake
