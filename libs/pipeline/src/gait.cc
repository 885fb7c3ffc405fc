#include "lake/pipeline/gait.h"

#include <fmt/format.h>

#include "lake/core/error.h"
#include "lake/render/leg_figure.h"

namespace lake {
namespace {

void SayWarnings(const Trial& trial, const LegFitResult& result, Run& run) {
  for (const std::string& warning : trial.warnings) run.Warn(warning);
  for (const std::string& warning : result.warnings) run.Warn(warning);
  if (result.motion.unit == LengthUnit::kPx) run.Warn("the trial has no scale: lengths are in px");
  const double shank = result.segments.front().length;
  constexpr double kShortestMm = 100, kLongestMm = 1000;
  if (result.motion.unit == LengthUnit::kMm && (shank < kShortestMm || shank > kLongestMm))
    run.Warn(fmt::format("the shank is {:.3g} mm long: is the file in another unit? Give it with --unit", shank));
  if (result.events.empty()) run.Warn("no sit-to-stand found: repetition and percent are left empty");
}

}  // namespace

double MmPerUnit(const std::string& unit) {
  const std::optional<double> mm_per_unit = FindMmPerUnit(unit);
  if (!mm_per_unit) throw UsageError(fmt::format("--unit '{}': mm, cm or m", unit));
  return *mm_per_unit;
}

Facing ParseFacing(const std::string& text) {
  if (text != "left" && text != "right") throw UsageError(fmt::format("--facing '{}': left or right", text));
  return text == "left" ? Facing::kLeft : Facing::kRight;
}

LegFitResult FitTrial(const GaitRunOptions& options, Run& run) {
  const Trial trial = ReadTrial(options.trial, options.reading);
  run.AddInput(trial.file);
  LegFitOptions fit = options.fit;
  fit.quiet = run.Quiet();
  if (trial.faces_right && !fit.facing) fit.facing = *trial.faces_right ? Facing::kRight : Facing::kLeft;
  const LegView view = MakeLegView(trial.recording.unit, std::nullopt, trial.mm_per_px);
  LegFitResult result = FitLeg(trial.recording, view, fit);
  SayWarnings(trial, result, run);
  return result;
}

Json RunGait(const GaitRunOptions& options, Run& run) {
  const LegFitResult result = FitTrial(options, run);
  WriteKinematicsCsv(run.Result("kinematics.csv"), result.motion);
  WriteEventsCsv(run.Result("events.csv"), result.events);
  if (result.trajectory.unit == LengthUnit::kMm) WriteMarkerCsv(run.Result("trajectory.csv"), result.trajectory);
  if (result.tracks.unit == LengthUnit::kPx) WriteMarkerCsv(run.Result("tracks.csv"), result.tracks);
  DrawLegFigure(run.Result("gait.png"), result, options.trial.filename().string());
  return LegFitJson(result);
}

}  // namespace lake
