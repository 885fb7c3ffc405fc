// A problem whose loads are those of its own optimum's rise.
//
// What the knee needs depends on the pace, the pace on the design (FindAssistance in problem/assistance.h), and the
// design on what the knee needs: a problem is solved again under the moments of the rise that was found, until they
// stay.
#pragma once

#include <functional>
#include <optional>

#include "lake/problem/problem.h"

namespace lake::synthesis {

// Calls `solve`, which gives the links of a usable optimum or nothing, until the moments of `problem` are those of the
// rise that it found last, to 2e-6 of the duration, or 12 times; once where the profile does not say what pace adds
// to them. Where nothing is found at the pace given, the slowest rise is tried too. `problem` is left with the moments
// of the last call.
void SolveAtItsPace(problem::SynthesisProblem& problem,
                    const std::function<std::optional<linkage::Links>(const problem::SynthesisProblem&)>& solve);

}  // namespace lake::synthesis
