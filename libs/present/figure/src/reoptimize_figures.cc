#include "lake/figure/reoptimize_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/colours.h"
#include "lake/figure/gnuplot.h"

namespace lake::figure {
namespace {

constexpr const char* kBefore = "#0072B2";
constexpr const char* kFrame =
    "set border 3 lc rgb '#222222'; set tics nomirror out scale 0.6; set grid lc rgb '#EEEEEE'";

std::vector<double> Percents() {
  std::vector<double> percents;
  for (int i = 0; i < compare::kPercentSamples; ++i) percents.push_back(i);
  return percents;
}

std::string PathData(GnuplotFigure& figure, const std::vector<Eigen::Vector2d>& path) {
  std::vector<double> x, y;
  for (const Eigen::Vector2d& p : path) x.push_back(p.x()), y.push_back(p.y());
  return figure.Data({x, y});
}

// A curve per design over percent, and how it is drawn.
struct Curve {
  std::vector<double> values;
  std::string style, title;
};

std::string PlotOf(GnuplotFigure& figure, const std::vector<Curve>& curves) {
  std::string plot = "plot ";
  for (const Curve& curve : curves)
    if (!curve.values.empty())
      plot += fmt::format("{}{} using 1:2 with lines {} title '{}'", plot.size() > 5 ? ", " : "",
                          figure.Data({Percents(), curve.values}), curve.style, curve.title);
  return plot;
}

const std::string kHumanStyle = fmt::format("lw 4 lc rgb '{}'", colour::kHuman);
const std::string kBeforeStyle = fmt::format("lw 2.5 dt 2 lc rgb '{}'", kBefore);
const std::string kAfterStyle = fmt::format("lw 3 lc rgb '{}'", colour::kExoskeleton);

std::string AfterName(const redesign::ReoptimizeOutcome& outcome) {
  return outcome.IsSolved() ? "after" : "smallest found";
}

void DrawPaths(GnuplotFigure& figure, const redesign::ReoptimizeOutcome& outcome) {
  figure.Line("set title 'Knee in the leg frame' font ',13'; set xlabel 'anterior (mm)'; set ylabel 'up (mm)'");
  figure.Line("set size ratio -1; set offsets graph 0.06, graph 0.06, graph 0.75, graph 0.06; set key top right");
  figure.Line("set ytics 20");
  std::string plot = fmt::format("plot {} using 1:2 with lines {} title 'human knee'",
                                 PathData(figure, outcome.measured.human.knee), kHumanStyle);
  const auto add = [&](const redesign::DesignInMotion& design, const std::string& style, const std::string& title) {
    if (design.prediction)
      plot += fmt::format(", {} using 1:2 with lines {} title '{}'", PathData(figure, design.prediction->exo.knee),
                          style, title);
  };
  add(outcome.before, kBeforeStyle, "exoskeleton before"),
      add(outcome.after, kAfterStyle, "exoskeleton " + AfterName(outcome));
  // The same instants on each path, so that being late can be told from being elsewhere.
  for (const auto& [knee, colour, mark] :
       {std::tuple(&outcome.measured.human.knee, colour::kHuman, 7),
        std::tuple(outcome.before.prediction ? &outcome.before.prediction->exo.knee : nullptr, kBefore, 9),
        std::tuple(outcome.after.prediction ? &outcome.after.prediction->exo.knee : nullptr, colour::kExoskeleton,
                   5)}) {
    if (!knee) continue;
    std::vector<Eigen::Vector2d> dots;
    for (std::size_t i = 0; i < compare::kPercentSamples; i += 25) dots.push_back((*knee)[i]);
    plot += fmt::format(", {} using 1:2 with points pt {} ps 1.5 lc rgb '{}' {}", PathData(figure, dots), mark, colour,
                        mark == 7 ? "title '0, 25, 50, 75, 100 %'" : "notitle");
  }
  figure.Line(plot);
  figure.Line("set size noratio; set offsets 0, 0, 0, 0; set ytics autofreq");
}

void DrawRelativeError(GnuplotFigure& figure, const redesign::ReoptimizeOutcome& outcome) {
  const auto percent = [](const redesign::DesignInMotion& design) {
    std::vector<double> values;
    if (design.misalignment)
      for (const double error : design.misalignment->relative_error) values.push_back(100 * error);
    return values;
  };
  const auto name = [](const std::string& what, const redesign::DesignInMotion& design) {
    return design.misalignment ? fmt::format("{}: RMS {:.3g} %", what, 100 * design.misalignment->metrics.relative_rms)
                               : what;
  };
  figure.Line("set title 'Misalignment' font ',13'; set ylabel 'relative error (% of the shank)'; set yrange [0:*]");
  figure.Line("set offsets 0, 0, graph 0.3, 0; set key top right");
  std::string plot = PlotOf(figure, {{percent(outcome.before), kBeforeStyle, name("before", outcome.before)},
                                     {percent(outcome.after), kAfterStyle, name(AfterName(outcome), outcome.after)}});
  if (outcome.problem.max_misalignment_percent)
    plot += fmt::format("{}{} with lines lw 1.5 dt 3 lc rgb '{}' title 'limit of the RMS {:.3g} %'",
                        plot.size() > 5 ? ", " : "", *outcome.problem.max_misalignment_percent, colour::kText,
                        *outcome.problem.max_misalignment_percent);
  if (plot.size() > 5) figure.Line(plot);
  figure.Line("set yrange [*:*]; set offsets 0, 0, graph 0.12, graph 0.05");
}

void DrawKneeAngles(GnuplotFigure& figure, const redesign::ReoptimizeOutcome& outcome) {
  const auto angles = [](const redesign::DesignInMotion& design) {
    return design.prediction ? design.prediction->exo.knee_deg : std::vector<double>();
  };
  std::vector<double> human;
  for (const redesign::HumanSample& sample : outcome.problem.human)
    human.push_back(DegreesFromRadians(sample.knee_rad));
  figure.Line("set title 'Knee angle' font ',13'; set ylabel 'flexion (°)'; set key top right");
  figure.Line(PlotOf(figure, {{human, kHumanStyle, "human"},
                              {angles(outcome.before), kBeforeStyle, "before"},
                              {angles(outcome.after), kAfterStyle, AfterName(outcome)}}));
}

void DrawStrokes(GnuplotFigure& figure, const redesign::ReoptimizeOutcome& outcome) {
  const auto strokes = [](const redesign::DesignInMotion& design) {
    return design.prediction ? design.prediction->stroke_mm : std::vector<double>();
  };
  const auto name = [](const std::string& what, const redesign::DesignInMotion& design) {
    const std::string exact =
        design.tracking_time_s ? fmt::format(", exact tracking takes {:.3g} s", *design.tracking_time_s) : "";
    return fmt::format("{}: {:.3g} s{}", what, design.duration_s, exact);
  };
  const auto tracking =
      redesign::TrackingStrokes(outcome.problem.Driven(outcome.after.design.links), outcome.problem.human);
  figure.Line("set title 'Stroke program' font ',13'; set ylabel 'stroke (mm)'; set key bottom right");
  const std::string plot =
      PlotOf(figure, {{tracking.value_or(std::vector<double>()), kHumanStyle, "exact tracking"},
                      {strokes(outcome.before), kBeforeStyle, name("before", outcome.before)},
                      {strokes(outcome.after), kAfterStyle, name(AfterName(outcome), outcome.after)}});
  if (plot.size() > 5) figure.Line(plot);
}

void DrawDesignMark(std::string& plot, GnuplotFigure& figure, const redesign::DesignInMotion& design,
                    const std::string& name, const char* colour, int mark) {
  if (!design.misalignment || !design.evaluation.pose) return;
  plot += fmt::format(", {} using 1:2 with points pt {} ps 2.2 lw 2 lc rgb '{}' title '{}'",
                      figure.Data({{100 * design.misalignment->metrics.relative_rms}, {design.evaluation.range_deg}}),
                      mark, colour, name);
}

}  // namespace

void DrawKneePaths(const redesign::ReoptimizeOutcome& outcome, const std::filesystem::path& path) {
  GnuplotFigure figure(1600, 1100);
  figure.Line("set multiplot layout 2,2 margins 0.06,0.98,0.08,0.95 spacing 0.09,0.12");
  figure.Line(kFrame).Line("set key samplen 2.5 spacing 1.15");
  DrawPaths(figure, outcome);
  figure.Line("set xlabel 'sit-to-stand (%)'; set xrange [0:100]");
  DrawRelativeError(figure, outcome);
  DrawKneeAngles(figure, outcome);
  DrawStrokes(figure, outcome);
  figure.Line("unset multiplot").Write(path);
}

void DrawPareto(const redesign::ReoptimizeOutcome& outcome, const std::filesystem::path& path) {
  constexpr const char* kColours[] = {"#0072B2", "#009E73", "#CC79A7"};
  constexpr int kMarks[] = {7, 9, 11};
  GnuplotFigure figure(1100, 760);
  figure.Line("set title 'What a smaller misalignment costs in range' font ',15'");
  figure.Line(kFrame).Line(
      "set key at screen 0.5, 0.03 center bottom horizontal samplen 2.5 spacing 1.2; set bmargin 7");
  figure.Line("set xlabel 'misalignment, RMS (% of the shank)'; set ylabel 'range of rotation (°)'");
  figure.Line("set offsets 0, graph 0.04, graph 0.04, graph 0.04; set xrange [0:*]");
  std::string plot = "plot ";
  for (std::size_t i = 0; i < outcome.fronts.size(); ++i) {
    std::vector<double> misalignment, range;
    for (const redesign::ParetoPoint& point : outcome.fronts[i].points)
      misalignment.push_back(point.misalignment_percent), range.push_back(point.range_deg);
    if (range.empty()) continue;
    plot += fmt::format("{}{} using 1:2 with linespoints lw 3 pt {} ps 1.1 lc rgb '{}' title '{} program'",
                        plot.size() > 5 ? ", " : "", figure.Data({misalignment, range}), kMarks[i % 3], kColours[i % 3],
                        outcome.fronts[i].name);
  }
  if (plot.size() == 5) plot += "1/0 notitle";
  DrawDesignMark(plot, figure, outcome.before, "before", colour::kText, 6);
  DrawDesignMark(plot, figure, outcome.after, AfterName(outcome), colour::kExoskeleton, 4);
  if (outcome.problem.max_misalignment_percent)
    figure.Line(fmt::format("set arrow from {0}, graph 0 to {0}, graph 1 nohead lw 1.5 dt 3 lc rgb '{1}'",
                            *outcome.problem.max_misalignment_percent, colour::kText));
  figure.Line(plot).Write(path);
}

}  // namespace lake::figure
