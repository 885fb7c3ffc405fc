// Long work behind a page: it says how far it is, and can be stopped.
#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "lake/core/json.h"

namespace lake::review {

class BackgroundJob {
 public:
  // What the work is given.
  struct Control {
    std::function<void(const std::string& line)> say;  // how far it is
    std::function<void()> throw_if_stopped;            // Error; Interrupted once a signal has arrived
  };
  using Work = std::function<void(const Control&)>;

  BackgroundJob() = default;
  BackgroundJob(const BackgroundJob&) = delete;
  BackgroundJob& operator=(const BackgroundJob&) = delete;
  ~BackgroundJob();  // stops it and waits for its end

  // Throws Error where one is under way.
  void Start(Work work);
  void Stop() { is_stopped_ = true; }
  bool IsRunning() const;

  // JobMessage in page/messages.ts: {running, progress: what was said last, failed: why the last one failed, or empty}.
  Json State() const;

 private:
  void Do(const Work& work);

  mutable std::mutex mutex_;
  bool is_running_ = false;
  std::string progress_, failed_;
  std::atomic<bool> is_stopped_ = false;
  std::thread thread_;
};

}  // namespace lake::review
