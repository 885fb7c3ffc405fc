// The group's tables and page.
#pragma once

#include <filesystem>

#include "lake/core/json.h"
#include "lake/core/run.h"
#include "workflow.h"

namespace lake::cohort {

// Writes trials.csv, curves.csv, reliability.csv, differences.csv, outliers.csv, failures.csv, figures and group.html
// into the run's folder, of what the workflow's studies in `out` have left. Throws Error if there is nothing at all.
Json WriteGroup(const Json& workflow, const WorkflowState& state, const std::filesystem::path& out, Run& run);

}  // namespace lake::cohort
