// The strides of a walk over percent of the gait cycle.
#pragma once

#include <filesystem>
#include <optional>

#include "lake/gait/gait_cycles.h"
#include "lake/gait/leg_fit.h"

namespace lake::figure {

// Knee, ankle (where it is known), thigh and shank over 0 to 100 % of the cycle: each stride thin, their mean with a
// band of ± 1 SD over strides, toe-off as a line, from quiet standing where that is known; behind the knee the
// reference's band. Throws as GnuplotFigure::Write.
void DrawGaitCycles(const std::filesystem::path& path, const gait::LegFitResult& leg,
                    const gait::Measures<gait::GaitCycle>& cycles,
                    const std::optional<gait::ReferenceCurve>& reference = {});

}  // namespace lake::figure
