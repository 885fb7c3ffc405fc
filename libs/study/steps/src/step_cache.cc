#include "step_cache.h"

#include <algorithm>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/paths.h"
#include "lake/core/provenance.h"

namespace lake::steps {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSummary = "summary.json";

std::string KeyOf(const StudyStep& step, const std::vector<FileState>& inputs, const std::string& made_by) {
  Json all = {{"maker", made_by}, {"step", step.name}, {"options", step.options}, {"inputs", Json::array()}};
  for (const FileState& input : inputs) all["inputs"].push_back(input.sha256);
  return Sha256OfText(all.dump());
}

// Which of the step's inputs each of a summary's is; empty where one is none of them: the entry could not say then
// which file of another study stands in its place.
std::optional<Json> InputPlaces(const Json& summary, const StudyStep& step) {
  Json places = Json::array();
  for (const Json& input : summary["inputs"]) {
    const auto found = std::ranges::find(step.inputs, FromHome(input["path"].get<std::string>()));
    if (found == step.inputs.end()) return std::nullopt;
    places.push_back(found - step.inputs.begin());
  }
  return places;
}

// What the summary says beyond its head.
Json ResultsIn(const Json& summary, const Json& head) {
  Json results = Json::object();
  for (const auto& [name, value] : summary.items())
    if (!head.contains(name)) results[name] = value;
  return results;
}

// nullopt for one that is not as it was stored.
std::optional<Json> ReadEntry(const fs::path& path) {
  if (!fs::is_regular_file(path)) return std::nullopt;
  const std::string text = ReadTextFile(path);
  const std::size_t line = text.find('\n');
  if (line == std::string::npos || Sha256OfText(std::string_view(text).substr(line + 1)) != text.substr(0, line))
    return std::nullopt;
  return Json::from_cbor(text.begin() + static_cast<std::ptrdiff_t>(line) + 1, text.end());
}

}  // namespace

fs::path CacheEntry::PathIn(const fs::path& folder, const StudyStep& step, const std::vector<FileState>& inputs,
                            const std::string& made_by) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) throw Fail("LAKE_CACHE: {}: the folder cannot be made: {}", folder.string(), error.message());
  return folder / KeyOf(step, inputs, made_by);
}

CacheEntry::CacheEntry(const fs::path& folder, const StudyStep& step, const std::vector<FileState>& inputs,
                       const std::string& made_by)
    : step_(step), path_(PathIn(folder, step, inputs, made_by)), lock_(path_.string() + ".lock") {}

bool CacheEntry::Restore(Run& run) const {
  const std::optional<Json> entry = ReadEntry(path_);
  if (!entry) return false;
  for (const Json& place : (*entry)["inputs"]) run.AddInput(step_.inputs.at(place.get<std::size_t>()));
  for (const Json& warning : (*entry)["warnings"]) run.Warn(warning.get<std::string>());
  for (const auto& [name, content] : (*entry)["files"].items()) {
    if (!LiesIn(run.Folder() / name, run.Folder()))
      throw Fail("{}: '{}' lies outside its folder", path_.string(), name);
    const auto& bytes = content.get_binary();
    WriteTextFile(run.Result(name), {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  }
  run.WriteSummary((*entry)["results"]);
  return true;
}

void CacheEntry::Store(const Run& run) const {
  const Json summary = ReadJsonFile(run.Folder() / kSummary);
  const std::optional<Json> inputs = InputPlaces(summary, step_);
  if (!inputs) return;
  Json entry = {{"inputs", *inputs},
                {"warnings", summary["warnings"]},
                {"results", ResultsIn(summary, run.Head())},
                {"files", Json::object()}};
  for (const fs::path& path : run.Results()) {
    const std::string name = path.lexically_relative(run.Folder()).string();
    if (name == kSummary) continue;
    const std::string content = ReadTextFile(path);
    entry["files"][name] = Json::binary(std::vector<std::uint8_t>(content.begin(), content.end()));
  }
  const std::vector<std::uint8_t> packed = Json::to_cbor(entry);
  const std::string body(packed.begin(), packed.end());
  WriteTextFile(path_, Sha256OfText(body) + "\n" + body);
}

}  // namespace lake::steps
