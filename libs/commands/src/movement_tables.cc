#include "movement_tables.h"

#include <fmt/format.h>

#include <cmath>

#include "lake/figure/gait_cycles_figure.h"
#include "lake/gait/gait_cycles.h"
#include "lake/gait/movement.h"
#include "lake/gait/squats.h"
#include "png_and_svg.h"
#include "sit_to_stand_tables.h"

namespace lake::commands {
namespace {

// Of the knee's angle from all sources, where the recording has lengths in mm.
double AnatomicalSdDeg(const Json& results) {
  if (!results.contains("uncertainty")) return 0;
  const double sd_deg = NumberOrNaN(results.at("uncertainty").at("knee_angle_deg").at("anatomical_sd"));
  return std::isfinite(sd_deg) ? sd_deg : 0;
}

std::string WriteGaitCycles(const gait::LegFitResult& leg, const std::filesystem::path& reference, Json& results,
                            Run& run) {
  std::optional<gait::ReferenceCurve> curve;
  if (!reference.empty()) curve = gait::ReadReferenceCurve(reference);
  if (curve && !leg.motion.neutral)
    run.Warn(
        "--reference: a norm is of angles from the person's own standing, and 0° here is where the markers say so: "
        "give "
        "--neutral, else a shift against the norm means nothing");
  const gait::GaitCycles cycles = gait::MeasureGaitCycles(leg, AnatomicalSdDeg(results));
  results["walking"] = gait::GaitCyclesJson(cycles, leg);
  gait::WriteGaitCyclesCsv(run.Result("gait_cycles.csv"), cycles, leg.motion.unit);
  if (!cycles.strides.empty())
    DrawPngAndSvg("gait_cycles", run,
                  [&](const std::filesystem::path& path) { figure::DrawGaitCycles(path, leg, cycles, curve); });
  return gait::GaitCyclesText(cycles, leg);
}

std::string WriteSquats(const gait::LegFitResult& leg, Json& results, Run& run) {
  const gait::Squats squats = gait::MeasureSquats(leg);
  results["squats"] = gait::SquatsJson(squats, leg.motion.unit);
  gait::WriteSquatsCsv(run.Result("squats.csv"), squats, leg.motion.unit);
  return gait::SquatsText(squats, leg.motion.unit);
}

}  // namespace

std::string WriteMovement(const gait::LegFitResult& leg, const gait::LegMarkers& markers, const gait::Person& person,
                          const std::filesystem::path& reference, Json& results, Run& run) {
  using enum gait::MovementKind;
  results["movement"] = leg.movement.kind ? Json(gait::MovementOf(*leg.movement.kind).name) : Json();
  if (leg.movement.kind == kWalking) return WriteGaitCycles(leg, reference, results, run);
  if (leg.movement.kind == kSquat) return WriteSquats(leg, results, run);
  return WriteSitToStands(leg, markers, person, results, run);
}

}  // namespace lake::commands
