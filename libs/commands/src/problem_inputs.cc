#include "problem_inputs.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "lake/core/error.h"

namespace lake::commands {
namespace {

namespace fs = std::filesystem;

// The file that an option's text names, and what follows it: a path, or an actuator of a table (FILE.csv:NAME).
std::pair<std::string, std::string> FileAndRest(const Option& option, const std::string& text) {
  if (option.PathKind() != Option::Path::kNone) return {text, ""};
  const std::size_t table = text.rfind(".csv:");
  if (table == std::string::npos) return {"", text};
  return {text.substr(0, table + 4), text.substr(table + 4)};
}

}  // namespace

void AddLoadFiles(const problem::SynthesisProblem& problem, std::vector<InputFile>& inputs) {
  if (problem.profile) inputs.push_back({problem.profile->file, "profile"});
  if (problem.actuator && !problem.actuator->file.empty()) inputs.push_back({problem.actuator->file, "actuator"});
}

fs::path TakeFromDesign(const Json& texts, const fs::path& file, OptionList options) {
  std::vector<std::pair<Option*, std::string>> taken;
  for (const auto& item : texts.items()) {
    const std::string& key = item.key();
    const auto option = std::ranges::find_if(options.All(), [&](const Option& o) { return o.Key() == key; });
    if (option == options.All().end()) throw Fail("{}: unknown key '{}'", file.string(), key);
    auto [named, rest] = FileAndRest(*option, item.value().get<std::string>());
    if (!named.empty()) named = (file.parent_path() / named).lexically_normal().string();
    if (!named.empty() && !fs::exists(named)) return named;
    taken.emplace_back(&*option, named + rest);
  }
  try {
    for (auto& [option, text] : taken) option->SetFromFile({text});
  } catch (const Error& error) {
    throw Fail("{}: {}", file.string(), error.what());
  }
  return {};
}

}  // namespace lake::commands
