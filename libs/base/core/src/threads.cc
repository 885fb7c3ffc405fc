#include "lake/core/threads.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <thread>
#include <vector>

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
  if (count < 1) throw UsageError("--threads must be at least 1, not {}", count);
  threads = count;
}

void ForEachInThreads(std::size_t count, int threads, const std::function<void(std::size_t)>& work) {
  std::vector<std::exception_ptr> errors(count);
  std::atomic<std::size_t> next = 0;
  const auto take_next = [&] {
    for (std::size_t i = next++; i < count; i = next++) try {
        work(i);
      } catch (...) {
        errors[i] = std::current_exception();
      }
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t other = 1; other < std::min(count, static_cast<std::size_t>(std::max(threads, 1))); ++other)
      others.emplace_back(take_next);
    take_next();
  }
  for (const std::exception_ptr& error : errors)
    if (error) std::rethrow_exception(error);
}

}  // namespace lake
