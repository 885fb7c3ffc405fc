#include "lake/review/start_page.h"

#include "lake/core/atomic_file.h"
#include "page_server.h"

namespace lake::review {
namespace {

void AddOthers(const OtherPages& pages, PageServer& page) {
  page.Post("open", [&pages](const Json& message) { return Json{{"address", pages.open(message.at("path"))}}; });
}

}  // namespace

void ServeStart(const PageOptions& options, const StartWork& work) {
  BackgroundJob making;
  const auto state = [&making] { return Json{{"mode", "start"}, {"job", making.State()}}; };
  PageServer page(options, state);
  page.Get("start", [&work] { return Json{{"folder", work.folder}, {"found", work.found()}}; });
  AddOthers(work.pages, page);
  page.Post("make", [&](const Json& asked) {
    making.Start([&work, asked](const BackgroundJob::Control& control) { work.make(asked, control); });
    return state();
  });
  page.Post("stop", [&](const Json&) {
    making.Stop();
    return state();
  });
  page.Serve([&] { return making.IsRunning() || work.pages.are_open(); });
}

void ServeStudy(const PageOptions& options, const StudyWork& work) {
  PageServer page(options, [] { return Json{{"mode", "study"}}; });
  page.Get("study", [&work] {
    return Json{{"name", work.name},
                {"command", work.command},
                {"report", work.report.string()},
                {"has_report", std::filesystem::exists(work.report)},
                {"parts", work.parts}};
  });
  page.GetOther("report", [&work](const LocalRequest&) {
    return LocalReply{.type = "text/html; charset=utf-8", .body = ReadTextFile(work.report), .is_framed = true};
  });
  AddOthers(work.pages, page);
  page.Serve(work.pages.are_open);
}

}  // namespace lake::review
