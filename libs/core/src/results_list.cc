#include "results_list.h"

#include "lake/core/error.h"
#include "lake/core/json.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSuffix = ".lake-files.json";
constexpr const char* kSummary = "summary.json";

bool IsInside(const std::string& name) {
  const fs::path path = fs::path(name).lexically_normal();
  return !path.empty() && path.is_relative() && *path.begin() != ".." && *path.begin() != ".";
}

ResultsList ReadList(const fs::path& path) {
  if (!fs::is_regular_file(path)) return {};
  try {
    const Json json = ReadJsonFile(path);
    ResultsList list{json.at("program"), json.at("command"), json.at("subject"), json.at("step"), {}};
    for (const std::string file : json.at("files"))
      if (IsInside(file)) list.files.insert(file);
    return list;
  } catch (const Error&) {
    return {};
  } catch (const Json::exception&) {
    return {};
  }
}

void RemoveFile(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(fs::symlink_status(path, error))) return;
  fs::remove(path, error);
  if (error) throw Fail("{}: an earlier result cannot be removed: {}", path.string(), error.message());
}

}  // namespace

std::string ResultsList::Describe() const {
  return subject.empty() ? fmt::format("{} (`{}`)", program, command)
                         : fmt::format("{} ({})", program, fmt::join(subject, ", "));
}

fs::path ResultsListPath(const fs::path& folder, const std::string& program) {
  return folder / ("." + program + kSuffix);
}

ResultsList ReadResultsList(const fs::path& folder, const std::string& program) {
  return ReadList(ResultsListPath(folder, program));
}

std::vector<ResultsList> ResultsListsIn(const fs::path& folder) {
  std::vector<ResultsList> lists;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (const std::string name = entry.path().filename().string(); name.starts_with('.') && name.ends_with(kSuffix))
      if (ResultsList list = ReadList(entry.path()); !list.program.empty()) lists.push_back(std::move(list));
  return lists;
}

void WriteResultsList(const fs::path& folder, const ResultsList& list) {
  WriteJsonFile(ResultsListPath(folder, list.program), {{"program", list.program},
                                                        {"command", list.command},
                                                        {"subject", list.subject},
                                                        {"step", list.step},
                                                        {"files", list.files}});
}

void RemoveResults(const fs::path& folder, const ResultsList& list) {
  if (list.files.contains(kSummary)) RemoveFile(folder / kSummary);
  std::set<fs::path> folders;
  for (const std::string& name : list.files) {
    RemoveFile(folder / name);
    for (fs::path parent = fs::path(name).parent_path(); !parent.empty(); parent = parent.parent_path())
      folders.insert(parent);
  }
  std::error_code not_empty;
  for (auto sub = folders.rbegin(); sub != folders.rend(); ++sub) fs::remove(folder / *sub, not_empty);
  RemoveFile(ResultsListPath(folder, list.program));
}

}  // namespace lake
