#include "lake/core/threads.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "lake/core/error.h"

namespace lake {
namespace {

std::atomic<int> threads = 0;  // 0: not set

}  // namespace

int Threads() {
  const int set = threads;
  return set > 0 ? set : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

void SetThreads(int count) {
  if (count < 1) throw UsageError(fmt::format("--threads must be at least 1, not {}", count));
  threads = count;
}

}  // namespace lake
