// The charts of a report's page as a file: the same axes, series, bands and marks, drawn by gnuplot.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "lake/report/report.h"

namespace lake::figure {

// Panels of one figure, so many beside each other, row by row; each has its legend inside, above its data. To a path
// without extension as PATH.png and PATH.svg. Throws Error as GnuplotFigure::Write.
void DrawCharts(const std::filesystem::path& path, const std::vector<report::LineChart>& charts, int columns = 1,
                const std::string& title = "");

}  // namespace lake::figure
