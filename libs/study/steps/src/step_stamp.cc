#include "step_stamp.h"

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"

namespace lake::steps {
namespace {

namespace fs = std::filesystem;

constexpr const char* kStampSuffix = ".lake-step.json";

fs::path StampPath(const fs::path& folder, const std::string& step) {
  return folder / ("." + step + kStampSuffix);
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

}  // namespace

std::optional<StepStamp> ReadStamp(const fs::path& folder, const std::string& step) {
  const fs::path path = StampPath(folder, step);
  if (!fs::is_regular_file(path)) return std::nullopt;
  try {
    const Json json = ReadJsonFile(path);
    return StepStamp{json.at("maker").get<std::string>(), json.at("options"), StatesFrom(json.at("inputs")),
                     OutputsFrom(json.at("outputs"), folder), json.at("seconds").get<double>()};
  } catch (const Error&) {
    return std::nullopt;
  } catch (const Json::exception&) {
    return std::nullopt;
  }
}

void WriteStamp(const fs::path& folder, const std::string& step, const StepStamp& stamp) {
  WriteJsonFile(StampPath(folder, step), {{"step", step},
                                          {"maker", stamp.made_by},
                                          {"seconds", stamp.seconds},
                                          {"options", stamp.options},
                                          {"inputs", StatesJson(stamp.inputs)},
                                          {"outputs", OutputsJson(stamp.outputs, folder)}});
}

void RemoveStamp(const fs::path& folder, const std::string& step) {
  std::error_code ignored;
  fs::remove(StampPath(folder, step), ignored);
}

}  // namespace lake::steps
