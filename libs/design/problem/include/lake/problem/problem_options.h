// The options of a synthesis problem.
#pragma once

#include "lake/core/options.h"
#include "lake/problem/problem.h"

namespace lake::problem {

// The options that change a problem that was read from a file, or the paper's.
void Describe(SynthesisProblem& o, OptionList& options);

// The options of clearances and of the body.
void DescribeClearances(SynthesisProblem& o, OptionList& options);

// The options of the load profile and of the actuator.
void DescribeLoad(SynthesisProblem& o, OptionList& options);

// Throws UsageError where a body is given, but no clearance is asked for.
void CheckBody(const SynthesisProblem& problem);

// Throws UsageError where --rest was changed, but no actuator has a share to hold.
void CheckRest(const SynthesisProblem& problem);

}  // namespace lake::problem
