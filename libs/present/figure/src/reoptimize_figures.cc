#include "lake/figure/reoptimize_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
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

// The curves of one panel, drawn together.
class Plot {
 public:
  explicit Plot(GnuplotFigure& figure) : figure_(figure) {}

  bool IsEmpty() const { return curves_.empty(); }
  void Add(std::string curve) { curves_.push_back(std::move(curve)); }

  // `how`: lines or points, their style and title.
  void AddData(const std::vector<double>& x, const std::vector<double>& y, const std::string& how) {
    Add(fmt::format("{} using 1:2 with {}", figure_.Data({x, y}), how));
  }
  void AddPath(const std::vector<Eigen::Vector2d>& path, const std::string& how) {
    std::vector<double> x, y;
    for (const Eigen::Vector2d& p : path) x.push_back(p.x()), y.push_back(p.y());
    AddData(x, y, how);
  }
  // One value per percent; none, no curve.
  void AddCurve(const std::vector<double>& values, const std::string& style, const std::string& title) {
    if (!values.empty()) AddData(Percents(), values, fmt::format("lines {} title '{}'", style, title));
  }

  void Draw() {
    if (!IsEmpty()) figure_.Line(fmt::format("plot {}", fmt::join(curves_, ", ")));
  }

 private:
  GnuplotFigure& figure_;
  std::vector<std::string> curves_;
};

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
  struct Knee {
    const std::vector<Eigen::Vector2d>* path;  // nullptr: not drawn
    std::string style, title;
    const char* colour;
    int mark;
  };
  const auto path = [](const redesign::DesignInMotion& design) {
    return design.prediction ? &design.prediction->exo.knee : nullptr;
  };
  const std::array knees{
      Knee{&outcome.measured.human.knee, kHumanStyle, "human knee", colour::kHuman, 7},
      Knee{path(outcome.before), kBeforeStyle, "exoskeleton before", kBefore, 9},
      Knee{path(outcome.after), kAfterStyle, "exoskeleton " + AfterName(outcome), colour::kExoskeleton, 5}};
  Plot plot(figure);
  for (const Knee& knee : knees)
    if (knee.path) plot.AddPath(*knee.path, fmt::format("lines {} title '{}'", knee.style, knee.title));
  // The same instants on each path, so that being late can be told from being elsewhere.
  const char* title = "title '0, 25, 50, 75, 100 %'";
  for (const Knee& knee : knees) {
    if (!knee.path) continue;
    std::vector<Eigen::Vector2d> dots;
    for (std::size_t i = 0; i < compare::kPercentSamples; i += 25) dots.push_back((*knee.path)[i]);
    plot.AddPath(dots, fmt::format("points pt {} ps 1.5 lc rgb '{}' {}", knee.mark, knee.colour, title));
    title = "notitle";
  }
  plot.Draw();
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
  Plot plot(figure);
  plot.AddCurve(percent(outcome.before), kBeforeStyle, name("before", outcome.before));
  plot.AddCurve(percent(outcome.after), kAfterStyle, name(AfterName(outcome), outcome.after));
  if (outcome.problem.max_misalignment_percent)
    plot.Add(fmt::format("{0} with lines lw 1.5 dt 3 lc rgb '{1}' title 'limit of the RMS {0:.3g} %'",
                         *outcome.problem.max_misalignment_percent, colour::kText));
  plot.Draw();
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
  Plot plot(figure);
  plot.AddCurve(human, kHumanStyle, "human");
  plot.AddCurve(angles(outcome.before), kBeforeStyle, "before");
  plot.AddCurve(angles(outcome.after), kAfterStyle, AfterName(outcome));
  plot.Draw();
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
  Plot plot(figure);
  plot.AddCurve(tracking.value_or(std::vector<double>()), kHumanStyle, "exact tracking");
  plot.AddCurve(strokes(outcome.before), kBeforeStyle, name("before", outcome.before));
  plot.AddCurve(strokes(outcome.after), kAfterStyle, name(AfterName(outcome), outcome.after));
  plot.Draw();
}

void AddDesignMark(const redesign::DesignInMotion& design, const std::string& name, const char* colour, int mark,
                   Plot& plot) {
  if (!design.misalignment || !design.evaluation.pose) return;
  plot.AddData({100 * design.misalignment->metrics.relative_rms}, {design.evaluation.range_deg},
               fmt::format("points pt {} ps 2.2 lw 2 lc rgb '{}' title '{}'", mark, colour, name));
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
  Plot plot(figure);
  for (std::size_t i = 0; i < outcome.fronts.size(); ++i) {
    std::vector<double> misalignment, range;
    for (const redesign::ParetoPoint& point : outcome.fronts[i].points)
      misalignment.push_back(point.misalignment_percent), range.push_back(point.range_deg);
    if (range.empty()) continue;
    plot.AddData(misalignment, range,
                 fmt::format("linespoints lw 3 pt {} ps 1.1 lc rgb '{}' title '{} program'", kMarks[i % 3],
                             kColours[i % 3], outcome.fronts[i].name));
  }
  if (plot.IsEmpty()) plot.Add("1/0 notitle");
  AddDesignMark(outcome.before, "before", colour::kText, 6, plot);
  AddDesignMark(outcome.after, AfterName(outcome), colour::kExoskeleton, 4, plot);
  if (outcome.problem.max_misalignment_percent)
    figure.Line(fmt::format("set arrow from {0}, graph 0 to {0}, graph 1 nohead lw 1.5 dt 3 lc rgb '{1}'",
                            *outcome.problem.max_misalignment_percent, colour::kText));
  plot.Draw();
  figure.Write(path);
}

}  // namespace lake::figure
