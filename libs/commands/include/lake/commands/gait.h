// The work of lake-gait: from an existing trial, without its video, to leg motion, events and a figure.
#pragma once

#include <filesystem>
#include <string>

#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/exchange/trial.h"
#include "lake/gait/leg_fit.h"

namespace lake::commands {

struct GaitRunOptions {
  std::filesystem::path trial;  // a lake-track folder or a file that ReadTrial knows
  exchange::TrialOptions reading;
  gait::LegFitOptions fit;
};

void Describe(GaitRunOptions& o, OptionList& options);

// The one way in which lake-gait, lake-compare and lake-optimize read a trial and fit a leg to it. Warnings (of the
// file, of lengths that no leg has, of positions that were smoothed) are said through `run`, inputs recorded in it.
exchange::Trial ReadTrialFor(const std::filesystem::path& path, const exchange::TrialOptions& reading, Run& run);
gait::LegFitResult FitTrial(const exchange::Trial& trial, gait::LegFitOptions fit, Run& run);

// Writes kinematics.csv, events.csv, trajectory.csv (tracks.csv for a trial in px), gait.png; returns the results for
// the summary.
Json RunGait(const GaitRunOptions& options, Run& run);

// What a person wants to read of a summary with a leg's fit; empty without one.
std::string GaitReport(const Json& summary);

}  // namespace lake::commands
