// What a program's work is expected to take, as it was measured on the sample study and larger ones
// (tests/benchmark/plan_cost.py): so much for each frame, for each million pixels of it, for each start of a search,
// and so much for what does not depend on these. Of the machine that steps::MachinePace is 1 on.
#pragma once

#include "lake/commands/calibrate.h"
#include "lake/commands/compare.h"
#include "lake/commands/gait.h"
#include "lake/commands/optimize.h"
#include "lake/commands/simulate.h"
#include "lake/commands/stroke.h"
#include "lake/commands/track.h"
#include "lake/steps/step_cost.h"
#include "lake/study/study_file.h"

namespace lake::study {

steps::StepCost CostOf(const commands::CalibrateRunOptions& options);
steps::StepCost CostOf(const commands::PlaneRunOptions& options);
steps::StepCost CostOf(const commands::TrackRunOptions& options);
steps::StepCost CostOf(const commands::GaitRunOptions& options);
steps::StepCost CostOf(const commands::CompareRunOptions& options);
steps::StepCost CostOfLoads(const StudyTrial& trial);  // of this trial, which need not have been tracked yet
steps::StepCost CostOf(const commands::OptimizeRunOptions& options);
steps::StepCost CostOf(const commands::SimulationOptions& options);
steps::StepCost CostOf(const commands::StrokeRunOptions& options);

}  // namespace lake::study
