#include "step_stamp.h"

#include "lake/core/error.h"
#include "lake/core/provenance.h"

namespace lake::steps {
namespace {

namespace fs = std::filesystem;

constexpr const char* kAbsent = "absent";
constexpr const char* kStampSuffix = ".lake-step.json";

fs::path StampPath(const fs::path& folder, const std::string& step) {
  return folder / ("." + step + kStampSuffix);
}

Json FileStateJson(const FileState& state) {
  const FileStamp& stamp = state.stamp;
  return {{"path", state.path.string()},      {"sha256", state.sha256},         {"size", stamp.size},
          {"modified_ns", stamp.modified_ns}, {"changed_ns", stamp.changed_ns}, {"inode", stamp.inode},
          {"seen_ns", stamp.seen_ns}};
}

FileState FileStateFrom(const Json& json) {
  FileState state;
  state.path = json.at("path").get<std::string>();
  state.sha256 = json.at("sha256").get<std::string>();
  FileStamp& stamp = state.stamp;
  stamp.size = json.at("size");
  stamp.inode = json.at("inode");
  stamp.seen_ns = json.at("seen_ns");
  stamp.modified_ns = json.at("modified_ns");
  stamp.changed_ns = json.at("changed_ns");
  return state;
}

Json StatesJson(const std::vector<FileState>& states) {
  Json json = Json::array();
  for (const FileState& state : states) json.push_back(FileStateJson(state));
  return json;
}

// Outputs stand relative to their folder, so that a copied folder knows its own files and no others.
Json OutputsJson(std::vector<FileState> outputs, const fs::path& folder) {
  for (FileState& output : outputs) output.path = output.path.lexically_relative(folder);
  return StatesJson(outputs);
}

std::vector<FileState> StatesFrom(const Json& json) {
  std::vector<FileState> states;
  for (const Json& state : json) states.push_back(FileStateFrom(state));
  return states;
}

std::vector<FileState> OutputsFrom(const Json& json, const fs::path& folder) {
  std::vector<FileState> outputs = StatesFrom(json);
  for (FileState& output : outputs) {
    const fs::path name = output.path.lexically_normal();
    if (name.empty() || name.is_absolute() || *name.begin() == "..")
      throw Fail("{}: an output outside its folder", name.string());
    output.path = folder / name;
  }
  return outputs;
}

// Null where there is none, or none that can be read.
Json ReadFile(const fs::path& path) {
  try {
    return fs::is_regular_file(path) ? ReadJsonFile(path) : Json();
  } catch (const Error&) {
    return {};
  }
}

}  // namespace

bool FileState::IsAbsent() const {
  return sha256 == kAbsent;
}

FileState StateOf(const fs::path& path, const FileState* known) {
  const std::optional<FileStamp> now = FileStamp::Of(path);
  if (!now) return {path, kAbsent, {}};
  if (known && IsUntouched(*now, known->stamp)) return {path, known->sha256, known->stamp};
  return {path, Sha256OfFile(path), *now};
}

std::optional<StepStamp> ReadStamp(const fs::path& folder, const std::string& step) {
  const Json json = ReadFile(StampPath(folder, step));
  if (!json.is_object() || !json.contains("outputs")) return std::nullopt;
  try {
    return StepStamp{.made_by = json.at("maker").get<std::string>(),
                     .options = json.at("options"),
                     .inputs = StatesFrom(json.at("inputs")),
                     .outputs = OutputsFrom(json.at("outputs"), folder),
                     .cost = {json.at("seconds").get<double>(), json.at("memory_mb").get<double>()}};
  } catch (const Error&) {
    return std::nullopt;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

void WriteStamp(const fs::path& folder, const std::string& step, const StepStamp& stamp) {
  WriteJsonFile(StampPath(folder, step), {{"step", step},
                                          {"maker", stamp.made_by},
                                          {"seconds", stamp.cost.seconds},
                                          {"memory_mb", stamp.cost.memory_mb},
                                          {"options", stamp.options},
                                          {"inputs", StatesJson(stamp.inputs)},
                                          {"outputs", OutputsJson(stamp.outputs, folder)}});
}

void WriteFailure(const fs::path& folder, const std::string& step, const std::string& error) {
  std::error_code ignored;
  fs::create_directories(folder, ignored);
  try {
    WriteJsonFile(StampPath(folder, step), {{"step", step}, {"failed", error}});
  } catch (const Error&) {  // as on a full disk: the failure itself is reported
  }
}

std::optional<std::string> ReadFailure(const fs::path& folder, const std::string& step) {
  const Json json = ReadFile(StampPath(folder, step));
  if (!json.is_object() || !json.contains("failed") || !json["failed"].is_string()) return std::nullopt;
  return json["failed"].get<std::string>();
}

void RemoveStamp(const fs::path& folder, const std::string& step) {
  std::error_code ignored;
  fs::remove(StampPath(folder, step), ignored);
}

}  // namespace lake::steps
