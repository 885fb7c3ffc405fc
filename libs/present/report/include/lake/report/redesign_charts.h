// Charts of a re-optimised design, of what lake-optimize's summary has of it.
#pragma once

#include "lake/core/json.h"
#include "lake/report/report.h"

namespace lake::report {

// Range against the least path difference, a line per stroke program; the designs before and after, the limit.
LineChart ParetoChart(const Json& redesign);

}  // namespace lake::report
