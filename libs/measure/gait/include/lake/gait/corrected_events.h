// A trial's events where a person knows better than what was found in its motion.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "lake/core/options.h"
#include "lake/gait/leg_fit.h"
#include "lake/motion/event_corrections.h"

namespace lake::gait {

// The option --events: the file of these rows.
void DescribeEvents(std::optional<std::filesystem::path>& file, OptionList& options);

// Puts the rows in the places of what was found; repetition and percent of each frame follow. Throws Error as
// motion::ApplyEventCorrections does.
void CorrectEvents(const std::vector<motion::EventCorrection>& corrections, LegFitResult& fit);

}  // namespace lake::gait
