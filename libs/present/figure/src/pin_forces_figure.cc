#include <algorithm>
#include <cmath>

#include "lake/core/colours.h"
#include "lake/figure/charts.h"
#include "lake/figure/design_figures.h"

namespace lake::figure {
namespace {

using report::LineChart, report::Mark, report::Series;

constexpr const char* kActuatorColour = "#CC0000";

// As much of the forces as a reader wants to see.
double ShownForce(const std::vector<PinForcesRow>& rows) {
  double least = HUGE_VAL, most = 0;
  for (const PinForcesRow& row : rows) {
    const double force = row.forces.TipPin();
    if (!std::isfinite(force) || force == 0) continue;
    least = std::min(least, force);
    most = std::max(most, force);
  }
  return most > 0 ? 1.1 * std::min(most, 5 * least) : 1;
}

// With room below, and none below zero where every member pushes.
double LeastMemberForce(const std::vector<PinForcesRow>& rows) {
  double least = 0;
  for (const PinForcesRow& row : rows)
    for (const double force : {row.forces.actuator_n, row.forces.coupler_n, row.forces.bar_n})
      if (force < least) least = force;
  return 1.1 * least;
}

template <typename Force>
Series ForceOf(const std::vector<PinForcesRow>& rows, const char* name, const char* colour, Mark mark, Force force) {
  Series series{.name = name, .colour = colour, .mark = mark};
  for (const PinForcesRow& row : rows) {
    series.x.push_back(row.knee_deg);
    series.y.push_back(force(row.forces));
  }
  return series;
}

}  // namespace

void DrawPinForces(const std::filesystem::path& path, const std::vector<PinForcesRow>& rows) {
  using Forces = linkage::MemberForces;
  const double shown_n = ShownForce(rows);
  const LineChart members{
      .x = {.label = "knee angle θ (°)"},
      .y = {.label = "force, push positive (N)", .from = std::max(-shown_n, LeastMemberForce(rows)), .to = shown_n},
      .series = {
          ForceOf(rows, "actuator", kActuatorColour, Mark::kLine, [](const Forces& f) { return f.actuator_n; }),
          ForceOf(rows, "coupler RS", colour::kWaist, Mark::kDashed, [](const Forces& f) { return f.coupler_n; }),
          ForceOf(rows, "slewing bar PR", colour::kNew, Mark::kDotted, [](const Forces& f) { return f.bar_n; })}};
  const LineChart pins{
      .x = {.label = "knee angle θ (°)"},
      .y = {.label = "pin force (N)", .from = 0, .to = shown_n},
      .series = {
          ForceOf(rows, "tip R", colour::kText, Mark::kLine, [](const Forces& f) { return f.TipPin(); }),
          ForceOf(rows, "thigh pin P", colour::kNew, Mark::kDotted, [](const Forces& f) { return f.ThighPin(); }),
          ForceOf(rows, "knee K, shank pin S", colour::kWaist, Mark::kDashed,
                  [](const Forces& f) { return f.KneePin(); }),
          ForceOf(rows, "mount M", kActuatorColour, Mark::kThin,
                  [](const Forces& f) { return std::abs(f.actuator_n); })}};
  DrawCharts(path, {members, pins});
}

}  // namespace lake::figure
