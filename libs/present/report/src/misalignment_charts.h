// Charts of the comparison that only its own report has.
#pragma once

#include <optional>
#include <string>

#include "lake/core/json.h"
#include "lake/report/report.h"

namespace lake::report {

// "rise" or "stride"; of an older comparison, which does not say, a rise.
std::string RepetitionIn(const Json& comparison);
bool IsOfWalking(const Json& comparison);

// Of the joint and the knee of the leg that wears it; nullopt where the trial does not show that knee.
std::optional<report::LineChart> JointChart(const Json& comparison);
report::LineChart PartsChart(const Json& comparison);
report::LineChart KneeAnglesChart(const Json& comparison);

}  // namespace lake::report
