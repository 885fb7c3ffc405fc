#include "lake/figure/misalignment_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "lake/core/colours.h"
#include "lake/core/statistics.h"
#include "lake/figure/gnuplot.h"

namespace lake::figure {
namespace {

using Eigen::Vector2d;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr const char* kFrame =
    "set border 3 lc rgb '#222222'; set tics nomirror out scale 0.6; set grid lc rgb '#EEEEEE'";

// A figure's table of points.
struct Points {
  std::vector<double> x, y;

  void Add(const Vector2d& p) { x.push_back(p.x()), y.push_back(p.y()); }
  void Break() { x.push_back(kNaN), y.push_back(kNaN); }
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
  for (std::size_t i = 0; i < compare::kPercentSamples; i += 5)
    points.Add(m.human.knee[i]), points.Add(m.exo.knee[i]), points.Break();
  return points;
}

Points LegsOf(const compare::StsCurve& curve) {
  Points points;
  for (const std::size_t i : {0, 50, 100})
    points.Add(curve.ankle[i]), points.Add(curve.knee[i]), points.Add(curve.hip[i]), points.Break();
  return points;
}

std::vector<double> Percents() {
  std::vector<double> percents;
  for (int i = 0; i < compare::kPercentSamples; ++i) percents.push_back(i);
  return percents;
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

void DrawLegs(GnuplotFigure& figure, const compare::Misalignment& m) {
  figure.Line(
      "set lmargin at screen 0.06; set rmargin at screen 0.40; set tmargin at screen 0.90; set bmargin at screen 0.10");
  figure.Line(
      "set size ratio -1; set offsets graph 0.08, graph 0.08, graph 0.03, graph 0.03; set key off; set xtics 200");
  const std::string human_legs = LegsOf(m.human).In(figure), exo_legs = LegsOf(m.exo).In(figure);
  const std::string human = PathOf(m.human.knee).In(figure), exo = PathOf(m.exo.knee).In(figure);
  figure.Line(fmt::format(
      "plot {} using 1:2 with linespoints lw 1.5 pt 7 ps 0.6 lc rgb '{}', {} using 1:2 with linespoints lw 1.5 dt 2 pt "
      "6 ps 0.8 lc "
      "rgb '{}', {} using 1:2 with lines lw 3 lc rgb '{}', {} using 1:2 with lines lw 3 lc rgb '{}'",
      human_legs, colour::kHuman, exo_legs, colour::kExoskeleton, human, colour::kHuman, exo, colour::kExoskeleton));
}

void DrawKneePaths(GnuplotFigure& figure, const compare::Misalignment& m) {
  figure.Line("set lmargin at screen 0.49; set rmargin at screen 0.98; set xtics autofreq");
  figure.Line(
      "set offsets graph 0.08, graph 0.08, graph 0.08, graph 0.22; set key top right samplen 2 spacing 1.2 "
      "noautotitle");
  const std::string ties = TiesOf(m).In(figure);
  const std::string human = PathOf(m.human.knee).In(figure), exo = PathOf(m.exo.knee).In(figure);
  const std::string human_dots = PathOf(m.human.knee, 25).In(figure), exo_dots = PathOf(m.exo.knee, 25).In(figure);
  std::string plot =
      fmt::format("plot {} using 1:2 with lines lw 1 lc rgb '#999999' title 'same percent, every 5 %'", ties);
  plot += fmt::format(", {} using 1:2 with lines lw 4 lc rgb '{}' title 'human knee'", human, colour::kHuman);
  plot += fmt::format(", {} using 1:2 with lines lw 4 lc rgb '{}' title 'exoskeleton knee'", exo, colour::kExoskeleton);
  plot += fmt::format(", {} using 1:2 with points pt 7 ps 1.5 lc rgb '{}'", human_dots, colour::kHuman);
  plot += fmt::format(", {} using 1:2 with points pt 5 ps 1.3 lc rgb '{}' title '0, 25, 50, 75, 100 %'", exo_dots,
                      colour::kExoskeleton);
  figure.Line(plot);
}

void DrawError(GnuplotFigure& figure, const compare::Misalignment& m) {
  const std::vector<double> percents = Percents(), error = Scaled(m.relative_error, 100);
  std::vector<double> lower, upper, spikes;
  for (std::size_t i = 0; i < compare::kPercentSamples; ++i) {
    const double sd = m.relative_error_sd.empty() ? 0 : 100 * m.relative_error_sd[i];
    lower.push_back(std::max(0.0, error[i] - sd)), upper.push_back(error[i] + sd);
    spikes.push_back(m.spike[i] ? error[i] : kNaN);
  }
  const double top = 1.25 * *std::max_element(upper.begin(), upper.end());
  figure.Line(
      "set tmargin at screen 0.90; set bmargin at screen 0.57; set lmargin at screen 0.07; set rmargin at screen 0.98");
  figure.Line(fmt::format("set ylabel 'relative error (% of the shank)'; set yrange [0:{}]; set format x ''",
                          std::max(top, 1e-3)));
  std::string plot = "plot ";
  if (!m.relative_error_sd.empty())
    plot += fmt::format(
        "{} using 1:2:3 with filledcurves fc rgb '{}' fs transparent solid 0.25 noborder title '± SD over pairs of "
        "repetitions', ",
        figure.Data({percents, lower, upper}), colour::kExoskeleton);
  plot += fmt::format("{} using 1:2 with lines lw 3 lc rgb '{}' title 'relative error'", figure.Data({percents, error}),
                      colour::kExoskeleton);
  plot += fmt::format(", {} with lines lw 2 dt 2 lc rgb '{}' title 'RMS {:.2f} %'", 100 * m.metrics.relative_rms,
                      colour::kText, 100 * m.metrics.relative_rms);
  plot += fmt::format(", {} with lines lw 2 dt 3 lc rgb '#0072B2' title 'noise floor {:.2f} %'",
                      100 * m.noise_floor_relative, 100 * m.noise_floor_relative);
  if (std::count(m.spike.begin(), m.spike.end(), true) > 0)
    plot += fmt::format(", {} using 1:2 with points pt 6 ps 2 lw 2 lc rgb '#CC79A7' title 'spike'",
                        figure.Data({percents, spikes}));
  figure.Line(plot);
}

void DrawParts(GnuplotFigure& figure, const compare::Misalignment& m) {
  const compare::Decomposition& d = m.decomposition;
  const std::vector<double> percents = Percents();
  figure.Line(
      "set tmargin at screen 0.47; set bmargin at screen 0.10; set rmargin at screen 0.48; set format x '%g'; set "
      "xlabel 'sit-to-stand (%)'");
  figure.Line("set ylabel 'size of the part (mm)'; set yrange [0:*]; set offsets 0, 0, graph 0.35, 0");
  const auto part = [&](const std::vector<Vector2d>& vectors, const char* name, double fraction, const char* style) {
    const std::string share = std::isfinite(fraction) ? fmt::format(" {:.1f} %", 100 * fraction) : "";
    return fmt::format("{} using 1:2 with lines lw 3 {} title '{}{}'", figure.Data({percents, Lengths(vectors)}), style,
                       name, share);
  };
  const std::string placement = part(d.placement_mm, "placement", d.placement, "lc rgb '#0072B2'");
  const std::string timing = part(d.timing_mm, "timing", d.timing, "dt 2 lc rgb '#009E73'");
  const std::string shape = part(d.shape_mm, "shape", d.shape, "dt 4 lc rgb '#CC79A7'");
  figure.Line("plot " + placement + ", " + timing + ", " + shape);
}

void DrawAngles(GnuplotFigure& figure, const compare::Misalignment& m) {
  const std::vector<double> percents = Percents();
  figure.Line(
      "set lmargin at screen 0.56; set rmargin at screen 0.98; set yrange [*:*]; set ylabel 'knee flexion (°)'; set "
      "offsets 0, 0, graph 0.15, 0");
  const std::string human = figure.Data({percents, m.human.knee_deg}), exo = figure.Data({percents, m.exo.knee_deg});
  figure.Line(
      fmt::format("plot {} using 1:2 with lines lw 3 lc rgb '{}' title 'human', {} using 1:2 with lines lw 3 dt 2 lc "
                  "rgb '{}' title "
                  "'exoskeleton, RMSE {:.2f}°'",
                  human, colour::kHuman, exo, colour::kExoskeleton, m.metrics.knee_rmse_deg));
}

}  // namespace

void DrawOverlayFigure(const std::filesystem::path& path, const compare::Misalignment& misalignment,
                       const std::string& title) {
  GnuplotFigure figure(1600, 900);
  figure.Line(fmt::format("set multiplot title {} noenhanced font ',14'", QuoteForGnuplot(title)));
  figure.Line(kFrame).Line("set xlabel 'anterior (mm)'; set ylabel 'up (mm)' offset 1,0");
  DrawLegs(figure, misalignment);
  DrawKneePaths(figure, misalignment);
  figure.Line("unset multiplot").Write(path);
}

void DrawMisalignmentFigure(const std::filesystem::path& path, const compare::Misalignment& misalignment,
                            const std::string& title) {
  GnuplotFigure figure(1600, 1000);
  figure.Line(fmt::format("set multiplot title {} noenhanced font ',14'", QuoteForGnuplot(title)));
  figure.Line(kFrame).Line("set xrange [0:100]; set key top right horizontal samplen 2.5 noautotitle");
  DrawError(figure, misalignment);
  DrawParts(figure, misalignment);
  DrawAngles(figure, misalignment);
  figure.Line("unset multiplot").Write(path);
}

}  // namespace lake::figure
