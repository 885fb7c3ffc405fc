// What lake-track and lake-gait write of a recording's sit-to-stands.
#pragma once

#include <string>

#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/gait/leg_fit.h"
#include "lake/gait/sit_to_stand.h"

namespace lake::commands {

// Writes sit_to_stand.csv and the page sit_to_stand.html, and puts `five_times` into the results; where age or sex are
// known, page and results compare the five-times test with people like this one. `markers`: the fit's. The knee's
// angle has the standard deviation of all sources where `results` has its `uncertainty`. Returns what there is to say
// of them at the terminal.
std::string WriteSitToStands(const gait::LegFitResult& leg, const gait::LegMarkers& markers, const gait::Person& person,
                             Json& results, Run& run);

}  // namespace lake::commands
