// The tables and the summary of lake-optimize.
#pragma once

#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/redesign/redesign_outcome.h"
#include "lake/synthesis/synthesis_outcome.h"

namespace lake::commands {

// Writes design.yaml, optimum.csv, constraints.csv, starts.csv, convergence.csv, sensitivity.csv, margin.csv and, if
// there is one, rounded.yaml, with a yield yield.csv and tolerant.yaml; returns the results for summary.json. Warns
// through the run of what a reader must know.
Json WriteSynthesis(const synthesis::SynthesisOutcome& outcome, Run& run);

// Writes design.yaml, optimum.csv, constraints.csv, starts.csv, convergence.csv, before_after.csv, cuffs.csv,
// program.csv, predicted/misalignment.csv and predicted/comparison.json (as lake-compare writes them), the same in
// joint_moved/ for the worn design with its joint moved, and, if asked for, pareto.csv; returns the results for
// summary.json. Warns through the run of what a reader must know.
Json WriteRedesign(const redesign::RedesignOutcome& outcome, Run& run);

}  // namespace lake::commands
