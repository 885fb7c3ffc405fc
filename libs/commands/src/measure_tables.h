// What lake-track and lake-gait write of --angle, --distance and --speed, and of what a leg's measures are uncertain
// by.
#pragma once

#include <vector>

#include "lake/compare/uncertainty_budget.h"
#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/gait/leg_fit.h"
#include "lake/gait/marker_measures.h"

namespace lake::commands {

// Writes measures.csv and measures.png of a recording in the plane, and puts `measures` into the results; nothing where
// nothing is measured.
void WriteMeasures(const motion::MarkerRecording& recording, const std::vector<gait::MarkerMeasure>& measures,
                   Json& results, Run& run);

// Writes uncertainty_budget.csv, and puts `uncertainty` into the results; nothing where lengths are in px.
void WriteUncertaintyBudget(const gait::LegFitResult& leg, const compare::RecordingBudgetOptions& options,
                            Json& results, Run& run);

}  // namespace lake::commands
