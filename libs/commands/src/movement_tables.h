// What lake-track and lake-gait write of the repetitions of a recording's movement.
#pragma once

#include <filesystem>
#include <string>

#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/gait/leg_fit.h"
#include "lake/gait/sit_to_stand.h"

namespace lake::commands {

// `reference`: a norm of the knee over the gait cycle; empty: none. Of walking gait_cycles.csv, .png and .svg, and
// `walking` in the results; of squats squats.csv, and `squats`; else WriteSitToStands. `movement` in the results is
// null where none was found. Returns what there is to say at the terminal.
std::string WriteMovement(const gait::LegFitResult& leg, const gait::LegMarkers& markers, const gait::Person& person,
                          const std::filesystem::path& reference, Json& results, Run& run);

}  // namespace lake::commands
