#include "lake/core/shell_word.h"

#include <fmt/ranges.h>

#include <string_view>

#include "lake/core/provenance.h"

namespace lake {
namespace {

// No word holds it.
constexpr std::string_view kHome("\0", 1);

std::string WordWithoutHome(const std::string& word) {
  std::vector<std::string> parts(1);  // between the mentions of the home folder
  for (const char c : WithoutHome(word, kHome))
    if (c == kHome.front())
      parts.emplace_back();
    else
      parts.back() += c;
  std::string line = parts.size() > 1 && parts.front().empty() ? "" : ShellWord(parts.front());
  for (std::size_t i = 1; i < parts.size(); ++i) {
    std::string_view part = parts[i];
    const bool begins = line.empty() && (part.empty() || part.front() == '/');
    line += begins ? std::string_view("~") : "\"$HOME\"";  // sh knows ~ at the beginning of a word, before a bare slash
    if (begins && !part.empty()) {
      line += '/';
      part.remove_prefix(1);
    }
    if (!part.empty()) line += ShellWord(std::string(part));
  }
  return line;
}

}  // namespace

std::string ShellWord(const std::string& word) {
  constexpr const char* kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=.,:/@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  return quoted + "'";
}

std::string CommandLine(const std::vector<std::string>& words) {
  std::vector<std::string> quoted;
  for (const std::string& word : words) quoted.push_back(WordWithoutHome(word));
  return fmt::format("{}", fmt::join(quoted, " "));
}

}  // namespace lake
