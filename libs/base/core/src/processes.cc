#include "lake/core/processes.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <memory>
#include <thread>
#include <utility>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/threads.h"

namespace lake {
namespace {

// What comes through the pipe: a byte per step, then how the piece ended, then its result or message.
enum Tag : char { kStep = '.', kResult = 'r', kError = 'e', kUsageError = 'u', kSolverError = 's', kInterrupted = 'i' };

bool WriteAll(int pipe, const char* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t written = write(pipe, bytes, count);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes += written;
    count -= static_cast<std::size_t>(written);
  }
  return true;
}

std::string Ending(Tag tag, const std::string& text) {
  return static_cast<char>(tag) + text;
}

std::string EndingOf(const WorkerProcess::Work& work, int pipe) {
  try {
    return Ending(kResult, work([&] {
                    const char step = kStep;
                    if (!WriteAll(pipe, &step, 1)) throw Fail("the process that asked for this work is gone");
                  }));
  } catch (const UsageError& error) {
    return Ending(kUsageError, error.what());
  } catch (const SolverError& error) {
    return Ending(kSolverError, error.what());
  } catch (const Interrupted&) {
    return Ending(kInterrupted, "");
  } catch (const std::bad_alloc&) {
    return Ending(kError, "not enough memory for this input");
  } catch (const std::exception& error) {
    return Ending(kError, error.what());
  }
}

// Does the work in the process that was started for it.
[[noreturn]] void WorkInChild(const WorkerProcess::Work& work, int pipe, pid_t parent) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
  const std::string ending = EndingOf(work, pipe);
  _exit(WriteAll(pipe, ending.data(), ending.size()) ? 0 : 1);  // not exit(): nothing of the parent is flushed twice
}

}  // namespace

WorkerProcess::WorkerProcess(const Work& work) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) throw Fail("no pipe to another process: {}", std::strerror(errno));
  const pid_t parent = getpid();
  process_ = fork();
  if (process_ == 0) {
    close(ends[0]);
    WorkInChild(work, ends[1], parent);
  }
  const int error = errno;
  close(ends[1]);
  pipe_ = ends[0];
  if (process_ > 0) return;
  close(pipe_);
  throw Fail("no other process can be started: {}", std::strerror(error));
}

WorkerProcess::~WorkerProcess() {
  if (process_ > 0) {
    kill(process_, SIGTERM);
    if (!HasEnded()) kill(process_, SIGKILL);
    Wait();
  }
  close(pipe_);
}

bool WorkerProcess::HasEnded() const {
  constexpr std::chrono::seconds kPatience{10};
  const auto deadline = std::chrono::steady_clock::now() + kPatience;
  pollfd pipe{pipe_, POLLIN, 0};
  char unread[1 << 14];  // it may wait for a reader before it can end
  while (std::chrono::steady_clock::now() < deadline) {
    if (poll(&pipe, 1, 100) <= 0) continue;
    const ssize_t count = read(pipe_, unread, sizeof unread);
    if (count == 0 || (count < 0 && errno != EINTR)) return true;
  }
  return false;
}

bool WorkerProcess::Read(Progress& progress) {
  char bytes[1 << 14];
  const ssize_t count = read(pipe_, bytes, sizeof bytes);
  if (count < 0) return errno == EINTR || errno == EAGAIN;
  const char* end = bytes + count;
  const char* begin = ending_.empty() ? std::find_if(bytes, bytes + count, [](char c) { return c != kStep; }) : bytes;
  if (begin != bytes) progress.Advance(begin - bytes);
  ending_.append(begin, end);
  return count > 0;
}

std::string WorkerProcess::Take() {
  const std::optional<int> status = Wait();
  if (ending_.empty() || status != 0)
    throw Fail("a part of the work ended without a result ({}); with --threads 1 less memory is needed",
               status && WIFSIGNALED(*status) ? strsignal(WTERMSIG(*status)) : "its process exited");
  const std::string text = ending_.substr(1);
  switch (ending_.front()) {
    case kResult:
      return text;
    case kUsageError:
      throw UsageError(text);
    case kSolverError:
      throw SolverError(text);
    case kInterrupted:
      throw Interrupted(SIGTERM);
    default:
      throw Error(text);
  }
}

std::optional<int> WorkerProcess::Wait() {
  return WaitForEnd(std::exchange(process_, -1));
}

std::optional<int> WaitForEnd(pid_t process) {
  int status = 0;
  while (waitpid(process, &status, 0) < 0)
    if (errno != EINTR) return std::nullopt;
  return status;
}

int WaitForChild(pid_t child, const std::string& program, std::chrono::milliseconds nap) {
  int status = 0;
  for (;;) {
    const pid_t ended = waitpid(child, &status, WNOHANG);
    if (ended == child) return status;
    if (ended < 0 && errno != EINTR) throw Fail("{}: {}", program, std::strerror(errno));
    try {
      ThrowIfInterrupted();
    } catch (const Interrupted&) {
      kill(-child, SIGTERM);
      WaitForEnd(child);
      throw;
    }
    std::this_thread::sleep_for(nap);
  }
}

std::vector<bool> WaitForWorkers(const std::vector<const WorkerProcess*>& workers) {
  constexpr int kPatience_ms = 100;
  std::vector<pollfd> pipes;
  for (const WorkerProcess* worker : workers) pipes.push_back({worker->Pipe(), POLLIN, 0});
  const int ready = poll(pipes.data(), pipes.size(), kPatience_ms);
  ThrowIfInterrupted();
  std::vector<bool> have_something(workers.size(), false);
  for (std::size_t i = 0; ready > 0 && i < pipes.size(); ++i) have_something[i] = pipes[i].revents != 0;
  return have_something;
}

std::vector<std::string> InProcesses(std::size_t count, const PieceOfWork& work, Progress& progress) {
  std::vector<std::string> results(count);
  const auto most = static_cast<std::size_t>(Threads());
  if (most == 1 || count < 2) {
    for (std::size_t i = 0; i < count; ++i) results[i] = work(i, [&] { progress.Advance(); });
    return results;
  }
  std::vector<std::unique_ptr<WorkerProcess>> workers(count);
  std::vector<std::size_t> working;  // which pieces are
  for (std::size_t begun = 0; begun < count || !working.empty();) {
    for (; begun < count && working.size() < most; working.push_back(begun++))
      workers[begun] = std::make_unique<WorkerProcess>(
          [&work, begun](const std::function<void()>& step) { return work(begun, step); });
    std::vector<const WorkerProcess*> waited_for;
    for (const std::size_t i : working) waited_for.push_back(workers[i].get());
    const std::vector<bool> ready = WaitForWorkers(waited_for);
    for (std::size_t w = working.size(); w-- > 0;) {
      const std::size_t i = working[w];
      if (!ready[w] || workers[i]->Read(progress)) continue;
      results[i] = workers[i]->Take();
      workers[i].reset();
      working.erase(working.begin() + static_cast<std::ptrdiff_t>(w));
    }
  }
  return results;
}

}  // namespace lake
