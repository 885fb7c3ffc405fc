// The options of a synthesis problem.
#pragma once

#include "lake/core/options.h"
#include "lake/problem/problem.h"

namespace lake::problem {

// What a command line changes of a problem that was read from a file or is the paper's.
void Describe(SynthesisProblem& o, OptionList& options);

// Of these the clearances, and the body that they are on.
void DescribeClearances(SynthesisProblem& o, OptionList& options);

// Of these what the knee needs, and the actuator that gives it.
void DescribeLoad(SynthesisProblem& o, OptionList& options);

// Throws UsageError where a body is given, but no clearance is asked for.
void CheckBody(const SynthesisProblem& problem);

// Throws UsageError where --rest was changed, but no actuator has a share to hold.
void CheckRest(const SynthesisProblem& problem);

}  // namespace lake::problem
