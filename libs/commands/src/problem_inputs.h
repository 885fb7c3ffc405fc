// The files that a design problem's load comes from. Not part of the interface.
#pragma once

#include <vector>

#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/problem/problem.h"

namespace lake::commands {

// Adds the load profile's file and the actuators' table, where there are any.
void AddLoadFiles(const problem::SynthesisProblem& problem, std::vector<InputFile>& inputs);

// Sets options to the texts that a design's file has under their keys (its parts, body or load). None is set where a
// file that one names is not there: returns that file. Throws Error with the design's file.
std::filesystem::path TakeFromDesign(const Json& texts, const std::filesystem::path& file, OptionList options);

}  // namespace lake::commands
