// What lake-track and lake-gait write of --angle, --distance and --speed.
#pragma once

#include <vector>

#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/gait/marker_measures.h"

namespace lake::commands {

// Writes measures.csv and measures.png of a recording in the plane, and puts `measures` into the results; nothing where
// nothing is measured.
void WriteMeasures(const motion::MarkerRecording& recording, const std::vector<gait::MarkerMeasure>& measures,
                   Json& results, Run& run);

}  // namespace lake::commands
