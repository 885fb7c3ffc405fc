#include "lake/review/background_job.h"

#include <exception>
#include <utility>

#include "lake/core/error.h"
#include "lake/core/fault_text.h"
#include "lake/core/interrupt.h"

namespace lake::review {

BackgroundJob::~BackgroundJob() {
  Stop();
  if (thread_.joinable()) thread_.join();
}

void BackgroundJob::Start(Work work) {
  const std::lock_guard lock(mutex_);
  if (is_running_) throw Error("that is under way");
  if (thread_.joinable()) thread_.join();  // has ended
  is_running_ = true;
  is_stopped_ = false;
  progress_.clear();
  failed_.clear();
  thread_ = std::thread([this, work = std::move(work)] { Do(work); });
}

void BackgroundJob::Do(const Work& work) {
  Control control;
  control.say = [this](const std::string& line) {
    const std::lock_guard lock(mutex_);
    progress_ = line;
  };
  control.throw_if_stopped = [this] {
    ThrowIfInterrupted();
    if (is_stopped_) throw Error("stopped");
  };
  std::string failure;
  try {
    work(control);
  } catch (const std::exception& error) {
    failure = FaultText(error);
  }
  const std::lock_guard lock(mutex_);
  is_running_ = false;
  failed_ = failure;
}

bool BackgroundJob::IsRunning() const {
  const std::lock_guard lock(mutex_);
  return is_running_;
}

Json BackgroundJob::State() const {
  const std::lock_guard lock(mutex_);
  return {{"running", is_running_}, {"progress", progress_}, {"failed", failed_}};
}

}  // namespace lake::review
