#include "lake/core/threads.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

namespace lake {
namespace {

TEST(ForEachInThreads, DoesEachPieceOnce) {
  for (const int threads : {1, 2, 7}) {
    std::vector<int> calls(100);
    ForEachInThreads(calls.size(), threads, [&](std::size_t i) { ++calls[i]; });
    EXPECT_EQ(calls, std::vector<int>(calls.size(), 1)) << threads << " threads";
  }
  ForEachInThreads(0, 2, [](std::size_t) { FAIL() << "there is nothing to do"; });
}

TEST(ForEachInThreads, StaysInThisThreadIfThereIsOne) {
  const std::thread::id here = std::this_thread::get_id();
  ForEachInThreads(10, 1, [&](std::size_t) { EXPECT_EQ(std::this_thread::get_id(), here); });
}

TEST(ForEachInThreads, ThrowsWhatTheFirstPieceThatFailsThrows) {
  for (const int threads : {1, 4}) {
    std::atomic<int> calls = 0;
    try {
      ForEachInThreads(50, threads, [&](std::size_t i) {
        ++calls;
        if (i % 20 == 19) throw std::runtime_error(std::to_string(i));
      });
      ADD_FAILURE() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "19");
    }
    EXPECT_EQ(calls, 50);
  }
}

}  // namespace
}  // namespace lake
