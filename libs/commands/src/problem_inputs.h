// The files that a design problem's load comes from. Not part of the interface.
#pragma once

#include <vector>

#include "lake/core/run.h"
#include "lake/problem/problem.h"

namespace lake::commands {

// Adds the load profile's file and the actuators' table, where there are any.
void AddLoadFiles(const problem::SynthesisProblem& problem, std::vector<InputFile>& inputs);

}  // namespace lake::commands
