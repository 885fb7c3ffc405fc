#include "movement_tables.h"

#include <fmt/format.h>

#include <cmath>

#include "lake/figure/gait_cycles_figure.h"
#include "lake/gait/gait_cycles.h"
#include "lake/gait/movement.h"
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

std::string WriteGaitCycles(const gait::LegFitResult& leg, Json& results, Run& run) {
  const gait::GaitCycles cycles = gait::MeasureGaitCycles(leg, AnatomicalSdDeg(results));
  results["walking"] = gait::GaitCyclesJson(cycles, leg);
  gait::WriteGaitCyclesCsv(run.Result("gait_cycles.csv"), cycles, leg.motion.unit);
  if (!cycles.strides.empty())
    DrawPngAndSvg("gait_cycles", run,
                  [&](const std::filesystem::path& path) { figure::DrawGaitCycles(path, leg, cycles); });
  return gait::GaitCyclesText(cycles, leg);
}

}  // namespace

std::string WriteMovement(const gait::LegFitResult& leg, const gait::LegMarkers& markers, const gait::Person& person,
                          Json& results, Run& run) {
  using enum gait::MovementKind;
  results["movement"] = leg.movement.kind ? Json(gait::MovementOf(*leg.movement.kind).name) : Json();
  if (leg.movement.kind == kWalking) return WriteGaitCycles(leg, results, run);
  if (leg.movement.kind == kSquat) return fmt::format("{} squats: events.csv\n", leg.events.back().repetition);
  return WriteSitToStands(leg, markers, person, results, run);
}

}  // namespace lake::commands
