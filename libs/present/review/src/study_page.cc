#include "lake/review/study_page.h"

#include <mutex>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "page_server.h"

namespace lake::review {
namespace {

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
