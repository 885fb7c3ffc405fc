#include "lake/figure/pin_forces_figure.h"

#include <algorithm>
#include <cmath>

#include "lake/figure/gnuplot.h"
#include "theme.h"

namespace lake::figure {
namespace {

// Columns: knee angle, actuator, coupler, bar along the members; tip, thigh and knee pin.
std::vector<std::vector<double>> Columns(const std::vector<PinForcesRow>& rows) {
  std::vector<std::vector<double>> columns(7);
  for (const PinForcesRow& row : rows) {
    const linkage::MemberForces& forces = row.forces;
    const double values[] = {row.knee_deg,    forces.actuator_n, forces.coupler_n, forces.bar_n,
                             forces.TipPin(), forces.ThighPin(), forces.KneePin()};
    for (std::size_t i = 0; i < columns.size(); ++i) columns[i].push_back(values[i]);
  }
  return columns;
}

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

void PlacePanel(GnuplotFigure& figure, double bottom, double top) {
  figure.Line("set bmargin at screen {}\nset tmargin at screen {}", bottom, top);
}

}  // namespace

void DrawPinForces(const std::filesystem::path& path, const std::vector<PinForcesRow>& rows) {
  GnuplotFigure figure(1000, 900);
  const std::string table = figure.Data(Columns(rows));
  const double shown_n = ShownForce(rows);
  figure.Line("set lmargin at screen 0.13\nset rmargin at screen 0.97\nset multiplot");
  figure.Line("set key at graph 0.5, graph 1.02 center bottom horizontal");
  PlacePanel(figure, 0.54, 0.94);
  figure.Line("set format x ''\nset ylabel 'force, push positive (N)'\nset yrange [{}:{}]",
              std::max(-shown_n, LeastMemberForce(rows)), shown_n);
  figure.Line(
      "plot {0} using 1:2 with lines lw 3.5 lc rgb '#CC0000' title 'actuator', {0} using 1:3 with lines lw 3 dt (12,5) "
      "lc rgb '{1}' title 'coupler RS', {0} using 1:4 with lines lw 3 dt (3,4) lc rgb '{2}' title 'slewing bar PR', 0 "
      "with lines lw 1 lc rgb '{3}'",
      table, colour::kWaist, colour::kNew, colour::kText);
  PlacePanel(figure, 0.09, 0.46);
  figure.Line(
      "set format x '%g'\nset xlabel 'knee angle {{/:Italic θ}} (°)'\nset ylabel 'pin force (N)'\nset yrange [0:{}]",
      shown_n);
  figure.Line(
      "plot {0} using 1:5 with lines lw 3.5 lc rgb '{1}' title 'tip R', {0} using 1:6 with lines lw 3 dt (3,4) lc rgb "
      "'{2}' title 'thigh pin P', {0} using 1:7 with lines lw 3 dt (12,5) lc rgb '{3}' title 'knee K, shank pin S', "
      "{0} using 1:(abs($2)) with lines lw 2 lc rgb '#CC0000' title 'mount M'",
      table, colour::kText, colour::kNew, colour::kWaist);
  figure.Line("unset multiplot").Write(path);
}

}  // namespace lake::figure
