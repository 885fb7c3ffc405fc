// Independent pieces of work at the same time, each in a process of its own: for libraries with global state, which
// threads would share (MUMPS, the linear solver of Ipopt).
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "lake/core/progress.h"

namespace lake {

// Computes piece i and returns its result as bytes; calls `step` for every step of the progress that is done. It
// changes nothing that anybody else reads, files included: only the bytes come back.
using PieceOfWork = std::function<std::string(std::size_t i, const std::function<void()>& step)>;

// The results of pieces 0 .. count - 1, as many computed at the same time as Threads() says (one: all of them in this
// process); the same for any number. Throws what a piece that failed threw (UsageError, else Error) and
// Interrupted on a signal; no process is left behind.
std::vector<std::string> InProcesses(std::size_t count, const PieceOfWork& work, Progress& progress);

}  // namespace lake
