#include "lake/figure/redesign_figures.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/colours.h"
#include "lake/core/numbers.h"
#include "lake/core/uncertain_text.h"
#include "lake/figure/gnuplot.h"
#include "percents.h"
#include "theme.h"

namespace lake::figure {
namespace {

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
    for (const Eigen::Vector2d& p : path) {
      x.push_back(p.x());
      y.push_back(p.y());
    }
    AddData(x, y, how);
  }
  // One value per percent; none, no curve.
  void AddCurve(const std::vector<double>& values, const std::string& style, const std::string& title) {
    if (!values.empty())
      AddData(Percents(compare::kPercentSamples), values, fmt::format("lines {} title '{}'", style, title));
  }

  void Draw() {
    if (!IsEmpty()) figure_.Line("plot {}", fmt::join(curves_, ", "));
  }

 private:
  GnuplotFigure& figure_;
  std::vector<std::string> curves_;
};

const std::string kHumanStyle = LineOf(kHumanPath);
const std::string kBeforeStyle = LineOf(kWornPath);
const std::string kAfterStyle = LineOf(kNewPath);

std::string AfterName(const redesign::RedesignOutcome& outcome) {
  return outcome.IsSolved() ? "new" : "least found";
}

void DrawPaths(GnuplotFigure& figure, const redesign::RedesignOutcome& outcome) {
  figure.Line("set title 'Knee paths, leg frame'; set xlabel 'anterior (mm)'; set ylabel 'up (mm)'");
  figure.Line(
      "set size ratio -1; set offsets graph 0.06, graph 0.06, graph 1.1, graph 0.06; set key top left Left reverse");
  figure.Line("set ytics 20");
  struct Knee {
    const std::vector<Eigen::Vector2d>* path;  // nullptr: not drawn
    double width;
    std::string title;
    const PathStyle& style;
  };
  const auto path = [](const redesign::DesignInMotion& design) {
    return design.prediction ? &design.prediction->exo.knee : nullptr;
  };
  const std::array knees{
      Knee{.path = &outcome.measured.human.knee, .width = 5, .title = "human knee", .style = kHumanPath},
      Knee{.path = path(outcome.before), .width = 3, .title = "worn, predicted", .style = kWornPath},
      Knee{.path = path(outcome.after), .width = 2, .title = AfterName(outcome) + ", predicted", .style = kNewPath}};
  Plot plot(figure);
  // A path that runs back over itself would look solid though it is dashed: lines are told apart by width here.
  for (const Knee& knee : knees)
    if (knee.path)
      plot.AddPath(*knee.path,
                   fmt::format("lines lw {} lc rgb '{}' title '{}'", knee.width, knee.style.colour, knee.title));
  // The same instants on each path, so that being late can be told from being elsewhere.
  const char* title = "title '0, 25, 50, 75, 100 %'";
  for (const Knee& knee : knees) {
    if (!knee.path) continue;
    std::vector<Eigen::Vector2d> dots;
    for (std::size_t i = 0; i < compare::kPercentSamples; i += 25) dots.push_back((*knee.path)[i]);
    plot.AddPath(dots, fmt::format("points {} {}", MarkOf(knee.style), title));
    title = "notitle";
  }
  plot.Draw();
  figure.Line("set size noratio; set offsets 0, 0, 0, 0; set ytics autofreq");
}

void DrawMisalignment(GnuplotFigure& figure, const redesign::RedesignOutcome& outcome) {
  const auto percent = [](const redesign::DesignInMotion& design) {
    std::vector<double> values;
    if (design.misalignment)
      for (const double error : design.misalignment->misalignment_ratio) values.push_back(100 * error);
    return values;
  };
  const auto name = [](const std::string& what, const redesign::DesignInMotion& design) {
    return design.misalignment ? fmt::format("{}: RMS {:.1f} %", what, 100 * design.misalignment->metrics.relative_rms)
                               : what;
  };
  figure.Line("set title 'Path difference'; set ylabel '% of the shank length'; set yrange [0:*]");
  figure.Line("set offsets 0, 0, graph 0.3, 0; set key top right");
  Plot plot(figure);
  plot.AddCurve(percent(outcome.before), kBeforeStyle, name("worn", outcome.before));
  plot.AddCurve(percent(outcome.after), kAfterStyle, name(AfterName(outcome), outcome.after));
  if (outcome.problem.max_misalignment_percent)
    plot.Add(fmt::format("{0} with lines lw 1.5 dt 3 lc rgb '{1}' title 'limit of the RMS {2} %'",
                         *outcome.problem.max_misalignment_percent, colour::kText,
                         SignificantText(*outcome.problem.max_misalignment_percent, 3)));
  plot.Draw();
  figure.Line("set yrange [*:*]; set offsets 0, 0, graph 0.2, graph 0.05");
}

void DrawKneeAngles(GnuplotFigure& figure, const redesign::RedesignOutcome& outcome) {
  const auto angles = [](const redesign::DesignInMotion& design) {
    return design.prediction ? design.prediction->exo.knee_deg : std::vector<double>();
  };
  std::vector<double> human;
  for (const redesign::HumanSample& sample : outcome.problem.human)
    human.push_back(DegreesFromRadians(sample.knee_rad));
  figure.Line("set title 'Knee angle'; set ylabel 'knee flexion (°)'; set key top right");
  Plot plot(figure);
  plot.AddCurve(human, kHumanStyle, "human");
  plot.AddCurve(angles(outcome.before), kBeforeStyle, "worn");
  plot.AddCurve(angles(outcome.after), kAfterStyle, AfterName(outcome));
  plot.Draw();
}

void DrawStrokes(GnuplotFigure& figure, const redesign::RedesignOutcome& outcome) {
  const auto strokes = [](const redesign::DesignInMotion& design) {
    return design.prediction ? design.prediction->stroke_mm : std::vector<double>();
  };
  const auto name = [](const std::string& what, const redesign::DesignInMotion& design) {
    const std::string exact =
        design.tracking_time_s ? fmt::format(" (exact tracking {:.1f} s)", *design.tracking_time_s) : "";
    return fmt::format("{}: {:.1f} s{}", what, design.duration_s, exact);
  };
  const auto tracking =
      redesign::TrackingStrokes(outcome.problem.Driven(outcome.after.design.links), outcome.problem.human);
  figure.Line("set title 'Stroke program'; set ylabel 'stroke (mm)'; set key top left Left reverse");
  Plot plot(figure);
  plot.AddCurve(tracking.value_or(std::vector<double>()), kHumanStyle, "exact tracking");
  plot.AddCurve(strokes(outcome.before), kBeforeStyle, name("worn", outcome.before));
  plot.AddCurve(strokes(outcome.after), kAfterStyle, name(AfterName(outcome), outcome.after));
  plot.Draw();
}

// A figure of each percent; NaN while the seat bears a part, or where balance is not known.
std::vector<double> Balances(const redesign::DesignInMotion& design, double redesign::BalanceSample::*member) {
  std::vector<double> values;
  if (!design.prediction || !design.prediction->balance) return values;
  const auto& samples = design.prediction->balance->samples;
  values.assign(design.prediction->theta_rad.size() - samples.size(), std::nan(""));
  for (const redesign::BalanceSample& sample : samples) values.push_back(sample.*member);
  return values;
}

void DrawPressures(GnuplotFigure& figure, const redesign::RedesignOutcome& outcome) {
  const auto name = [](const std::string& what, const redesign::DesignInMotion& design) {
    if (!design.prediction || !design.prediction->balance) return what;
    const redesign::BalanceCourse& course = *design.prediction->balance;
    return fmt::format("{}, {:.1f} s: {:.0f} mm {} the foot", what, course.duration_s, std::abs(course.margin_mm),
                       course.margin_mm < 0 ? "outside" : "inside");
  };
  const loads::Foot& foot = outcome.problem.body->body.sole;
  const double heel_mm = -kMmPerM * foot.heel_m, toe_mm = kMmPerM * foot.toe_m;
  figure.Line("set title 'Centre of pressure'; set ylabel 'before the ankle (mm)'; set key top right");
  figure.Line("set yrange [{}:{}]", heel_mm - 80, toe_mm + 200);
  Plot plot(figure);
  const auto member = &redesign::BalanceSample::pressure_mm;
  plot.AddCurve(Balances(outcome.before, member), kBeforeStyle, name("worn", outcome.before));
  if (outcome.without_balance)
    plot.AddCurve(Balances(*outcome.without_balance, member), kHumanStyle,
                  name("without balance", *outcome.without_balance));
  plot.AddCurve(Balances(outcome.after, member), kAfterStyle, name(AfterName(outcome), outcome.after));
  for (const double end_mm : {heel_mm, toe_mm})
    plot.Add(fmt::format("{} with lines lw 2 dt 2 lc rgb '{}' {}", end_mm, colour::kText,
                         end_mm < 0 ? "title 'heel, toe'" : "notitle"));
  plot.Draw();
  figure.Line("set yrange [*:*]");
}

void DrawTrunk(GnuplotFigure& figure, const redesign::RedesignOutcome& outcome) {
  std::vector<double> human, leaning;
  for (std::size_t i = 0; i < outcome.problem.body->trunk.size(); ++i) {
    human.push_back(DegreesFromRadians(outcome.problem.body->trunk[i].tilt_rad));
    const double more_rad = outcome.lean.trunk_rad.empty() ? 0 : outcome.lean.trunk_rad[i];
    leaning.push_back(human.back() + DegreesFromRadians(more_rad));
  }
  figure.Line("set title 'Trunk'; set ylabel 'forward lean (°)'");
  Plot plot(figure);
  plot.AddCurve(human, kHumanStyle, "human");
  plot.AddCurve(leaning, kAfterStyle, AfterName(outcome) + " program");
  plot.Draw();
}

void DrawLegLean(GnuplotFigure& figure, const redesign::RedesignOutcome& outcome) {
  std::vector<double> more_deg;
  for (const double lean_rad : outcome.lean.leg_rad) more_deg.push_back(DegreesFromRadians(lean_rad));
  more_deg.resize(outcome.problem.human.size(), 0);
  figure.Line("set title 'Leg, from ankle to hip'; set ylabel 'farther forward than the human (°)'");
  figure.Line("set yrange [*<-2:2<*]");
  Plot plot(figure);
  plot.AddCurve(more_deg, kAfterStyle, AfterName(outcome) + " program");
  plot.Draw();
  figure.Line("set yrange [*:*]");
}

void DrawKneeMoments(GnuplotFigure& figure, const redesign::RedesignOutcome& outcome) {
  figure.Line("set title 'Knee moment at the pace of the program'; set ylabel 'extension, one leg (N m)'");
  Plot plot(figure);
  plot.AddCurve(Balances(outcome.before, &redesign::BalanceSample::knee_nm), kBeforeStyle, "worn");
  plot.AddCurve(Balances(outcome.after, &redesign::BalanceSample::knee_nm), kAfterStyle, AfterName(outcome));
  plot.Draw();
}

void AddDesignMark(const redesign::DesignInMotion& design, const std::string& name, const PathStyle& style,
                   Plot& plot) {
  if (!design.misalignment || !design.evaluation.pose) return;
  plot.AddData({design.evaluation.range_deg}, {100 * design.misalignment->metrics.relative_rms},
               fmt::format("points pt {} ps 2.6 lc rgb '{}' title '{}'", style.mark, style.colour, name));
}

}  // namespace

void DrawKneePaths(const redesign::RedesignOutcome& outcome, const std::filesystem::path& path) {
  GnuplotFigure figure(1400, 1000);
  figure.Line("set multiplot layout 2,2 margins 0.075,0.98,0.085,0.95 spacing 0.1,0.14");
  DrawPaths(figure, outcome);
  figure.Line("set xlabel 'rise (%)'; set xrange [0:100]");
  DrawMisalignment(figure, outcome);
  DrawKneeAngles(figure, outcome);
  DrawStrokes(figure, outcome);
  figure.Line("unset multiplot").Write(path);
}

void DrawBalance(const redesign::RedesignOutcome& outcome, const std::filesystem::path& path) {
  GnuplotFigure figure(1400, 900);
  figure.Line("set multiplot layout 2,2 margins 0.075,0.98,0.085,0.95 spacing 0.1,0.14");
  figure.Line("set xlabel 'rise (%)'; set xrange [0:100]");
  DrawPressures(figure, outcome);
  DrawTrunk(figure, outcome);
  DrawKneeMoments(figure, outcome);
  DrawLegLean(figure, outcome);
  figure.Line("unset multiplot").Write(path);
}

void DrawPareto(const redesign::RedesignOutcome& outcome, const std::filesystem::path& path) {
  constexpr const char* kDashes[] = {"1", "(12,5)", "(3,4)"};
  constexpr int kMarks[] = {13, 8, 4};
  GnuplotFigure figure(1000, 700);
  figure.Line("set key at screen 0.5, screen 0.02 center bottom horizontal; set bmargin 8.5");
  figure.Line("set xlabel 'range of rotation (°)'; set ylabel 'path difference, RMS (% of the shank length)'");
  figure.Line("set offsets graph 0.04, graph 0.04, graph 0.06, 0; set yrange [0:*]");
  Plot plot(figure);
  for (std::size_t i = 0; i < outcome.fronts.size(); ++i) {
    std::vector<double> misalignment, range;
    for (const redesign::ParetoPoint& point : outcome.fronts[i].points) {
      misalignment.push_back(point.misalignment_percent);
      range.push_back(point.range_deg);
    }
    if (range.empty()) continue;
    plot.AddData(range, misalignment,
                 fmt::format("linespoints lw 2.5 dt {} pt {} ps 1.3 lc rgb '{}' title '{} program'", kDashes[i % 3],
                             kMarks[i % 3], colour::kFronts[i % 3], outcome.fronts[i].name));
  }
  if (plot.IsEmpty()) plot.Add("1/0 notitle");
  AddDesignMark(outcome.before, "worn", kWornPath, plot);
  if (outcome.joint_moved) AddDesignMark(*outcome.joint_moved, "worn, joint moved", kMovedPath, plot);
  if (outcome.other_program) AddDesignMark(*outcome.other_program, "worn, other program", kOtherProgramPath, plot);
  AddDesignMark(outcome.after, AfterName(outcome), kNewPath, plot);
  if (outcome.problem.max_misalignment_percent)
    figure.Line(
        "set arrow from graph 0, first {0} to graph 1, first {0} nohead lw 1.5 dt 3 lc rgb '{1}'; set label 'limit {2} "
        "%' at graph 0.01, first {0} left offset 0,0.6",
        *outcome.problem.max_misalignment_percent, colour::kText,
        SignificantText(*outcome.problem.max_misalignment_percent, 3));
  plot.Draw();
  figure.Write(path);
}

}  // namespace lake::figure
