#include "lake/review/study_page.h"

#include <algorithm>
#include <cctype>
#include <mutex>
#include <string_view>
#include <utility>
#include <vector>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "page_server.h"

namespace lake::review {
namespace {

std::string TypeOf(const std::filesystem::path& path) {
  constexpr std::pair<std::string_view, const char*> kTypes[] = {{".html", "text/html; charset=utf-8"},
                                                                 {".png", "image/png"},
                                                                 {".svg", "image/svg+xml"},
                                                                 {".gif", "image/gif"},
                                                                 {".mp4", "video/mp4"},
                                                                 {".json", "application/json"}};
  for (const auto& [ending, type] : kTypes)
    if (path.extension() == ending) return type;
  return "text/plain; charset=utf-8";
}

bool IsPlain(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' || c == '.';
}

// Names are of lake's own files; what else lies there is not shown under a name that a browser would misread.
std::string ListOf(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (const std::string name = entry.path().filename().string(); std::ranges::all_of(name, IsPlain) && name[0] != '.')
      names.push_back(name + (entry.is_directory() ? "/" : ""));
  std::ranges::sort(names);
  std::string html = fmt::format(
      "<!DOCTYPE html><meta charset=\"utf-8\"><meta name=\"color-scheme\" content=\"light dark\">"
      "<title>{0}</title><h1>{0}</h1><ul>",
      folder.filename().string());
  for (const std::string& name : names) html += fmt::format("<li><a href=\"{0}\">{0}</a></li>", name);
  return html + "</ul>";
}

class StudyServer {
 public:
  StudyServer(const PageOptions& options, const StudyWork& work)
      : work_(work), page_(options, [this] { return State(); }) {
    page_.Get("study", [this] { return Study(); });
    page_.Post("run", [this](const Json& message) { return RunStep(message.at("step")); });
    page_.Post("stop", [this](const Json&) {
      running_.Stop();
      return State();
    });
    page_.GetOther("report", [this](const LocalRequest&) {
      return LocalReply{.type = "text/html; charset=utf-8", .body = ReadTextFile(work_.report), .is_framed = true};
    });
    page_.GetOther("results/", [this](const LocalRequest& request) { return ResultReply(request.rest); });
  }

  void Serve() {
    page_.Serve([this] { return running_.IsRunning(); });
  }

 private:
  Json Study() const {
    const Json plan = work_.plan();
    Json steps = Json::array();
    for (const Json& step : plan.at("steps"))
      steps.push_back({{"name", step.at("name")},
                       {"what", step.at("what")},
                       {"program", step.at("program")},
                       {"after", step.at("after")},
                       {"due", step.at("due")}});
    return {{"name", work_.name},
            {"command", work_.command},
            {"report", work_.report.string()},
            {"steps", steps},
            {"has_report", std::filesystem::exists(work_.report)}};
  }

  // A file of the results, or the list of a folder's. Nothing outside them.
  LocalReply ResultReply(const std::string& name) const {
    namespace fs = std::filesystem;
    const fs::path root = fs::weakly_canonical(work_.folder), path = fs::weakly_canonical(root / name);
    if (std::ranges::mismatch(root, path).in1 != root.end() || !fs::exists(path))
      throw Fail("'{}' is not one of the results", name);
    if (!fs::is_directory(path))
      return {.type = TypeOf(path), .body = ReadTextFile(path), .is_framed = path.extension() == ".html"};
    return {.type = "text/html; charset=utf-8", .body = ListOf(path)};
  }

  Json State() const {
    Json state = {{"mode", "study"}, {"job", running_.State()}};
    const std::lock_guard lock(mutex_);
    state["step"] = step_;
    return state;
  }

  Json RunStep(const std::string& step) {
    {
      const std::lock_guard lock(mutex_);
      if (running_.IsRunning()) throw Fail("{} is under way", step_.empty() ? "the study" : step_);
      running_.Start([this, step](const BackgroundJob::Control& control) { work_.run(step, control); });
      step_ = step;
    }
    return State();
  }

  const StudyWork& work_;
  mutable std::mutex mutex_;
  std::string step_;  // that is under way, or was the last
  BackgroundJob running_;
  PageServer page_;
};

}  // namespace

void ServeStudy(const PageOptions& options, const StudyWork& work) {
  StudyServer(options, work).Serve();
}

}  // namespace lake::review
