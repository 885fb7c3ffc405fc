#include "lake/core/processes.h"

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>

#include "lake/core/error.h"
#include "lake/core/threads.h"

namespace lake {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

class Processes : public testing::TestWithParam<int> {
 protected:
  Processes() { SetThreads(GetParam()); }
  ~Processes() override { SetThreads(before_); }

  std::vector<std::string> Compute(std::size_t count, const PieceOfWork& work) {
    return InProcesses(count, work, progress_);
  }

 private:
  const int before_ = Threads();
  Progress progress_{"pieces", "steps", std::nullopt, true};
};

TEST_P(Processes, ResultsComeInOrderWhateverTheirSize) {
  const auto results = Compute(7, [](std::size_t i, const std::function<void()>& step) {
    for (std::size_t s = 0; s < 100 * i; ++s) step();
    // Those that begin last end first, and what they write is longer than a pipe holds.
    usleep(static_cast<useconds_t>(2000 * (7 - i)));
    return std::string(30000 * i, static_cast<char>('.' + static_cast<char>(i)));
  });
  ASSERT_EQ(results.size(), 7u);
  for (std::size_t i = 0; i < 7; ++i)
    EXPECT_EQ(results[i], std::string(30000 * i, static_cast<char>('.' + static_cast<char>(i)))) << i;
}

TEST_P(Processes, ErrorsKeepTheirKindAndText) {
  const auto fail = [](std::size_t i, const std::function<void()>&) -> std::string {
    if (i == 1) throw UsageError("--pareto 1: 2 to 1000 points");
    return "";
  };
  EXPECT_THAT([&] { Compute(3, fail); }, ThrowsMessage<UsageError>("--pareto 1: 2 to 1000 points"));
  const auto crash = [](std::size_t, const std::function<void()>&) -> std::string { throw std::bad_alloc(); };
  EXPECT_ANY_THROW(Compute(2, crash));
}

TEST_P(Processes, NothingIsComputedForNothing) {
  EXPECT_TRUE(Compute(0, [](std::size_t, const std::function<void()>&) { return std::string("never"); }).empty());
}

INSTANTIATE_TEST_SUITE_P(Threads, Processes, testing::Values(1, 2, 5));

// A piece that would go on for long is ended when another fails.
TEST(FailedPiece, LeavesNoProcessBehind) {
  const int before = Threads();
  SetThreads(2);
  Progress progress("pieces", "steps", std::nullopt, true);
  const auto fail = [](std::size_t i, const std::function<void()>&) -> std::string {
    if (i == 1) throw Error("cannot be");
    pause();
    return "";
  };
  EXPECT_THAT([&] { InProcesses(2, fail, progress); }, ThrowsMessage<Error>("cannot be"));
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
  SetThreads(before);
}

// It is asked to end while it writes more than a pipe holds, and nobody reads that any more.
TEST(FailedPiece, DoesNotWaitForAResultThatNobodyReads) {
  const auto before_signal = std::signal(SIGTERM, [](int) {});  // as programs do that end cleanly
  const int before = Threads();
  SetThreads(2);
  Progress progress("pieces", "steps", std::nullopt, true);
  const auto fail = [](std::size_t i, const std::function<void()>&) -> std::string {
    if (i == 1) throw Error("cannot be");
    return std::string(std::size_t{64} << 20, 'x');
  };
  EXPECT_THAT([&] { InProcesses(2, fail, progress); }, ThrowsMessage<Error>("cannot be"));
  SetThreads(before);
  std::signal(SIGTERM, before_signal);
}

// Nor for one that does not look whether it is to end.
TEST(FailedPiece, DoesNotWaitForEverForAPieceThatDoesNotEnd) {
  const int before = Threads();
  SetThreads(2);
  Progress progress("pieces", "steps", std::nullopt, true);
  const auto fail = [](std::size_t i, const std::function<void()>&) -> std::string {
    std::signal(SIGTERM, SIG_IGN);
    if (i == 1) throw Error("cannot be");
    for (;;) pause();
  };
  EXPECT_THAT([&] { InProcesses(2, fail, progress); }, ThrowsMessage<Error>("cannot be"));
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
  SetThreads(before);
}

TEST(KilledProcess, IsAnErrorThatSaysSo) {
  const int before = Threads();
  SetThreads(2);
  Progress progress("pieces", "steps", std::nullopt, true);
  const auto killed = [](std::size_t i, const std::function<void()>&) {
    if (i == 1) raise(SIGKILL);
    return std::string("done");
  };
  EXPECT_THAT([&] { InProcesses(2, killed, progress); }, ThrowsMessage<Error>(HasSubstr("Killed")));
  SetThreads(before);
}

}  // namespace
}  // namespace lake
