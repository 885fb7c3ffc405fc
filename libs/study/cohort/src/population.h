// The step of a cohort after everybody's comparison: one design for all, or several sizes.
#pragma once

#include "lake/cohort/cohort_file.h"
#include "lake/core/run.h"
#include "workflow.h"

namespace lake::cohort {

// In group/population of the results, if anything that it is made of has changed. Each participant counts once, with
// the first recordings whose comparison has been done. Throws Error where fewer than two participants have one.
void RunPopulation(const Cohort& cohort, const Workflow& workflow, const StepsDone& done, const Run& run);

}  // namespace lake::cohort
