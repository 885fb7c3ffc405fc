// Charts of the comparison that only its own report has.
#pragma once

#include "lake/core/json.h"
#include "lake/report/report.h"

namespace lake::report {

report::LineChart PartsChart(const Json& comparison);
report::LineChart KneeAnglesChart(const Json& comparison);

}  // namespace lake::report
