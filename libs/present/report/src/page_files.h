// The files that every page contains; compiled in by embed.cmake.
#pragma once

#include <string_view>

namespace lake::report {

std::string_view ChartLibrary();  // Chart.js
std::string_view ChartLicence();  // of the chart library, in words
std::string_view PageCharts();    // page/charts.js
std::string_view PageControls();  // page/controls.js
std::string_view PageFilters();   // page/filters.js
std::string_view PageFolds();     // page/folds.js
std::string_view PageStyle();     // page/report.css
std::string_view PageUnits();     // page/units.json

}  // namespace lake::report
