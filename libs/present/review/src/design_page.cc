#include "lake/review/design_page.h"

#include <mutex>
#include <utility>

#include "lake/core/error.h"
#include "page_server.h"

namespace lake::review {
namespace {

class DesignServer {
 public:
  DesignServer(const PageOptions& options, ExploredDesign explored, const DesignWork& work)
      : explorer_(std::move(explored)), work_(work), page_(options, [this] { return State(); }) {
    page_.Get("design", [this] { return explorer_.About(); });
    page_.Post("explore", [this](const Json& question) { return explorer_.Explore(question); });
    page_.Post("save", [this](const Json& message) { return Save(LinksFrom(message.at("links"))); });
    page_.Post("optimise-command", [this](const Json& message) { return Command(LinksFrom(message.at("links"))); });
    page_.Post("optimise", [this](const Json& message) { return Optimise(LinksFrom(message.at("links"))); });
    page_.Post("stop", [this](const Json&) {
      optimising_.Stop();
      return page_.State();
    });
  }

  void Serve() {
    page_.Serve([this] { return optimising_.IsRunning(); });
  }

 private:
  Json State() const {
    Json state = {{"mode", "design"}, {"job", optimising_.State()}};
    const std::lock_guard lock(mutex_);
    state["optimum"] = optimum_;
    return state;
  }

  Json Save(const linkage::Links& links) {
    const linkage::Design design = explorer_.With(links);
    const std::lock_guard one_at_a_time(saving_);
    return {{"saved", work_.save(design).string()}};
  }

  // That there is no such command line is an answer too.
  Json Command(const linkage::Links& links) const {
    try {
      return {{"command", work_.command(links)}};
    } catch (const Error& error) {
      return {{"why_not", error.what()}};
    }
  }

  Json Optimise(const linkage::Links& links) {
    work_.command(links);  // says what cannot be
    optimising_.Start([this, links](const BackgroundJob::Control& control) {
      const linkage::Design design = work_.optimise(links, control);
      const std::lock_guard lock(mutex_);
      optimum_ = {{"number", ++optima_}, {"links", design.links.Values()}};
    });
    return page_.State();
  }

  DesignExplorer explorer_;
  const DesignWork& work_;
  mutable std::mutex mutex_;
  std::mutex saving_;
  int optima_ = 0;
  Json optimum_;  // the last one
  BackgroundJob optimising_;
  PageServer page_;
};

}  // namespace

void ServeDesign(const PageOptions& options, ExploredDesign explored, const DesignWork& work) {
  DesignServer(options, std::move(explored), work).Serve();
}

}  // namespace lake::review
