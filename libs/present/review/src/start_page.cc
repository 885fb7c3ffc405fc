#include "lake/review/start_page.h"

#include "page_server.h"

namespace lake::review {

void ServeStart(const PageOptions& options, const StartWork& work) {
  BackgroundJob making;
  const auto state = [&making] { return Json{{"mode", "start"}, {"job", making.State()}}; };
  PageServer page(options, state);
  page.Get("start", [&work] { return Json{{"folder", work.folder}, {"found", work.found()}}; });
  page.Post("open", [&work](const Json& message) { return Json{{"address", work.open(message.at("path"))}}; });
  page.Post("make", [&](const Json& asked) {
    making.Start([&work, asked](const BackgroundJob::Control& control) { work.make(asked, control); });
    return state();
  });
  page.Post("stop", [&](const Json&) {
    making.Stop();
    return state();
  });
  page.Serve([&] { return making.IsRunning() || work.has_open_pages(); });
}

}  // namespace lake::review
