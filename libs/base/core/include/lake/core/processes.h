// Independent pieces of work at the same time, each in a process of its own: for libraries with global state, which
// threads would share (MUMPS, the linear solver of Ipopt), and for whole steps.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <type_traits>
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

// The exit status of a program that was started in a process group of its own, polled every `nap`. On a signal it ends
// the program and all that the program started, then throws Interrupted. Throws Error naming the program.
int WaitForChild(pid_t child, const std::string& program, std::chrono::milliseconds nap);

// Waits until one of these has something to be read, or for a tenth of a second; returns which. Throws Interrupted on a
// signal.
std::vector<bool> WaitForWorkers(const std::vector<const WorkerProcess*>& workers);

// Computes piece i and returns its result as bytes. It must have no other effect, on files included.
using PieceOfWork = std::function<std::string(std::size_t i, const std::function<void()>& step)>;

// The results of pieces 0 .. count - 1, as many computed at the same time as Threads() says (one: all of them in this
// process); the same for any number. Throws what a piece that failed threw and Interrupted on a signal; no process is
// left behind.
std::vector<std::string> InProcesses(std::size_t count, const PieceOfWork& work, Progress& progress);

// The same for results that nlohmann::json can hold. `work` is called with i and steps itself, or with i alone: one
// step for each piece.
template <typename Work>
auto ResultsInProcesses(std::size_t count, const Work& work, Progress& progress) {
  const auto one = [&work](std::size_t i, const std::function<void()>& step) {
    if constexpr (std::is_invocable_v<Work, std::size_t, const std::function<void()>&>) {
      return work(i, step);
    } else {
      auto result = work(i);
      step();
      return result;
    }
  };
  const auto packed = [&one](std::size_t i, const std::function<void()>& step) {
    std::string bytes;
    nlohmann::json::to_cbor(nlohmann::json(one(i, step)), bytes);  // keeps every double, NaN and infinities too
    return bytes;
  };
  std::vector<std::invoke_result_t<decltype(one), std::size_t, std::function<void()>>> results;
  for (const std::string& bytes : InProcesses(count, packed, progress))
    nlohmann::json::from_cbor(bytes).get_to(results.emplace_back());
  return results;
}

}  // namespace lake
