// How many threads this process may work with, whatever the work: --threads of every program.
#pragma once

namespace lake {

// The machine's, until SetThreads().
int Threads();

// Throws UsageError below 1. Called before the work begins; results do not depend on the number.
void SetThreads(int threads);

}  // namespace lake
