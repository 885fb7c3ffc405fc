// The exchange step of semi-infinite programming: which poses of the used range to add to the program.
#pragma once

#include <vector>

#include "lake/synthesis/problem.h"

namespace lake {

// Interior poses to begin with; both ends of the used range are always there.
std::vector<double> FirstFractions();

// Adds the local worst poses at which a family is violated by more than `tolerance` x its limit; false if there are none.
bool AddViolatedPoses(const SynthesisProblem& problem, const Links& links, double tolerance,
                      std::vector<double>& fractions);

}  // namespace lake
