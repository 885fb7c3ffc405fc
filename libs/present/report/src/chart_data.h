// Charts as the data that page/charts.js draws.
#pragma once

#include "lake/core/json.h"
#include "lake/report/report.h"

namespace lake::report {

// Throw Error for columns of unequal length.
Json ChartData(const LineChart& chart);
Json ChartData(const BarChart& chart);

}  // namespace lake::report
