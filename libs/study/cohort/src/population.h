// The step of a cohort after everybody's comparison: one design for all, or several sizes.
#pragma once

#include <filesystem>

#include "lake/cohort/cohort_file.h"
#include "lake/cohort/group_data.h"
#include "lake/core/json.h"
#include "lake/core/run.h"

namespace lake::cohort {

// In group/population of `out`, if anything that it is made of has changed. Each participant counts once, with the
// first recordings whose comparison has been done. Throws Error where fewer than two participants have one.
void RunPopulation(const Cohort& cohort, const Json& workflow, const StepsDone& done, const std::filesystem::path& out,
                   const Run& run);

}  // namespace lake::cohort
