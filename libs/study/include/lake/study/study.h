// The work of lake-run: all steps of a study, each by the function of the program whose work it is, and one report.
#pragma once

#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/steps/study_steps.h"
#include "lake/study/study_file.h"

namespace lake::study {

// In order; each writes into its own folder below `out`, the report into `out` itself. `head` (Run::Head()) is what the
// report says of its making.
std::vector<steps::StudyStep> StudySteps(const StudyFile& study, const std::filesystem::path& out, const Json& head);

// Does what has changed since the last time and returns the summary: the steps, and of each what its own summary.json
// says, under its name. Throws what a step throws, with the step's name.
Json RunStudyFile(const StudyFile& study, Run& run);

// The main numbers and where the report is, as text.
std::string StudyText(const Json& summary);

}  // namespace lake::study
