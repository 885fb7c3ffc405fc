// The exchange step of semi-infinite programming: which poses of the used range to add to the program.
#pragma once

#include <vector>

#include "lake/problem/problem.h"

namespace lake::synthesis {

// Interior poses to begin with; both ends of the used range are always there.
std::vector<double> FirstFractions();

// Adds the local worst poses at which a family is violated by more than `tolerance` x its limit, or, if the linkage
// cannot go through its used range at all, poses half-way between those there are. False if there is nothing to add.
bool AddViolatedPoses(const problem::SynthesisProblem& problem, const linkage::Links& links, double tolerance,
                      std::vector<double>& fractions);

}  // namespace lake::synthesis
