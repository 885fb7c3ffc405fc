// What files and command lines say of the load as texts. Throw UsageError.
#pragma once

#include <string>

#include "lake/problem/problem.h"

namespace lake::problem {

void SetRest(const std::string& text, SynthesisProblem& problem);
void SetDuration(const std::string& text, SynthesisProblem& problem);  // "free" or seconds

}  // namespace lake::problem
