// The comparison of a human trial with an exoskeleton trial, as sections of a report.
#pragma once

#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/report/report.h"
#include "lake/report/uncertain.h"

namespace lake::report {

// Of the content of comparison.json (with its curves), whether just computed or read back. Throws Json::exception for
// another content.
std::vector<report::Section> MisalignmentSections(const Json& comparison);

// A figure of the joint with its interval (95 %) of all sources, the skin among them, on which a decision rests. Of
// joint_rms_mm, joint_offset_x_mm or joint_offset_y_mm; the interval is unknown where the comparison has no budget.
Uncertain JointFigure(const Json& comparison, const std::string& quantity);

// What moving the joint leaves of its misalignment at the next rise, with the interval of the slip, stated to
// no less than a tenth of a millimetre. For a comparison whose exoskeleton trial shows the knee.
Uncertain JointMovedFigure(const Json& comparison);

// For a longer story: the numbers to see first, and the charts of the paths and of the error alone.
report::KeyFigures MisalignmentKeyFigures(const Json& comparison);
report::LineChart KneePathsChart(const Json& comparison);
report::LineChart PathDifferenceChart(const Json& comparison);
report::BarChart DecompositionChart(const Json& comparison);

// What the parts say to the designer, in a sentence or two.
std::string DecompositionAdvice(const Json& comparison);

}  // namespace lake::report
