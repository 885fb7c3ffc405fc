// What lake-gait writes of a mechanism whose range of motion must keep within limits.
#pragma once

#include <array>

#include "lake/compare/uncertainty_budget.h"
#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/gait/leg_fit.h"

namespace lake::commands {

// Writes range_limit.csv and range_limit.html, and puts `range_limit` into the results: the smallest and largest knee
// angle of the recording with their expanded uncertainty U (k = 2), each against its limit (degrees, the lower one
// first), in the frame that is nearest to it with its U. An end passes if it keeps within the limit by U or more
// (ILAC-G8:09/2019: guard band U); it is "not shown" where more than 5 % of the frames between the first and the last
// known angle have none. The markers are those of a mechanism: there is no soft tissue in U, and the budget's placement
// is that of all three beside the joints' axes.
// Throws Error where lengths are in px, as the budget needs mm.
void WriteRangeLimit(const gait::LegFitResult& leg, compare::RecordingBudgetOptions budget,
                     const std::array<double, 2>& limit_deg, Json& results, Run& run);

}  // namespace lake::commands
