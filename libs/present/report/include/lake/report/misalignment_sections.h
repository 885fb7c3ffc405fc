// The comparison of a human trial with an exoskeleton trial, as sections of a report.
#pragma once

#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/report/report.h"

namespace lake::report {

// Of the content of comparison.json (with its curves), whether just computed or read back. Throws Json::exception for
// another content.
std::vector<report::Section> MisalignmentSections(const Json& comparison);

// For a longer story: the numbers to see first, and the charts of the paths and of the error alone.
report::KeyFigures MisalignmentKeyFigures(const Json& comparison);
report::LineChart KneePathsChart(const Json& comparison);
report::LineChart PathDifferenceChart(const Json& comparison);
report::BarChart DecompositionChart(const Json& comparison);

// What the parts say to the designer, in a sentence or two.
std::string DecompositionAdvice(const Json& comparison);

}  // namespace lake::report
