// The work of lake-gait: from an existing trial, without its video, to leg motion, events and a figure.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/commands/further_inputs.h"
#include "lake/compare/uncertainty_budget.h"
#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/exchange/trial.h"
#include "lake/gait/leg_fit.h"
#include "lake/gait/marker_measures.h"
#include "lake/gait/picture_scale.h"
#include "lake/gait/sit_to_stand.h"

namespace lake::commands {

// Camera and scale bar are for trials in px.
struct GaitRunOptions : gait::PictureScale, FurtherInputs {
  std::filesystem::path trial;  // a lake-track folder or a file that ReadTrial knows
  exchange::TrialOptions reading;
  gait::LegFitOptions fit;
  std::optional<std::filesystem::path> events;  // repetition,event,time_s or frame: overrule those found
  gait::Person person;                          // whom the five-times test is compared with
  std::vector<gait::MarkerMeasure> measures;    // of any markers; with them a trial need not have a leg
  compare::RecordingBudgetOptions budget;
  std::optional<std::array<double, 2>> range_limit_deg;  // that a mechanism's knee must keep within
  std::string compare_with;  // an angle of another program's model in the same C3D; empty: none
};

void Describe(GaitRunOptions& o, OptionList& options);

// The trial and its fit alone, for programs that measure something else.
void DescribeTrialFit(GaitRunOptions& o, OptionList& options);

std::vector<InputFile> InputsOf(const GaitRunOptions& options);

// What the fit of a trial reads: the file, or of a folder (which need not be there yet) the markers and events.
std::vector<InputFile> TrialInputs(const std::filesystem::path& trial, const std::string& role);
bool IsTrialFolder(const std::filesystem::path& trial);

// The one way in which lake-gait, lake-compare and lake-optimize read a trial and fit a leg to it. Warnings (of the
// file, of lengths that no leg has, of positions that were smoothed) are said through `run`. Events that a person moved
// in a folder are those of every fit of its trial. Throws UsageError for a camera or scale bar, given by `picture`,
// that a trial in mm has no use for. `events`: corrections of those found, before warnings are said of them. Of
// `further` the forces' events win over the markers'.
exchange::Trial ReadTrialFor(const std::filesystem::path& path, const exchange::TrialOptions& reading,
                             const gait::PictureScale& picture = {});
gait::LegFitResult FitTrial(const exchange::Trial& trial, gait::LegFitOptions fit, Run& run,
                            const gait::PictureScale& picture = {},
                            const std::optional<std::filesystem::path>& events = {}, const FurtherInputs& further = {});

// Of a trial with technical markers and a visible knee: what it says of where they carry the knee, for the summary.
void LearnKnee(const gait::LegFitResult& fit, const gait::LegFitOptions& options, const gait::LateralPlaces& lateral,
               Json& results, Run& run);

// Puts the rows of this file in the places of the fit's events, and returns what a summary says of that. Throws Error
// naming file and line.
Json CorrectEventsBy(const std::filesystem::path& file, gait::LegFitResult& fit);

// The fit's warnings, and those of its events: to be said once these are corrected.
void WarnOfFit(const gait::LegFitResult& fit, Run& run);

// Writes kinematics.csv, events.csv, range_limit.csv and .html where limits are given, trajectory.csv (tracks.csv for a
// trial in px), gait.png, and measures.csv and measures.png of what is measured; of a trial without ankle, knee and hip
// the latter alone. Returns the results for the summary.
Json RunGait(const GaitRunOptions& options, Run& run);

}  // namespace lake::commands
