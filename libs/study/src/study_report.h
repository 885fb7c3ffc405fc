// The story of a study, with pictures: what was measured, what it means, and the design that comes of it.
#pragma once

#include "lake/core/json.h"
#include "lake/report/report.h"
#include "lake/study/study_file.h"
#include "study_chapters.h"

namespace lake::study {

// Of the steps' folders; a step that the study has not is left out. `head` is what Run::Head() says.
report::Report MakeStudyReport(const StudyFile& study, const StudyResults& results, const Json& head);

}  // namespace lake::study
