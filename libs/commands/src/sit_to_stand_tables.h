// What lake-track and lake-gait write of a recording's sit-to-stands.
#pragma once

#include <optional>

#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/gait/leg_fit.h"

namespace lake::commands {

// Writes sit_to_stand.csv and the page sit_to_stand.html, and puts `five_times` into the results; at an age, page and
// results compare the five-times test with people of that age.
void WriteSitToStands(const gait::LegFitResult& leg, std::optional<double> age_years, Json& results, Run& run);

}  // namespace lake::commands
