#include "lake/figure/misalignment_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lake/core/colours.h"
#include "lake/core/numbers.h"
#include "lake/core/uncertain_text.h"
#include "lake/figure/gnuplot.h"
#include "percents.h"
#include "theme.h"

namespace lake::figure {
namespace {

using Eigen::Vector2d;

// A figure's table of points.
struct Points {
  std::vector<double> x, y;

  void Add(const Vector2d& p) {
    x.push_back(p.x());
    y.push_back(p.y());
  }
  void Break() {
    x.push_back(kNaN);
    y.push_back(kNaN);
  }
  std::string In(GnuplotFigure& figure) const { return figure.Data({x, y}); }
};

Points PathOf(const std::vector<Vector2d>& path, std::size_t step = 1) {
  Points points;
  for (std::size_t i = 0; i < path.size(); i += step) points.Add(path[i]);
  return points;
}

// Between both knees at every tenth percent.
Points TiesOf(const compare::Misalignment& m) {
  Points points;
  for (std::size_t i = 0; i < compare::kPercentSamples; i += 5) {
    points.Add(m.human.knee[i]);
    points.Add(m.exo.knee[i]);
    points.Break();
  }
  return points;
}

Points LegsOf(const compare::StsCurve& curve) {
  Points points;
  for (const std::size_t i : {0, 50, 100}) {
    points.Add(curve.ankle[i]);
    points.Add(curve.knee[i]);
    points.Add(curve.hip[i]);
    points.Break();
  }
  return points;
}

std::vector<double> Scaled(const std::vector<double>& values, double factor) {
  std::vector<double> scaled;
  for (const double value : values) scaled.push_back(factor * value);
  return scaled;
}

std::vector<double> Lengths(const std::vector<Vector2d>& vectors) {
  std::vector<double> lengths;
  for (const Vector2d& v : vectors) lengths.push_back(v.norm());
  return lengths;
}

// The legs at 0, 50 and 100 %, each named at its hip; of walking they hang from one hip, and 100 % is 0 % again.
void DrawLegs(GnuplotFigure& figure, const compare::Misalignment& m) {
  figure.Line(
      "set lmargin at screen 0.075; set rmargin at screen 0.42; set tmargin at screen 0.93; set bmargin at screen "
      "0.12");
  const bool is_walking = m.movement == gait::MovementKind::kWalking;
  figure.Line(
      "set size ratio -1; set offsets graph 0.12, graph 0.12, graph 0.1, graph 0.03; set key off; set xtics 200; set "
      "title 'Leg at 0, 50 and 100 %{}'",
      is_walking ? ", relative to the hip" : "");
  for (const std::size_t percent : {0, 50, 100}) {
    if (is_walking && percent == 100) continue;
    const Vector2d at = is_walking ? m.human.ankle[percent] : m.human.hip[percent];
    figure.Line("set label '{} %' at {},{} right offset -1,0.4", percent, at.x(), at.y());
  }
  const std::string human_legs = LegsOf(m.human).In(figure), exo_legs = LegsOf(m.exo).In(figure);
  const std::string human = PathOf(m.human.knee).In(figure), exo = PathOf(m.exo.knee).In(figure);
  figure.Line(
      "plot {} using 1:2 with linespoints lw 2.5 pt 7 ps 0.8 lc rgb '{}', {} using 1:2 with linespoints lw 2 dt {} pt "
      "6 ps 1 lc rgb '{}', {} using 1:2 with lines {}, {} using 1:2 with lines {}",
      human_legs, kHumanPath.colour, exo_legs, kWornPath.dash, kWornPath.colour, human, LineOf(kHumanPath), exo,
      LineOf(kWornPath));
  figure.Line("unset label");
  if (is_walking) figure.Line("set ytics 40");  // of low and wide paths
}

void DrawKneePaths(GnuplotFigure& figure, const compare::Misalignment& m) {
  figure.Line(
      "set lmargin at screen 0.53; set rmargin at screen 0.97; set xtics autofreq; set title 'Knees, enlarged'");
  figure.Line(
      "set offsets graph 0.06, graph 0.06, graph 0.06, graph 0.06; set key at screen 0.985, screen 0.9 right top width "
      "-2");
  const std::string ties = TiesOf(m).In(figure);
  const std::string human = PathOf(m.human.knee).In(figure), exo = PathOf(m.exo.knee).In(figure);
  const std::string human_dots = PathOf(m.human.knee, 25).In(figure), exo_dots = PathOf(m.exo.knee, 25).In(figure);
  std::string plot =
      fmt::format("plot {} using 1:2 with lines lw 1 lc rgb '{}' title 'same moment, every 5 %'", ties, colour::kGuide);
  plot += fmt::format(", {} using 1:2 with lines {} title 'human knee'", human, LineOf(kHumanPath));
  plot += fmt::format(", {} using 1:2 with lines {} title 'worn exoskeleton'", exo, LineOf(kWornPath));
  plot += fmt::format(", {} using 1:2 with points {} title '0, 25, 50, 75, 100 %'", human_dots, MarkOf(kHumanPath));
  plot += fmt::format(", {} using 1:2 with points {}", exo_dots, MarkOf(kWornPath));
  figure.Line(plot);
}

// A figure of the comparison as far as its interval, where there is one, knows it; both times `factor`.
template <typename Intervals>
std::string KnownTo(double value, const std::optional<Intervals>& intervals, compare::Interval Intervals::*interval,
                    double factor = 1) {
  const compare::Interval known = intervals ? (*intervals).*interval : compare::Interval{};
  return KnownText(factor * value, factor * (known.high - known.low) / 2, 1);
}

void DrawError(GnuplotFigure& figure, const compare::Misalignment& m) {
  const std::vector<double> percents = Percents(compare::kPercentSamples), error = Scaled(m.misalignment_ratio, 100);
  std::vector<double> lower, upper, spikes;
  for (std::size_t i = 0; i < compare::kPercentSamples; ++i) {
    const double sd = m.misalignment_ratio_sd.empty() ? 0 : 100 * m.misalignment_ratio_sd[i];
    lower.push_back(std::max(0.0, error[i] - sd));
    upper.push_back(error[i] + sd);
    spikes.push_back(m.spike[i] ? error[i] : kNaN);
  }
  const double top = 1.25 * *std::max_element(upper.begin(), upper.end());
  figure.Line(
      "set tmargin at screen 0.95; set bmargin at screen 0.60; set lmargin at screen 0.075; set rmargin at screen "
      "0.98");
  figure.Line("set ylabel \"path difference\\n(% of the shank length)\"; set yrange [0:{}]; set xlabel '{} (%)'",
              std::max(top, 1e-3), gait::MovementOf(m.movement).repetition);
  std::string plot = "plot ";
  if (!m.misalignment_ratio_sd.empty())
    plot += fmt::format(
        "{} using 1:2:3 with filledcurves fc rgb '{}' fs transparent solid 0.25 noborder title '± SD over pairs of "
        "repetitions', ",
        figure.Data({percents, lower, upper}), colour::kExoskeleton);
  plot += fmt::format("{} using 1:2 with lines lw 3 lc rgb '{}' title 'path difference'",
                      figure.Data({percents, error}), colour::kExoskeleton);
  const double rms_percent = 100 * m.metrics.relative_rms, floor_percent = 100 * m.noise_floor_relative;
  plot += fmt::format(", {} with lines lw 2 dt 2 lc rgb '{}' title 'RMS {} %'", rms_percent, colour::kText,
                      RoundedText(rms_percent, 1));  // the decimals that a path difference has in the report
  plot += fmt::format(", {} with lines lw 2 dt (2,4) lc rgb '#555555' title 'noise floor {} %'", floor_percent,
                      RoundedText(floor_percent, 1));
  if (std::count(m.spike.begin(), m.spike.end(), true) > 0)
    plot += fmt::format(", {} using 1:2 with points pt 6 ps 2 lw 2 lc rgb '{}' title 'spike'",
                        figure.Data({percents, spikes}), colour::kWaist);
  figure.Line(plot);
}

void DrawParts(GnuplotFigure& figure, const compare::Misalignment& m) {
  const compare::Decomposition& d = m.decomposition;
  const std::vector<double> percents = Percents(compare::kPercentSamples);
  figure.Line("set tmargin at screen 0.46; set bmargin at screen 0.11; set rmargin at screen 0.48; set xlabel '{} (%)'",
              gait::MovementOf(m.movement).repetition);
  figure.Line("set ylabel 'size of the part (mm)'; set yrange [0:*]; set offsets 0, 0, graph 0.35, 0");
  using Intervals = compare::PartIntervals;
  const auto part = [&](const std::vector<Vector2d>& vectors, const char* name, double fraction,
                        compare::Interval Intervals::*interval, const std::string& style) {
    const std::string share =
        std::isfinite(fraction) ? fmt::format(" {} %", KnownTo(fraction, m.part_intervals, interval, 100)) : "";
    return fmt::format("{} using 1:2 with lines lw 3 {} title '{}{}'", figure.Data({percents, Lengths(vectors)}), style,
                       name, share);
  };
  const std::string placement =
      part(d.placement_mm, "placement", d.placement, &Intervals::placement, "lc rgb '#0072B2'");
  const std::string timing = part(d.timing_mm, "timing", d.timing, &Intervals::timing, "dt (12,5) lc rgb '#009E73'");
  const std::string shape =
      part(d.shape_mm, "shape", d.shape, &Intervals::shape, fmt::format("dt (3,4) lc rgb '{}'", colour::kWaist));
  figure.Line("plot " + placement + ", " + timing + ", " + shape);
}

void DrawAngles(GnuplotFigure& figure, const compare::Misalignment& m) {
  const std::vector<double> percents = Percents(compare::kPercentSamples);
  figure.Line(
      "set lmargin at screen 0.565; set rmargin at screen 0.98; set yrange [*:*]; set ylabel 'knee flexion (°)'; set "
      "offsets 0, 0, graph 0.15, 0");
  const std::string human = figure.Data({percents, m.human.knee_deg}), exo = figure.Data({percents, m.exo.knee_deg});
  figure.Line(
      "plot {} using 1:2 with lines {} title 'human', {} using 1:2 with lines {} title 'worn exoskeleton, RMS "
      "difference {}°'",
      human, LineOf(kHumanPath), exo, LineOf(kWornPath),
      KnownTo(m.metrics.knee_rmse_deg, m.intervals, &compare::MisalignmentIntervals::knee_rmse_deg));
}

}  // namespace

void DrawOverlayFigure(const std::filesystem::path& path, const compare::Misalignment& misalignment) {
  GnuplotFigure figure(1400, 760);
  figure.Line("set multiplot");
  figure.Line("set xlabel 'anterior (mm)'; set ylabel 'up (mm)' offset 1,0");
  DrawLegs(figure, misalignment);
  DrawKneePaths(figure, misalignment);
  figure.Line("unset multiplot").Write(path);
}

void DrawMisalignmentFigure(const std::filesystem::path& path, const compare::Misalignment& misalignment) {
  GnuplotFigure figure(1400, 900);
  figure.Line("set multiplot");
  figure.Line("set xrange [0:100]; set key top right horizontal");
  DrawError(figure, misalignment);
  DrawParts(figure, misalignment);
  DrawAngles(figure, misalignment);
  figure.Line("unset multiplot").Write(path);
}

}  // namespace lake::figure
