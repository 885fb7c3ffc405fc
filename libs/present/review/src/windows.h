// Which windows show the page: when the last one is closed, the program has done its work.
#pragma once

#include <chrono>
#include <mutex>
#include <set>
#include <string>

namespace lake::review {

class Windows {
 public:
  void Opened(const std::string& id) {
    const std::lock_guard lock(mutex_);
    if (gone_.contains(id) || open_.size() >= kMost) return;
    open_.insert(id);
    had_any_ = true;
  }

  void Closed(const std::string& id) {
    const std::lock_guard lock(mutex_);
    open_.erase(id);
    if (gone_.size() < kMost) gone_.insert(id);  // a question of its may still be on its way
    last_closed_ = Clock::now();
  }

  bool NoneOpen() const {
    const std::lock_guard lock(mutex_);
    return open_.empty() && Clock::now() - last_closed_ > kReload;
  }

  // A page that is loaded again closes before it opens.
  bool AllClosed() const {
    const std::lock_guard lock(mutex_);
    return had_any_ && open_.empty() && Clock::now() - last_closed_ > kReload;
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::size_t kMost = 1000;
  static constexpr std::chrono::seconds kReload{3};

  mutable std::mutex mutex_;
  std::set<std::string> open_, gone_;
  bool had_any_ = false;
  Clock::time_point last_closed_{};
};

}  // namespace lake::review
