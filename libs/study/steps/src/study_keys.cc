#include "lake/steps/study_keys.h"

#include <fmt/ranges.h>

#include <cctype>
#include <optional>

#include "lake/core/csv.h"

namespace lake::steps {
namespace {

// The word that stands at a place, where it is a value: a number or NAME=….
std::optional<std::string> ValueAt(const std::string& message, std::size_t begin) {
  std::string word = message.substr(begin, message.find_first_of(" )", begin) - begin);
  word.erase(word.find_last_not_of(",;:.") + 1);
  if (ParseNumber(word)) return word;
  return word.find('=') == std::string::npos ? std::nullopt : std::optional(fmt::format("\"{}\"", word));
}

// The key, with the values that the message gives; empty where it does not name the option.
std::string Line(const std::string& message, const StudyKey& key) {
  const std::string name = "--" + key.option;
  bool is_named = false;
  std::vector<std::string> values;
  for (std::size_t at = message.find(name); at != std::string::npos; at = message.find(name, at + 1)) {
    const std::size_t end = at + name.size();
    if (end < message.size() && (std::isalnum(static_cast<unsigned char>(message[end])) || message[end] == '-'))
      continue;
    is_named = true;
    if (end == message.size()) continue;
    if (const auto value = ValueAt(message, end + 1)) values.push_back(*value);
  }
  if (!is_named || values.empty()) return is_named ? key.key : "";
  return key.is_list ? fmt::format("{}: [{}]", key.key, fmt::join(values, ", "))
                     : fmt::format("{}: {}", key.key, values.front());
}

}  // namespace

std::vector<StudyKey> KeysOf(const OptionList& options) {
  std::vector<StudyKey> keys;
  for (const Option& option : options.All())
    if (!option.IsOperand()) keys.push_back({option.Name(), option.Key(), option.IsRepeated()});
  return keys;
}

std::string InStudyFile(const std::string& message, const std::vector<StudyKey>& keys) {
  std::vector<std::string> lines;
  for (const StudyKey& key : keys)
    if (std::string line = Line(message, key); !line.empty()) lines.push_back(std::move(line));
  return lines.empty() ? "" : fmt::format(" (in the study file: {})", fmt::join(lines, ", "));
}

}  // namespace lake::steps
