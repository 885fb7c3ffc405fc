// Independent pieces of work at the same time, each in a process of its own: for libraries with global state, which
// threads would share (MUMPS, the linear solver of Ipopt), and for whole steps.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/progress.h"

namespace lake {

// A process that works on one piece. Ended with this object, if it has not ended by itself: asked to by SIGTERM, and
// waited for, so that it can remove what is half written; a parent that is killed takes it along. It is in a process
// group of its own: Ctrl-C is for the parent.
class WorkerProcess {
 public:
  // Computes the piece and returns its result as bytes; calls `step` for every step of the progress that is done.
  using Work = std::function<std::string(const std::function<void()>& step)>;

  // Throws Error if no process can be started.
  explicit WorkerProcess(const Work& work);
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;
  ~WorkerProcess();  // asks it to end, and ends it if it has not done so within 10 s

  int Pipe() const { return pipe_; }  // to be read from when it has something

  // Takes what has come, steps as progress. False once all has.
  bool Read(Progress& progress);

  // The result, after Read() said that all has come. Throws what the work threw: UsageError, SolverError, Interrupted,
  // else Error, which also says so if the process was killed.
  std::string Take();

 private:
  std::optional<int> Wait();
  bool HasEnded() const;  // within that time

  pid_t process_ = -1;
  int pipe_ = -1;
  std::string ending_;
};

// Waits for a process that this one has started and returns its status, as waitpid() has it; a signal that arrives
// meanwhile changes nothing. nullopt where the system does not know the process (any more).
std::optional<int> WaitForEnd(pid_t process);

// The exit status of another program that was started in a process group of its own; looked at every `nap`.
// Interrupted, it ends the program, and with it what that has started, before it throws. Throws Error naming the
// program.
int WaitForChild(pid_t child, const std::string& program, std::chrono::milliseconds nap);

// Waits until one of these has something to be read, or for a tenth of a second; returns which. Throws Interrupted on a
// signal.
std::vector<bool> WaitForWorkers(const std::vector<const WorkerProcess*>& workers);

// Computes piece i. It changes nothing that anybody else reads, files included: only the bytes come back.
using PieceOfWork = std::function<std::string(std::size_t i, const std::function<void()>& step)>;

// The results of pieces 0 .. count - 1, as many computed at the same time as Threads() says (one: all of them in this
// process); the same for any number. Throws what a piece that failed threw and Interrupted on a signal; no process is
// left behind.
std::vector<std::string> InProcesses(std::size_t count, const PieceOfWork& work, Progress& progress);

}  // namespace lake
