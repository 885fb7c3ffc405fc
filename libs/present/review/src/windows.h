// In how many browsers windows show the page: when the last one is closed, the program has done its work.
#pragma once

#include <atomic>
#include <chrono>
#include <memory>

namespace lake::review {

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

}  // namespace lake::review
