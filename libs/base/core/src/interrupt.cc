#include "lake/core/interrupt.h"

#include <atomic>
#include <csignal>

namespace lake {
namespace {

std::atomic<int> pending_signal{0};
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may touch lock-free atomics only");

void Remember(int signal) {
  pending_signal = signal;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void CatchInterrupts() {
  std::signal(SIGINT, Remember);
  std::signal(SIGTERM, Remember);
}

void ThrowIfInterrupted() {
  if (const int signal = pending_signal) throw Interrupted(signal);
}

}  // namespace lake
