#include <algorithm>
#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/colours.h"
#include "lake/drawing/linkage_figures.h"
#include "lake/figure/gnuplot.h"

namespace lake::drawing {
namespace {

// Columns: stroke, angle, moment arm, force, transmission angle, actuator angle.
std::vector<std::vector<double>> Table(const LinkageLook& look, const std::vector<double>& strokes_mm) {
  std::vector<std::vector<double>> columns(6);
  for (const double stroke : strokes_mm) {
    const linkage::Pose pose = linkage::RequirePose(look.links, stroke);
    const linkage::Transmission t = linkage::TransmissionOf(look.links, pose);
    const double row[] = {stroke,
                          DegreesFromRadians(pose.theta_rad),
                          t.moment_arm_mm,
                          std::abs(linkage::ActuatorForce(t, look.knee_torque_nm)),
                          DegreesFromRadians(t.transmission_rad),
                          DegreesFromRadians(t.actuator_rad)};
    for (int i = 0; i < 6; ++i) columns[i].push_back(row[i]);
  }
  return columns;
}

// Of strokes so close that their labels would cover each other, the first.
std::vector<double> LabelledOf(const std::vector<double>& ascending_mm, double apart_mm) {
  std::vector<double> labelled;
  for (const double stroke : ascending_mm)
    if (labelled.empty() || stroke - labelled.back() > apart_mm) labelled.push_back(stroke);
  return labelled;
}

std::vector<double> FineGrid(const linkage::StrokeRange& range) {
  constexpr int kSteps = 800;
  std::vector<double> strokes;
  for (int i = 0; i <= kSteps; ++i) strokes.push_back(range.lower_mm + range.Travel() * i / kSteps);
  return strokes;
}

void PlaceRow(figure::GnuplotFigure& figure, double bottom, double top, bool lowest) {
  figure.Line("set bmargin at screen {}\nset tmargin at screen {}", bottom, top);
  figure.Line(lowest ? "set xlabel 'stroke {/:Italic d} (mm)'\nset format x '%g'" : "unset xlabel\nset format x ''");
}

}  // namespace

void DrawAngleVsStroke(const std::filesystem::path& path, const LinkageLook& look,
                       const std::vector<double>& marked_mm) {
  figure::GnuplotFigure figure(1000, 1000);
  const auto fine = Table(look, FineGrid(look.range.stroke));
  const std::string curve = figure.Data(fine), marks = figure.Data(Table(look, marked_mm));
  const auto [shortest, longest] = std::minmax_element(marked_mm.begin(), marked_mm.end());
  const double lower = std::min(look.range.stroke.lower_mm, marked_mm.empty() ? HUGE_VAL : *shortest);
  const double upper = std::max(look.range.stroke.upper_mm, marked_mm.empty() ? -HUGE_VAL : *longest);
  const double pad = 0.02 * (upper - lower);
  const std::string labels = figure.Data(Table(look, LabelledOf(marked_mm, 0.03 * (upper - lower))));
  figure.Line("set xrange [{}:{}]", lower - pad, upper + 2.5 * pad);
  figure.Line("set lmargin at screen 0.115\nset rmargin at screen 0.88\nset key opaque box lc rgb '{}'", colour::kGrid);
  figure.Line("set multiplot");

  PlaceRow(figure, 0.57, 0.97, false);
  figure.Line(
      "set key top right\nset ylabel 'knee angle {/:Italic θ} (°)'\nset yrange [*:*]\nset offsets graph "
      "0,0,0.06,0.06");
  figure.Line(
      "plot {} using 1:2 with lines lw 3 lc rgb '{}' title 'knee angle', {} using 1:2 with points pt 7 ps 1.2 lc rgb "
      "'#222222' title 'poses shown', {} using 1:2:(sprintf('%.1f°', $2)) with labels left offset 0.9,0.5 font ',11' "
      "notitle",
      curve, colour::kNew, marks, labels);
  PlaceRow(figure, 0.32, 0.52, false);
  // Near the singular ends the force grows without bound; the axis shows at most five times its least.
  const auto [least_force, most_force] = std::minmax_element(fine[3].begin(), fine[3].end());
  const double top_n = std::min(1.1 * *most_force, 5 * *least_force);
  figure.Line("unset offsets\nset ylabel 'moment arm (mm)'\nset yrange [0:*]\nset y2tics\nset border 11");
  figure.Line(
      "set y2label 'force for {:g} N m (N)'\nset y2range [0:{}]\nset key at graph 0.5, graph 1.02 center bottom "
      "horizontal nobox",
      look.knee_torque_nm, top_n);
  figure.Line(
      "plot {0} using 1:3 with lines lw 3 lc rgb '{1}' title 'moment arm', {0} using 1:4 axes x1y2 with lines lw 2.5 "
      "dt (8,5) lc rgb '#CC0000' title 'actuator force (right)'",
      curve, colour::kHip);
  PlaceRow(figure, 0.075, 0.27, true);
  figure.Line("set label '90° transmits best' at graph 0.01, first 90 left offset 0,-0.6 font ',11'");
  figure.Line(
      "unset y2tics\nunset y2label\nset border 3\nset ylabel 'angle (°)'\nset yrange [0:180]\nset ytics 0,45,180\nset "
      "key at graph 0.5, graph 1.02 center bottom horizontal nobox");
  figure.Line(
      "plot {0} using 1:5 with lines lw 3 lc rgb '{1}' title 'transmission angle at S', {0} using 1:6 with lines lw 3 "
      "dt (12,5) lc rgb '{2}' title 'actuator angle at R', 90 with lines lw 1 dt 3 lc rgb '#888888' notitle",
      curve, colour::kWaist, "#555555");
  figure.Line("unset multiplot");
  figure.Write(path);
}

}  // namespace lake::drawing
