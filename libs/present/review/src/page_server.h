// The page's own files, its windows and its messages, whatever it shows.
#pragma once

#include <functional>
#include <string>

#include "lake/core/json.h"
#include "lake/review/local_server.h"
#include "lake/review/page_options.h"
#include "windows.h"

namespace lake::review {

class PageServer {
 public:
  // `state` is what the page asks for all the time; its `mode` says what is shown. Throws Error where the port is
  // taken.
  PageServer(const PageOptions& options, std::function<Json()> state);

  void Get(const std::string& path, std::function<Json()> answer);
  void Post(const std::string& path, std::function<Json(const Json& message)> answer);
  // What is no message: pictures, tables.
  void GetOther(const std::string& path, LocalServer::Handler handler) { server_.Get(path, std::move(handler)); }

  // Until the last window is closed and nothing is under way. Throws Interrupted once a signal has arrived.
  void Serve(const std::function<bool()>& is_busy);

  // Until the work is done and no window is open, whether one ever was or not. Throws as Serve().
  void ServeUntil(const std::function<bool()>& is_done);

 private:
  const PageOptions& options_;
  Windows windows_;
  LocalServer server_;
};

// FRAME.jpg. Throws Error for another text.
std::int64_t FrameNumber(std::string text);

}  // namespace lake::review
