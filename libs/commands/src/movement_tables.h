// What lake-track and lake-gait write of the repetitions of a recording's movement, of --angle, --distance and --speed,
// and of what a leg's measures are uncertain by.
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "lake/compare/uncertainty_budget.h"
#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/gait/leg_fit.h"
#include "lake/gait/marker_measures.h"
#include "lake/gait/sit_to_stand.h"

namespace lake::commands {

// All that both may write of a leg; NAME.png and NAME.svg are its figure.
std::vector<std::string> LegResultNames(const std::string& name);

// Writes kinematics.csv, events.csv and, of lengths in mm, uncertainty_budget.csv (`uncertainty` in the results), and
// reports the fit. Then of walking gait_cycles.csv, .png and .svg, and `walking` in the results; of squats squats.csv,
// and `squats`; else WriteSitToStands. `movement` in the results is null where none was found. `reference`: a norm of
// the knee over the gait cycle; empty: none. Returns what there is to say at the terminal of the movement.
std::string WriteMovement(const gait::LegFitResult& leg, const gait::LegMarkers& markers,
                          const compare::RecordingBudgetOptions& budget, const gait::Person& person,
                          const std::filesystem::path& reference, Json& results, Run& run);

// Writes measures.csv and measures.png of a recording in the plane, and puts `measures` into the results; nothing where
// nothing is measured.
void WriteMeasures(const motion::MarkerRecording& recording, const std::vector<gait::MarkerMeasure>& measures,
                   Json& results, Run& run);

// Of a mechanism whose range of motion must keep within limits.
// Writes range_limit.csv and range_limit.html, and puts `range_limit` into the results: the smallest and largest knee
// angle of the recording with their expanded uncertainty U (k = 2), each against its limit (degrees, the lower one
// first), in the frame that is nearest to it with its U. An end passes if it keeps within the limit by U or more
// (ILAC-G8:09/2019: guard band U); it is "not shown" where more than 5 % of the frames between the first and the last
// known angle have none. The markers are those of a mechanism: there is no soft tissue in U, and the budget's placement
// is that of all three beside the joints' axes.
// Throws Error where lengths are in px, as the budget needs mm.
void WriteRangeLimit(const gait::LegFitResult& leg, compare::RecordingBudgetOptions budget,
                     const std::array<double, 2>& limit_deg, Json& results, Run& run);

}  // namespace lake::commands
