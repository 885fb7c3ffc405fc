#include "lake/core/processes.h"

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>

#include "lake/core/child_program.h"
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

// A signal handler for which the system ends a wait early, as long as it lives; the alarm comes after this time.
class InterruptingAlarm {
 public:
  explicit InterruptingAlarm(useconds_t delay_us) {
    struct sigaction action {};
    action.sa_handler = [](int) {};  // without SA_RESTART
    sigaction(SIGALRM, &action, &before_);
    ualarm(delay_us, delay_us);
  }
  ~InterruptingAlarm() {
    ualarm(0, 0);
    sigaction(SIGALRM, &before_, nullptr);
  }

 private:
  struct sigaction before_ {};
};

ChildEnd RunShell(const std::string& script, std::vector<std::string>& said) {
  return RunChild(
      "/bin/sh", {"-c", script}, [&](const std::string& line) { said.push_back(line); }, [] {});
}

TEST(Child, ThatIsWaitedForKeepsItsExitCodeThroughSignals) {
  const InterruptingAlarm alarm(20000);
  std::vector<std::string> said;
  // It ends after its outputs do, so that its end is waited for.
  EXPECT_EQ(RunShell("exec >&- 2>&-; sleep 0.2; exit 7", said).code, 7);
  EXPECT_EQ(RunShell("exec >&- 2>&-; sleep 0.2; kill -KILL $$", said).code, 128 + SIGKILL);
  EXPECT_EQ(WaitForEnd(1), std::nullopt) << "not this process's child";
}

TEST(Child, IsHeardOnBothOutputs) {
  std::vector<std::string> said;
  const ChildEnd end = RunShell("echo 'warning: a name with {' >&2; echo '{'; echo '}'; printf 'last words' >&2", said);
  EXPECT_EQ(end.code, 0);
  EXPECT_EQ(end.output, "{\n}\n");
  EXPECT_THAT(said, testing::ElementsAre("warning: a name with {", "last words"));
  EXPECT_EQ(end.last_line, "last words");
}

// Its handler does not end the write that it is in.
TEST(Child, IsEndedWhereItWritesMoreThanIsRead) {
  const auto stop = [] { throw Error("stopped"); };
  EXPECT_THAT(
      [&] {
        RunChild(
            "/bin/sh", {"-c", "trap 'exit 1' TERM; while :; do echo 0123456789; done"}, [](const std::string&) {},
            stop);
      },
      ThrowsMessage<Error>("stopped"));
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
}

TEST(Child, ThatCannotBeStartedIsNamed) {
  EXPECT_THAT(
      [] {
        RunChild(
            "/nowhere/lake-run", {}, [](const std::string&) {}, [] {});
      },
      ThrowsMessage<Error>(HasSubstr("/nowhere/lake-run: cannot be started")));
}

}  // namespace
}  // namespace lake
