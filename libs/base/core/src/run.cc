#include "lake/core/run.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
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
    return {json.at("program"), json.at("command"), {}, {}, {}, {}};
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
    return list.step.empty() && (list.subject.empty() || list.subject == info.subject) && list.files.contains(kSummary);
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
  std::error_code ignored;
  try {
    Abandon();
  } catch (const std::exception&) {  // the last results, or what there is of these, stay where they are
  }
  if (begun_) fs::remove_all(UnfinishedFolder(info_.out, info_.program), ignored);
  if (is_published_ && Results().empty()) fs::remove(ResultsListPath(info_.out, info_.program), ignored);
  if (made_folder_) fs::remove(info_.out, ignored);  // one that holds anything stays
}

std::string Run::SubjectText() const {
  return ResultsList{info_.program, info_.command, info_.subject, {}, {}, {}}.Describe();
}

void Run::TakeFolder() {
  std::error_code error;
  made_folder_ |= fs::create_directories(info_.out, error);
  if (error) throw Fail("{}: the output folder cannot be made: {}", info_.out.string(), error.message());
  if (access(info_.out.c_str(), W_OK | X_OK) != 0)
    throw Fail("{}: the output folder is not writable; choose another with -o", info_.out.string());
  if ((lock_ = FolderLock::Take(info_.out))) return;
  const ResultsList at_work = ReadResultsList(UnfinishedFolder(info_.out, info_.program), info_.program);
  throw Fail("{}: another run is at work there{}; wait for it, or choose another folder with -o", info_.out.string(),
             at_work.program.empty() ? "" : ", " + at_work.Describe());
}

void Run::CheckIsFree(const std::string& name) const {
  const fs::path path = info_.out / name;
  if (files_.contains(name) || old_->files.contains(name) || older_version_ || !fs::exists(fs::symlink_status(path)))
    return;
  throw Fail("{}: is {}, and would be overwritten by one of {}; choose another folder with -o", path.string(),
             OwnerOf(info_.out, name), SubjectText());
}

bool Run::IsReadHere(const std::string& name) const {
  return std::ranges::any_of(inputs_, [&](const Json& input) {
    std::error_code error;
    return fs::equivalent(FromHome(input["path"].get<std::string>()), info_.out / name, error);
  });
}

void Run::TakeOver() {
  TakeFolder();
  old_ = std::make_unique<ResultsList>(ReadResultsList(info_.out, info_.program));
  older_version_ = old_->files.empty() && ReadSummaryHead(info_.out).program == info_.program;
  if (info_.default_folder && old_->subject != info_.subject && !old_->files.empty())
    throw Fail("{}: holds the results of {}; choose another folder for those of {} with -o", info_.out.string(),
               old_->Describe(), SubjectText());
  if (!old_->files.contains(kSummary) && !IsBesideItsStudy(info_)) CheckIsFree(kSummary);
  if (older_version_) {
    old_->files.insert(kSummary);
    old_->is_complete = true;
  }
  // That of a run that was interrupted while it exchanged its results is gone.
  if (old_->files.contains(kSummary)) old_->is_complete &= fs::exists(info_.out / kSummary);
  old_->program = info_.program;
}

void Run::Begin(const std::vector<std::string>& names) {
  if (!begun_) {
    if (!old_) TakeOver();
    for (const std::string& name : names) CheckIsFree(name);
    const fs::path unfinished = UnfinishedFolder(info_.out, info_.program);
    fs::remove_all(unfinished);
    fs::create_directory(unfinished);
    begun_ = true;
    WriteResultsList(unfinished, {info_.program, info_.command, info_.subject, info_.step, {}, {}});
  }
  for (const std::string& name : names) {
    CheckIsFree(name);
    if (files_.insert(name).second && is_published_)
      WriteResultsList(info_.out, {info_.program, info_.command, info_.subject, info_.step, files_, true});
  }
}

fs::path Run::Place() const {
  return is_published_ ? info_.out : UnfinishedFolder(info_.out, info_.program);
}

fs::path Run::FolderIfFailed() const {
  return old_ && old_->is_complete && !old_->files.empty() ? info_.out / kFailedFolder : info_.out;
}

std::vector<std::string> Run::Written() const {
  std::vector<std::string> written;
  for (const std::string& name : files_)
    if (fs::exists(Place() / name)) written.push_back(name);
  return written;
}

// A run that is killed here leaves a list of all files and no summary: an unfinished run's, for whoever reads them.
void Run::Exchange(bool is_complete) {
  const std::vector<std::string> written = Written();
  ResultsList list{info_.program, info_.command, info_.subject, info_.step, old_->files, false};
  list.files.insert(written.begin(), written.end());
  WriteResultsList(info_.out, list);
  const fs::path unfinished = Place();
  is_published_ = true;
  if (old_->files.contains(kSummary)) RemoveResultFiles(info_.out, {kSummary});
  std::erase_if(old_->files, [&](const std::string& name) {
    const bool stays = std::ranges::find(written, name) != written.end() || IsReadHere(name);
    if (stays) files_.insert(name);
    return stays;
  });
  RemoveResultFiles(info_.out, old_->files);
  for (const std::string& name : written)
    if (name != kSummary) MoveResult(unfinished / name, info_.out / name);
  if (std::ranges::find(written, kSummary) != written.end()) MoveResult(unfinished / kSummary, info_.out / kSummary);
  fs::remove_all(unfinished);
  list.files = files_;
  list.is_complete = is_complete;
  WriteResultsList(info_.out, list);
}

// Beside the last run's results. A file of the user's there stays, and the new one is lost.
void Run::SetAside() {
  const auto is_of_failed = [](const std::string& name) { return *fs::path(name).begin() == kFailedFolder; };
  std::set<std::string> last_failed;
  std::ranges::copy_if(old_->files, std::inserter(last_failed, last_failed.end()), is_of_failed);
  RemoveResultFiles(info_.out, last_failed);
  std::erase_if(old_->files, is_of_failed);
  for (const std::string& name : Written()) {
    const std::string aside = fmt::format("{}/{}", kFailedFolder, name);
    if (fs::exists(info_.out / aside)) continue;
    old_->files.insert(aside);
    WriteResultsList(info_.out, *old_);
    MoveResult(Place() / name, info_.out / aside);
  }
  WriteResultsList(info_.out, *old_);
  is_published_ = true;
  files_ = old_->files;
}

void Run::Publish() {
  if (begun_ && !is_published_) Exchange(true);
}

void Run::Abandon() {
  if (!begun_ || is_published_ || Written().empty()) return;
  if (FolderIfFailed() == info_.out)
    Exchange(false);
  else
    SetAside();
}

fs::path Run::Result(const std::string& name) {
  Begin({name});
  const fs::path path = Place() / name;
  std::error_code error;
  fs::create_directories(path.parent_path(), error);
  if (error) throw Fail("{}: the folder cannot be made: {}", path.parent_path().string(), error.message());
  return path;
}

std::vector<fs::path> Run::Results() const {
  std::vector<fs::path> written;
  for (const std::string& name : Written()) written.push_back(Place() / name);
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

Json Run::MakeSummary(const Json& results) const {
  for (const Json& input : inputs_) CheckIsAsItWas(input, info_.out);
  Json summary = Head();
  for (const auto& [name, result] : results.items()) {
    if (summary.contains(name) && name != "warnings")  // a study's are those of its steps, too
      throw std::logic_error(fmt::format("a summary's '{}' is no result's", name));
    summary[name] = result;
  }
  return summary;
}

Json Run::WriteSummary(const Json& results) {
  const Json summary = MakeSummary(results);
  WriteJsonFile(Result(kSummary), summary);
  Publish();
  return summary;
}

void Run::WriteFailedSummary(const Json& results, const std::string& reason) {
  Json summary = MakeSummary(results);
  summary["failed"] = reason;
  WriteJsonFile(Result(kSummary), summary);
  Abandon();
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
    if (list.step == step) {
      RemoveResults(folder, list);
      fs::remove_all(UnfinishedFolder(folder, list.program));
    }
}

}  // namespace lake
