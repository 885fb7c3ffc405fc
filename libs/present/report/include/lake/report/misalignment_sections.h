// The comparison of a human trial with an exoskeleton trial, as sections of a report.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/report/report.h"
#include "lake/report/uncertain.h"

namespace lake::report {

// Of the content of comparison.json (with its curves), whether just computed or read back. Throws Json::exception for
// another content.
std::vector<Section> MisalignmentSections(const Json& comparison);

// What moving the joint leaves of its misalignment at the next rise, with the interval of the slip, stated to
// no less than a tenth of a millimetre. For a comparison whose exoskeleton trial shows the knee.
Uncertain JointMovedFigure(const Json& comparison);

// The numbers to see first.
KeyFigures MisalignmentKeyFigures(const Json& comparison);

// Its charts. That of the joint and the knee of the leg that wears it is none where the trial does not show that knee.
LineChart LegsChart(const Json& comparison);
LineChart KneePathsChart(const Json& comparison);
LineChart PathDifferenceChart(const Json& comparison);
std::optional<LineChart> JointChart(const Json& comparison);
LineChart PartsChart(const Json& comparison);
LineChart KneeAnglesChart(const Json& comparison);
BarChart DecompositionChart(const Json& comparison);

// "rise" or "stride"; of an older comparison, which does not say, a rise.
std::string RepetitionIn(const Json& comparison);
bool IsOfWalking(const Json& comparison);

// "18 mm in front of the knee and 32 mm above it along the shank", each as far as it is known.
std::string JointPlaceText(const Json& comparison);

// What the parts say to the designer, in a sentence or two.
std::string DecompositionAdvice(const Json& comparison);

}  // namespace lake::report
