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

// The cost's negative and the errors over Ipopt's iterations; `objective` names the first, with its unit.
void DrawConvergence(const synthesis::LocalSolve& solve, const std::string& objective,
                     const std::filesystem::path& path);

}  // namespace lake::figure
