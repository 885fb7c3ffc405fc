// The work of lake-compare --left A --right B: what differs between both legs of one person.
#pragma once

#include "lake/commands/compare.h"
#include "lake/core/json.h"
#include "lake/core/run.h"

namespace lake::commands {

// Writes symmetry.csv, symmetry_curve.csv and symmetry.png; returns the results for the summary. The legs are those of
// `options.left` and `options.right`.
Json RunSymmetry(const CompareRunOptions& options, Run& run);

}  // namespace lake::commands
