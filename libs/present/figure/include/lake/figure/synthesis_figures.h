// The figures of a synthesis outcome.
#pragma once

#include <filesystem>
#include <string>

#include "lake/synthesis/synthesis_outcome.h"

namespace lake::figure {

// Range against the change of each link, one panel per link; where it cannot be assembled is shaded, where it leaves
// the bounds or violates a requirement on the links dashed.
void DrawSensitivity(const synthesis::SynthesisOutcome& outcome, const std::filesystem::path& path);

// Range (and yield, if estimated) against the margin from both singularities.
void DrawMargins(const synthesis::SynthesisOutcome& outcome, const std::filesystem::path& path);

// What Ipopt's cost stands for, `per_cost` of it and `objective` with its unit, and the errors over its iterations.
void DrawConvergence(const synthesis::LocalSolve& solve, const std::string& objective, double per_cost,
                     const std::filesystem::path& path);

}  // namespace lake::figure
