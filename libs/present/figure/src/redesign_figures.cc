#include <fmt/format.h>

#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/colours.h"
#include "lake/core/numbers.h"
#include "lake/core/uncertain_text.h"
#include "lake/figure/charts.h"
#include "lake/figure/design_figures.h"
#include "percents.h"

namespace lake::figure {
namespace {

using redesign::DesignInMotion, redesign::RedesignOutcome;
using report::Axis, report::LineChart, report::Mark, report::Series;

// The same quantity has the same colour and dash in every figure.
Series Human(std::vector<double> values, std::string name = "human") {
  return OverPercent(std::move(name), std::move(values), colour::kHuman);
}
Series Worn(std::vector<double> values, std::string name = "worn") {
  return OverPercent(std::move(name), std::move(values), colour::kWorn, Mark::kDotted);
}
Series New(std::vector<double> values, std::string name) {
  return OverPercent(std::move(name), std::move(values), colour::kNew, Mark::kDashed);
}

// Over the whole rise.
Series Level(double value, std::string name) {
  return {.name = std::move(name), .x = {0, 100}, .y = {value, value}, .colour = colour::kText, .mark = Mark::kThin};
}

// Of the series that have values.
LineChart OverRise(std::string title, Axis y, std::vector<Series> series) {
  std::erase_if(series, [](const Series& one) { return one.x.empty(); });
  return {.title = std::move(title),
          .x = {.label = "rise (%)", .from = 0, .to = 100},
          .y = std::move(y),
          .series = std::move(series)};
}

std::string AfterName(const RedesignOutcome& outcome) {
  return outcome.IsSolved() ? "new" : "least found";
}

// The paths, and the same instants on each, so that being late can be distinguished from being elsewhere.
LineChart PathsChart(const RedesignOutcome& outcome) {
  LineChart chart{.title = "Knee paths, leg frame",
                  .x = {.label = "anterior (mm)"},
                  .y = {.label = "up (mm)"},
                  .equal_scales = true};
  Series instants{.name = "0, 25, 50, 75, 100 %", .colour = colour::kText, .mark = Mark::kPoints};
  const auto add = [&](const std::vector<Eigen::Vector2d>& path, std::string name, const char* colour, Mark mark) {
    Series series{.name = std::move(name), .colour = colour, .mark = mark};
    for (std::size_t i = 0; i < path.size(); ++i) {
      series.x.push_back(path[i].x());
      series.y.push_back(path[i].y());
      if (i % 25 > 0) continue;
      instants.x.push_back(path[i].x());
      instants.y.push_back(path[i].y());
    }
    chart.series.push_back(std::move(series));
  };
  if (outcome.after.prediction)
    add(outcome.after.prediction->exo.knee, AfterName(outcome) + ", predicted", colour::kNew, Mark::kDashed);
  if (outcome.before.prediction)
    add(outcome.before.prediction->exo.knee, "worn, predicted", colour::kWorn, Mark::kDotted);
  add(outcome.measured.human.knee, "human knee", colour::kHuman, Mark::kLine);
  chart.series.push_back(std::move(instants));
  return chart;
}

LineChart MisalignmentChart(const RedesignOutcome& outcome) {
  const auto percent = [](const DesignInMotion& design) {
    std::vector<double> values;
    if (design.misalignment)
      for (const double error : design.misalignment->misalignment_ratio) values.push_back(100 * error);
    return values;
  };
  const auto name = [](const std::string& what, const DesignInMotion& design) {
    return design.misalignment ? fmt::format("{}: RMS {:.1f} %", what, 100 * design.misalignment->metrics.relative_rms)
                               : what;
  };
  LineChart chart = OverRise("Path difference", {.label = "% of the shank length", .from = 0},
                             {New(percent(outcome.after), name(AfterName(outcome), outcome.after)),
                              Worn(percent(outcome.before), name("worn", outcome.before))});
  if (const auto& limit = outcome.problem.max_misalignment_percent)
    chart.series.push_back(Level(*limit, fmt::format("limit of the RMS {} %", SignificantText(*limit, 3))));
  return chart;
}

LineChart KneeAnglesChart(const RedesignOutcome& outcome) {
  const auto angles = [](const DesignInMotion& design) {
    return design.prediction ? design.prediction->exo.knee_deg : std::vector<double>();
  };
  std::vector<double> human;
  for (const redesign::HumanSample& sample : outcome.problem.human)
    human.push_back(DegreesFromRadians(sample.knee_rad));
  return OverRise("Knee angle", {.label = "knee flexion (°)"},
                  {New(angles(outcome.after), AfterName(outcome)), Worn(angles(outcome.before)), Human(human)});
}

LineChart StrokesChart(const RedesignOutcome& outcome) {
  const auto strokes = [](const DesignInMotion& design) {
    return design.prediction ? design.prediction->stroke_mm : std::vector<double>();
  };
  const auto name = [](const std::string& what, const DesignInMotion& design) {
    const std::string exact =
        design.tracking_time_s ? fmt::format(" (exact tracking {:.1f} s)", *design.tracking_time_s) : "";
    return fmt::format("{}: {:.1f} s{}", what, design.duration_s, exact);
  };
  const auto tracking =
      redesign::TrackingStrokes(outcome.problem.Driven(outcome.after.design.links), outcome.problem.human);
  return OverRise("Stroke program", {.label = "stroke (mm)"},
                  {New(strokes(outcome.after), name(AfterName(outcome), outcome.after)),
                   Worn(strokes(outcome.before), name("worn", outcome.before)),
                   Human(tracking.value_or(std::vector<double>()), "exact tracking")});
}

// A figure of each percent; NaN while the seat bears a part, or where balance is not known.
std::vector<double> Balances(const DesignInMotion& design, double redesign::BalanceSample::*member) {
  std::vector<double> values;
  if (!design.prediction || !design.prediction->balance) return values;
  const auto& samples = design.prediction->balance->samples;
  values.assign(design.prediction->theta_rad.size() - samples.size(), std::nan(""));
  for (const redesign::BalanceSample& sample : samples) values.push_back(sample.*member);
  return values;
}

LineChart PressuresChart(const RedesignOutcome& outcome) {
  const auto name = [](const std::string& what, const DesignInMotion& design) {
    if (!design.prediction || !design.prediction->balance) return what;
    const redesign::BalanceCourse& course = *design.prediction->balance;
    return fmt::format("{}, {:.1f} s: {:.0f} mm {} the foot", what, course.duration_s, std::abs(course.margin_mm),
                       course.margin_mm < 0 ? "outside" : "inside");
  };
  const auto member = &redesign::BalanceSample::pressure_mm;
  const loads::Foot& foot = outcome.problem.body->body.sole;
  const double heel_mm = -kMmPerM * foot.heel_m, toe_mm = kMmPerM * foot.toe_m;
  LineChart chart =
      OverRise("Centre of pressure", {.label = "before the ankle (mm)", .from = heel_mm - 80, .to = toe_mm + 200},
               {New(Balances(outcome.after, member), name(AfterName(outcome), outcome.after)),
                Worn(Balances(outcome.before, member), name("worn", outcome.before))});
  if (const auto& without = outcome.without_balance)
    chart.series.push_back(Human(Balances(*without, member), name("without balance", *without)));
  chart.series.push_back(Level(heel_mm, "heel, toe"));
  chart.series.push_back(Level(toe_mm, ""));
  return chart;
}

LineChart TrunkChart(const RedesignOutcome& outcome) {
  std::vector<double> human, leaning;
  for (std::size_t i = 0; i < outcome.problem.body->trunk.size(); ++i) {
    human.push_back(DegreesFromRadians(outcome.problem.body->trunk[i].tilt_rad));
    const double more_rad = outcome.lean.trunk_rad.empty() ? 0 : outcome.lean.trunk_rad[i];
    leaning.push_back(human.back() + DegreesFromRadians(more_rad));
  }
  return OverRise("Trunk", {.label = "forward lean (°)"},
                  {New(leaning, AfterName(outcome) + " program"), Human(human)});
}

LineChart LegLeanChart(const RedesignOutcome& outcome) {
  std::vector<double> more_deg;
  for (const double lean_rad : outcome.lean.leg_rad) more_deg.push_back(DegreesFromRadians(lean_rad));
  more_deg.resize(outcome.problem.human.size(), 0);
  return OverRise("Leg, from ankle to hip", {.label = "farther forward than the human (°)"},
                  {New(more_deg, AfterName(outcome) + " program")});
}

LineChart KneeMomentsChart(const RedesignOutcome& outcome) {
  const auto member = &redesign::BalanceSample::knee_nm;
  return OverRise("Knee moment at the pace of the program", {.label = "extension, one leg (N m)"},
                  {New(Balances(outcome.after, member), AfterName(outcome)), Worn(Balances(outcome.before, member))});
}

}  // namespace

void DrawKneePaths(const std::filesystem::path& path, const RedesignOutcome& outcome) {
  DrawCharts(path, {PathsChart(outcome), MisalignmentChart(outcome), KneeAnglesChart(outcome), StrokesChart(outcome)},
             2);
}

void DrawBalance(const std::filesystem::path& path, const RedesignOutcome& outcome) {
  DrawCharts(path, {PressuresChart(outcome), TrunkChart(outcome), KneeMomentsChart(outcome), LegLeanChart(outcome)}, 2);
}

}  // namespace lake::figure
