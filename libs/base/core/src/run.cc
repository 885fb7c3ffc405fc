#include "lake/core/run.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <stdexcept>

#include "folder_lock.h"
#include "lake/core/error.h"
#include "lake/core/paths.h"
#include "lake/core/provenance.h"
#include "results_list.h"

namespace lake {
namespace fs = std::filesystem;
namespace {

// Program named in the summary; empty if absent.
ResultsList ReadSummaryHead(const fs::path& folder) {
  try {
    const Json json = ReadJsonFile(folder / kSummary);
    return {json.at("program"), json.at("command"), {}, {}, {}};
  } catch (const std::exception&) {
    return {};
  }
}

// Whose file it is, for messages.
std::string OwnerOf(const fs::path& folder, const std::string& name) {
  for (const ResultsList& list : ResultsListsIn(folder))
    if (list.files.contains(name)) return "a result of " + list.Describe();
  const ResultsList made = ReadSummaryHead(folder);
  return name == kSummary && !made.program.empty() ? "a result of " + made.Describe() : "not a result of lake's";
}

// Whether a folder holds the summary of the study that this step is of: a step that lies there, its report, leaves it
// alone.
bool IsBesideItsStudy(const Run::Info& info) {
  return !info.step.empty() && std::ranges::any_of(ResultsListsIn(info.out), [&](const ResultsList& list) {
    return list.step.empty() && list.subject == info.subject && list.files.contains(kSummary);
  });
}

// In every text that it holds.
Json TextsWithoutHome(Json json) {
  if (json.is_string()) return WithoutHome(json.get<std::string>());
  if (json.is_structured())
    for (Json& value : json) value = TextsWithoutHome(std::move(value));
  return json;
}

// As a summary names it: FromHome() finds it again, also where "~" is the name of a folder.
std::string NameOf(const fs::path& path) {
  const fs::path plain = path.string().starts_with('~') ? fs::path(".") / path : path;
  std::string name = WithoutHome(plain.string());
  return FromHome(name) == plain ? name : plain.string();
}

// A run may replace what it reads in its own folder; all else must be at its end what it was when it was added.
void CheckIsAsItWas(const Json& input, const fs::path& out) {
  const fs::path path = FromHome(input.at("path").get<std::string>());
  if (LiesIn(path, out)) return;
  if (!fs::exists(path) || Sha256OfFile(path) != input.at("sha256").get<std::string>())
    throw Fail("{}: changed while it was read; do it again", path.string());
}

}  // namespace

Run::Run(Info info) : info_(std::move(info)) {
  info_.command = WithoutHome(info_.command);
  info_.options = TextsWithoutHome(std::move(info_.options));
  for (std::string& file : info_.subject) file = WithoutHome(file);
}

Run::~Run() {
  std::error_code ignored;  // a folder that holds anything stays
  if (begun_ && Results().empty()) fs::remove(ResultsListPath(info_.out, info_.program), ignored);
  if (made_folder_) fs::remove(info_.out, ignored);
}

std::string Run::SubjectText() const {
  return ResultsList{info_.program, info_.command, info_.subject, {}, {}}.Describe();
}

void Run::TakeFolder() {
  std::error_code error;
  made_folder_ |= fs::create_directories(info_.out, error);
  if (error) throw Fail("{}: the output folder cannot be made: {}", info_.out.string(), error.message());
  if (access(info_.out.c_str(), W_OK | X_OK) != 0)
    throw Fail("{}: the output folder is not writable; choose another with -o", info_.out.string());
  if ((lock_ = FolderLock::Take(info_.out))) return;
  const ResultsList at_work = ReadResultsList(info_.out, info_.program);
  throw Fail("{}: another run is at work there{}; wait for it, or choose another folder with -o", info_.out.string(),
             at_work.program.empty() ? "" : ", " + at_work.Describe());
}

void Run::CheckIsFree(const std::string& name) const {
  const fs::path path = info_.out / name;
  if (files_.contains(name) || older_version_ || !fs::exists(fs::symlink_status(path))) return;
  throw Fail("{}: is {}, and would be overwritten by one of {}; choose another folder with -o", path.string(),
             OwnerOf(info_.out, name), SubjectText());
}

void Run::Retire(ResultsList old) {
  if (info_.default_folder && old.subject != info_.subject && !old.files.empty())
    throw Fail("{}: holds the results of {}; choose another folder for those of {} with -o", info_.out.string(),
               old.Describe(), SubjectText());
  if (!old.files.contains(kSummary) && !IsBesideItsStudy(info_)) CheckIsFree(kSummary);
  // What this run reads stays until its own result takes the place.
  for (const Json& input : inputs_)
    std::erase_if(old.files, [&](const std::string& name) {
      std::error_code error;
      const bool is_read = fs::equivalent(FromHome(input["path"].get<std::string>()), info_.out / name, error);
      if (is_read) files_.insert(name);
      return is_read;
    });
  if (older_version_) old.files.insert(kSummary);
  old.program = info_.program;
  RemoveResults(info_.out, old);
}

void Run::WriteList() const {
  WriteResultsList(info_.out, {info_.program, info_.command, info_.subject, info_.step, files_});
}

void Run::Begin(const std::vector<std::string>& names) {
  bool is_new = !begun_;
  if (!begun_) {
    TakeFolder();
    const ResultsList old = ReadResultsList(info_.out, info_.program);
    const std::string owner = ReadSummaryHead(info_.out).program;
    older_version_ = old.files.empty() && owner == info_.program;
    for (const std::string& name : names)
      if (!old.files.contains(name)) CheckIsFree(name);
    Retire(old);
    begun_ = true;
  }
  for (const std::string& name : names) {
    CheckIsFree(name);
    is_new |= files_.insert(name).second;
  }
  if (is_new) WriteList();
}

fs::path Run::Result(const std::string& name) {
  Begin({name});
  const fs::path path = info_.out / name;
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (error) throw Fail("{}: the folder cannot be made: {}", path.parent_path().string(), error.message());
  return path;
}

std::vector<fs::path> Run::Results() const {
  std::vector<fs::path> written;
  for (const std::string& name : files_)
    if (fs::exists(info_.out / name)) written.push_back(info_.out / name);
  return written;
}

void Run::Warn(const std::string& text) {
  warnings_.push_back(text);
  fmt::print(stderr, "{}: warning: {}{}\n", info_.program, info_.step.empty() ? "" : info_.step + ": ", text);
}

void Run::AddInput(const fs::path& path, const std::string& role) {
  inputs_.push_back({{"path", NameOf(path)}, {"sha256", Sha256OfFile(path)}, {"role", role}});
}

void Run::AddInputs(const std::vector<InputFile>& inputs) {
  bool has_one = false;
  for (const InputFile& input : inputs) {
    if (input.is_alternative && has_one) continue;
    has_one = fs::exists(input.path);
    if (has_one) AddInput(input.path, input.role);
  }
}

Json Run::Head() const {
  return {{"program", info_.program}, {"version", Version()},     {"commit", Commit()},
          {"tree", SourceTree()},     {"command", info_.command}, {"options", info_.options},
          {"given", info_.given},     {"inputs", inputs_},        {"warnings", warnings_}};
}

Json Run::WriteSummary(const Json& results) {
  for (const Json& input : inputs_) CheckIsAsItWas(input, info_.out);
  Json summary = Head();
  for (const auto& [name, result] : results.items()) {
    if (summary.contains(name) && name != "warnings")  // a study's are those of its steps, too
      throw std::logic_error(fmt::format("a summary's '{}' is no result's", name));
    summary[name] = result;
  }
  WriteJsonFile(Result(kSummary), summary);
  return summary;
}

std::optional<fs::path> FindResult(const fs::path& folder, const std::string& name) {
  const fs::path path = folder / name;
  if (!fs::is_regular_file(path)) return std::nullopt;
  const std::vector<ResultsList> lists = ResultsListsIn(folder);
  for (const ResultsList& list : lists) {
    if (!list.files.contains(name)) continue;
    if (!fs::is_regular_file(folder / kSummary))
      throw Fail("{}: the run of {} that left it did not finish; do it again", path.string(), list.Describe());
    return path;
  }
  if (lists.empty()) return path;
  throw Fail("{}: does not belong to the results of {} beside it; move it to a folder of its own", path.string(),
             lists.front().Describe());
}

std::vector<std::string> ResultsIn(const fs::path& folder) {
  std::vector<std::string> names;
  for (const ResultsList& list : ResultsListsIn(folder))
    for (const std::string& name : list.files)
      if (fs::is_regular_file(folder / name)) names.push_back(name);
  return names;
}

void RetireStep(const fs::path& folder, const std::string& step) {
  if (!fs::is_directory(folder)) return;
  const auto lock = FolderLock::Take(folder);
  if (!lock) throw Fail("{}: another run is at work there; wait for it", folder.string());
  for (const ResultsList& list : ResultsListsIn(folder))
    if (list.step == step) RemoveResults(folder, list);
}

}  // namespace lake
