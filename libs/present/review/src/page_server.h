// The page's own files, its windows and its messages, whatever it shows.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "lake/core/json.h"
#include "lake/review/local_server.h"
#include "lake/review/page_options.h"

namespace lake::review {

// In how many browsers windows show the page: when the last one is closed, the program has done its work.
class Windows {
 public:
  // Windows of one browser are open as long as what this returns lives, at most as long as this object.
  std::shared_ptr<void> Open() {
    ++open_;
    had_any_ = true;
    return {this, [](Windows* windows) { windows->Close(); }};
  }

  bool NoneOpen() const {
    return open_ == 0 && Clock::now().time_since_epoch() - Clock::duration(last_closed_) > kReload;
  }

  bool AllClosed() const { return had_any_ && NoneOpen(); }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::seconds kReload{3};  // a page that is loaded again closes before it opens

  void Close() {
    last_closed_ = Clock::now().time_since_epoch().count();
    --open_;
  }

  std::atomic<int> open_ = 0;
  std::atomic<bool> had_any_ = false;
  std::atomic<Clock::rep> last_closed_ = 0;
};

class PageServer {
 public:
  // `state` is what the page asks for all the time; its `mode` says what is shown. Throws Error where the port is
  // taken.
  PageServer(const PageOptions& options, std::function<Json()> state);

  // The state with a `number` that grows: a page drops an answer that a newer one has overtaken.
  Json State();
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
  std::mutex mutex_;
  std::function<Json()> state_;
  std::int64_t states_ = 0;
  Windows windows_;
  LocalServer server_;
};

// FRAME.jpg. Throws Error for another text.
std::int64_t FrameNumber(std::string text);

}  // namespace lake::review
