// How many threads this process may work with, whatever the work: --threads of every program.
#pragma once

#include <cstddef>
#include <functional>

namespace lake {

// The machine's, until SetThreads().
int Threads();

// Throws UsageError below 1. Called before the work begins; results do not depend on the number.
void SetThreads(int threads);

// Calls work(0) … work(count − 1), as many at the same time as `threads` says. Throws, after all have ended, what the
// first of them in this order threw.
void ForEachInThreads(std::size_t count, int threads, const std::function<void(std::size_t)>& work);

}  // namespace lake
