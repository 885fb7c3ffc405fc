#include <algorithm>
#include <cmath>

#include "lake/core/colours.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/figure/design_figures.h"
#include "lake/figure/gnuplot.h"

namespace lake::figure {
namespace {

// Zero on a logarithmic axis.
constexpr double kFloor = 1e-16;

struct Range {
  double lower, upper;
};

// Grey boxes over the stretches of a link's changes at which it cannot be assembled.
void ShadeUnassembled(GnuplotFigure& figure, const std::vector<problem::SensitivityPoint>& points) {
  for (std::size_t i = 0; i < points.size();) {
    std::size_t end = i;
    while (end < points.size() && std::isnan(points[end].range_deg)) ++end;
    if (end > i)
      figure.Line(
          "set object rectangle from first {}, graph 0 to first {}, graph 1 fillcolor rgb '{}' fillstyle solid "
          "noborder behind",
          points[i].delta_mm, points[end - 1].delta_mm, colour::kGap);
    i = end + 1;
  }
}

constexpr int kLengths = 7;  // l1..l6 and d_min
constexpr int kColumns = 4;

void DrawLengthPanel(GnuplotFigure& figure, const std::vector<problem::SensitivityPoint>& points,
                     const synthesis::SynthesisOutcome& outcome, int link, Range range) {
  const double length_mm = link + 1 < kLengths ? outcome.BestLinks().Values()[link] : outcome.problem.d_min_mm;
  std::vector<double> delta, feasible, infeasible;
  for (const problem::SensitivityPoint& point : points) {
    delta.push_back(point.delta_mm);
    feasible.push_back(point.feasible ? point.range_deg : kNaN);
    infeasible.push_back(point.range_deg);
  }
  const std::string data = figure.Data({delta, infeasible, feasible});
  figure.Line("unset object");
  ShadeUnassembled(figure, points);
  const std::string name = link + 1 < kLengths ? fmt::format("{{/:Italic l}}_{}", link + 1) : "{/:Italic d}_{min}";
  figure.Line("set title '{} = {:.2f} mm' offset 0,-0.6", name, length_mm);
  figure.Line("set yrange [{}:{}]", range.lower, range.upper);
  figure.Line(link + kColumns >= kLengths ? "set xlabel 'change (mm)'" : "unset xlabel");
  figure.Line(link % kColumns == 0 ? "set ylabel 'range of rotation (°)'" : "unset ylabel");
  figure.Line(
      "plot {0} using 1:2 with lines lw 2.5 dt (6,5) lc rgb '{1}' notitle, {0} using 1:3 with lines lw 3 lc rgb '{2}' "
      "notitle, '+' every ::0::0 using (0):({3}) with points pt 7 ps 1.2 lc rgb '{4}' notitle",
      data, "#555555", colour::kAnkle, points[points.size() / 2].range_deg, colour::kExoskeleton);
}

Range RangeOf(const std::vector<problem::SensitivityPoint>& points) {
  Range range{1e9, -1e9};
  for (const problem::SensitivityPoint& point : points)
    if (std::isfinite(point.range_deg))
      range = {std::min(range.lower, point.range_deg), std::max(range.upper, point.range_deg)};
  const double edge = std::max(1.0, 0.08 * (range.upper - range.lower));
  return {range.lower - edge, range.upper + edge};
}

}  // namespace

void DrawSensitivity(const synthesis::SynthesisOutcome& outcome, const std::filesystem::path& path) {
  GnuplotFigure figure(1100, 760);
  figure.Line("set multiplot layout 2,4 margins 0.085,0.985,0.16,0.94 spacing 0.07,0.15");
  figure.Line(
      "set label 2 'dot: the optimum    solid: feasible    dashed: outside a bound or limit    grey: cannot be "
      "assembled' at screen 0.5,0.03 center textcolor rgb '{}'",
      colour::kText);
  figure.Line("set xrange [-5:5]");
  const Range range = RangeOf(outcome.sensitivity);
  for (int link = 0; link < kLengths; ++link) {
    std::vector<problem::SensitivityPoint> points;
    std::ranges::copy_if(outcome.sensitivity, std::back_inserter(points),
                         [&](const problem::SensitivityPoint& point) { return point.link == link; });
    DrawLengthPanel(figure, points, outcome, link, range);
    if (link == 0) figure.Line("unset label 2");
  }
  figure.Line("unset multiplot").Write(path);
}

void DrawMargins(const synthesis::SynthesisOutcome& outcome, const std::filesystem::path& path) {
  std::vector<double> margin, range, yield;
  for (const synthesis::MarginPoint& point : outcome.margins) {
    margin.push_back(point.margin_mm);
    range.push_back(point.range_deg);
    yield.push_back(point.yield ? 100 * *point.yield : kNaN);
  }
  GnuplotFigure figure(1000, 640);
  const std::string data = figure.Data({margin, range, yield});
  figure.Line("set xlabel 'margin kept from Grashof''s limit and from the actuator''s singularity (mm)'");
  figure.Line("set ylabel 'range of rotation (°)'").Line("set key right center");
  std::string plot = fmt::format("plot {} using 1:2 with linespoints lw 3 pt 7 ps 0.9 lc rgb '{}'{}", data,
                                 colour::kAnkle, outcome.options.yield_tolerance_mm ? " title 'largest range'" : "");
  if (outcome.options.yield_tolerance_mm) {
    figure.Line("set y2label 'builds that keep every limit, lengths within ±{} mm (%)'",
                *outcome.options.yield_tolerance_mm);
    figure.Line("set y2range [0:105]").Line("set y2tics 20").Line("set border 11");
    plot += fmt::format(", {} using 1:3 axes x1y2 with linespoints lw 2 dt 2 pt 5 ps 0.8 lc rgb '{}' title 'yield'",
                        data, colour::kExoskeleton);
  }
  figure.Line(plot).Write(path);
}

void DrawConvergence(const synthesis::LocalSolve& solve, const std::string& objective, double per_cost,
                     const std::filesystem::path& path) {
  std::vector<double> number, range, violation, dual;
  for (const nlp::NlpIteration& step : solve.history) {
    number.push_back(static_cast<double>(number.size()));
    range.push_back(per_cost * step.cost);
    violation.push_back(std::max(kFloor, step.violation));
    dual.push_back(std::max(kFloor, step.dual_infeasibility));
  }
  GnuplotFigure figure(1000, 720);
  const std::string data = figure.Data({number, range, violation, dual});
  figure.Line("set multiplot layout 2,1 margins 0.11,0.97,0.11,0.95 spacing 0.1,0.07");
  figure.Line("set ylabel {}", QuoteForGnuplot(objective)).Line("set format x ''");
  figure.Line("plot {} using 1:2 with linespoints lw 3 pt 7 ps 0.8 lc rgb '{}' notitle", data, colour::kAnkle);
  figure.Line("set format x '%g'").Line("set xlabel 'iteration'");
  figure.Line("set logscale y").Line("set format y '10^{%L}'").Line("set ylabel 'error'").Line("set key bottom left");
  figure.Line(
      "plot {0} using 1:3 with linespoints lw 2 pt 7 ps 0.8 lc rgb '{1}' title 'constraint violation', {0} using 1:4 "
      "with linespoints lw 2 pt 5 ps 0.8 lc rgb '{2}' title 'dual infeasibility'",
      data, colour::kExoskeleton, colour::kHip);
  figure.Line("unset multiplot").Write(path);
}

}  // namespace lake::figure
