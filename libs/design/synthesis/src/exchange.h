// The exchange step of semi-infinite programming: which poses of the used range to add to the program.
#pragma once

#include "lake/synthesis/synthesis_program.h"

namespace lake::synthesis {

// Poses to begin with: interior ones of the used range, as its ends are always there, and some samples of a load
// profile.
Collocation FirstPoses(const problem::SynthesisProblem& problem);

// Adds the local worst poses at which a family is violated by more than `tolerance` x its limit, or, if the linkage
// cannot go through its used range at all, poses half-way between those there are. False if there is nothing to add.
bool AddViolatedPoses(const problem::SynthesisProblem& problem, const std::vector<problem::Requirement>& requirements,
                      const linkage::Links& links, double tolerance, Collocation& poses);

}  // namespace lake::synthesis
