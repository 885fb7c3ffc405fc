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
#include <optional>

#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/threads.h"

namespace lake {
namespace {

// What comes through the pipe: a byte per step, then how the piece ended, then its result or message.
enum Tag : char { kStep = '.', kResult = 'r', kError = 'e', kUsageError = 'u', kInterrupted = 'i' };

bool WriteAll(int pipe, const char* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t written = write(pipe, bytes, count);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes += written, count -= static_cast<std::size_t>(written);
  }
  return true;
}

std::string Ending(Tag tag, const std::string& text) {
  return static_cast<char>(tag) + text;
}

std::string RunPiece(std::size_t i, const PieceOfWork& work, int pipe) {
  try {
    return Ending(kResult, work(i, [&] {
                    const char step = kStep;
                    if (!WriteAll(pipe, &step, 1)) throw Fail("the process that asked for this work is gone");
                  }));
  } catch (const UsageError& error) {
    return Ending(kUsageError, error.what());
  } catch (const Interrupted&) {
    return Ending(kInterrupted, "");
  } catch (const std::exception& error) {
    return Ending(kError, error.what());
  }
}

// One process that works on a piece; ended, if need be by force, with this object.
class Worker {
 public:
  Worker(std::size_t piece, const PieceOfWork& work) : piece_(piece) {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw Fail("no pipe to another process: {}", std::strerror(errno));
    const pid_t parent = getpid();
    process_ = fork();
    if (process_ == 0) {
      close(ends[0]);
      prctl(PR_SET_PDEATHSIG, SIGKILL);  // a parent that is killed takes its work along
      if (getppid() != parent) _exit(1);
      const std::string ending = RunPiece(piece, work, ends[1]);
      _exit(WriteAll(ends[1], ending.data(), ending.size()) ? 0
                                                            : 1);  // not exit(): nothing of the parent is flushed twice
    }
    const int error = errno;
    close(ends[1]);
    pipe_ = ends[0];
    if (process_ < 0) {
      close(pipe_);
      throw Fail("no other process can be started: {}", std::strerror(error));
    }
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  ~Worker() {
    if (process_ > 0) {
      kill(process_, SIGKILL);
      Wait();
    }
    close(pipe_);
  }

  int Pipe() const { return pipe_; }
  std::size_t Piece() const { return piece_; }

  // Takes what has come. False once all has.
  bool Read(Progress& progress) {
    char bytes[1 << 14];
    const ssize_t count = read(pipe_, bytes, sizeof bytes);
    if (count < 0) return errno == EINTR || errno == EAGAIN;
    const char* end = bytes + count;
    const char* begin = ending_.empty() ? std::find_if(bytes, bytes + count, [](char c) { return c != kStep; }) : bytes;
    if (begin != bytes) progress.Advance(begin - bytes);
    ending_.append(begin, end);
    return count > 0;
  }

  // The result, or what it threw.
  std::string Take() {
    const int status = Wait();
    if (ending_.empty() || status != 0)
      throw Fail("a part of the work ended without a result ({}); less memory is needed with --threads 1",
                 WIFSIGNALED(status) ? strsignal(WTERMSIG(status)) : "its process exited");
    const std::string text = ending_.substr(1);
    switch (ending_.front()) {
      case kResult:
        return text;
      case kUsageError:
        throw UsageError(text);
      case kInterrupted:
        throw Interrupted(SIGINT);
      default:
        throw Error(text);
    }
  }

 private:
  int Wait() {
    int status = 0;
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    process_ = -1;
    return status;
  }

  std::size_t piece_;
  pid_t process_ = -1;
  int pipe_ = -1;
  std::string ending_;
};

std::vector<std::string> OneAfterTheOther(std::size_t count, const PieceOfWork& work, Progress& progress) {
  std::vector<std::string> results;
  for (std::size_t i = 0; i < count; ++i) results.push_back(work(i, [&] { progress.Advance(); }));
  return results;
}

// Waits until a worker has something to say; a signal is noticed within a tenth of a second.
void WaitForWorkers(const std::vector<std::unique_ptr<Worker>>& workers, std::vector<pollfd>& pipes) {
  constexpr int kPatience_ms = 100;
  pipes.clear();
  for (const auto& worker : workers) pipes.push_back({worker->Pipe(), POLLIN, 0});
  poll(pipes.data(), pipes.size(), kPatience_ms);
  ThrowIfInterrupted();
}

}  // namespace

std::vector<std::string> InProcesses(std::size_t count, const PieceOfWork& work, Progress& progress) {
  const std::size_t most = static_cast<std::size_t>(Threads());
  if (most == 1 || count < 2) return OneAfterTheOther(count, work, progress);
  std::vector<std::string> results(count);
  std::vector<std::unique_ptr<Worker>> workers;
  std::vector<pollfd> pipes;
  for (std::size_t begun = 0; begun < count || !workers.empty();) {
    while (begun < count && workers.size() < most) workers.push_back(std::make_unique<Worker>(begun++, work));
    WaitForWorkers(workers, pipes);
    for (std::size_t w = workers.size(); w-- > 0;) {
      if (pipes[w].revents == 0 || workers[w]->Read(progress)) continue;
      results[workers[w]->Piece()] = workers[w]->Take();
      workers.erase(workers.begin() + static_cast<std::ptrdiff_t>(w));
    }
  }
  return results;
}

}  // namespace lake
