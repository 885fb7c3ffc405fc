// The group's tables and page.
#pragma once

#include "lake/core/json.h"
#include "lake/core/run.h"
#include "workflow.h"

namespace lake::cohort {

// Writes trials.csv, curves.csv, reliability.csv, differences.csv, outliers.csv, failures.csv, figures and group.html
// into the run's folder, of what the workflow's studies have left. Throws Error if there is nothing at all.
Json WriteGroup(const Workflow& workflow, const WorkflowState& state, Run& run);

}  // namespace lake::cohort
