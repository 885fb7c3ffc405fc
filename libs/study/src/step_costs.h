// What a program's work is expected to take: by the size of the recording, the number of designs that are sought and
// what else decides, as it was measured on the sample study and larger ones (tests/benchmark/plan_cost.py). Of the
// machine that steps::MachinePace is 1 on, with two threads.
#pragma once

#include "lake/commands/calibrate.h"
#include "lake/commands/compare.h"
#include "lake/commands/gait.h"
#include "lake/commands/loads.h"
#include "lake/commands/optimize.h"
#include "lake/commands/simulate.h"
#include "lake/commands/stroke.h"
#include "lake/commands/track.h"
#include "lake/steps/step_cost.h"

namespace lake::study {

steps::StepCost CostOf(const commands::CalibrateRunOptions& options);
steps::StepCost CostOf(const commands::PlaneRunOptions& options);
steps::StepCost CostOf(const commands::TrackRunOptions& options);
steps::StepCost CostOf(const commands::GaitRunOptions& options);
steps::StepCost CostOf(const commands::CompareRunOptions& options);
steps::StepCost CostOf(const commands::LoadsRunOptions& options);
steps::StepCost CostOf(const commands::OptimizeRunOptions& options);
steps::StepCost CostOf(const commands::SimulationOptions& options);
steps::StepCost CostOf(const commands::StrokeRunOptions& options);

}  // namespace lake::study
