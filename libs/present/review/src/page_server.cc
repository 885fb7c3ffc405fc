#include "page_server.h"

#include <charconv>
#include <utility>

#include "lake/core/error.h"
#include "page_files.h"

namespace lake::review {
namespace {

LocalReply JsonReply(const Json& message) {
  return {"application/json", message.dump(-1, ' ', false, Json::error_handler_t::replace)};
}

LocalServer::Handler File(const std::string& type, std::string text) {
  return [type, text = std::move(text)](const LocalRequest&) { return LocalReply{type, text}; };
}

}  // namespace

PageServer::PageServer(const PageOptions& options, std::function<Json()> state)
    : options_(options), state_(std::move(state)), server_(options.port, options.listen) {
  server_.Get("", File("text/html; charset=utf-8", std::string(PageHtml())));
  server_.Get("review.css", File("text/css; charset=utf-8", std::string(PageStyle())));
  server_.Get("review.js",
              File("text/javascript; charset=utf-8", fmt::format("/*!\n{}*/\n{}", ChartLicence(), PageScript())));
  server_.Get("windows.js", File("text/javascript; charset=utf-8", "const open = new EventSource('window');\n"));
  server_.GetHeld("window", [this] { return windows_.Open(); });
  Get("state", [this] { return State(); });
}

Json PageServer::State() {
  const std::lock_guard lock(mutex_);
  Json state = state_();
  state["number"] = ++states_;
  return state;
}

void PageServer::Get(const std::string& path, std::function<Json()> answer) {
  server_.Get(path, [answer = std::move(answer)](const LocalRequest&) { return JsonReply(answer()); });
}

void PageServer::Post(const std::string& path, std::function<Json(const Json& message)> answer) {
  server_.Post(path, [answer = std::move(answer)](const LocalRequest& request) {
    return JsonReply(answer(Json::parse(request.body)));
  });
}

void PageServer::Serve(const std::function<bool()>& is_busy) {
  if (options_.ready) options_.ready(server_.Address());
  server_.Serve([&] { return windows_.AllClosed() && !is_busy(); });
}

void PageServer::ServeUntil(const std::function<bool()>& is_done) {
  if (options_.ready) options_.ready(server_.Address());
  server_.Serve([&] { return is_done() && windows_.NoneOpen(); });
}

std::int64_t FrameNumber(std::string text) {
  constexpr std::string_view kEnding = ".jpg";
  std::int64_t number = -1;
  if (text.ends_with(kEnding)) text.resize(text.size() - kEnding.size());
  const char* end = text.data() + text.size();
  const auto [last, problem] = std::from_chars(text.data(), end, number);
  if (problem != std::errc() || last != end || number < 0) throw Fail("'{}' is not the number of a frame", text);
  return number;
}

}  // namespace lake::review
