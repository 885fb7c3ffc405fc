#include <fmt/ranges.h>

#include <array>
#include <cmath>

#include "lake/core/colours.h"
#include "lake/figure/charts.h"
#include "lake/figure/design_figures.h"
#include "lake/figure/gnuplot.h"

namespace lake::figure {
namespace {

using problem::AssistanceRow;
using report::LineChart, report::Mark, report::Series;

std::vector<double> Column(const problem::Assistance& assistance, double AssistanceRow::*member) {
  std::vector<double> values;
  for (const AssistanceRow& row : assistance.rows) values.push_back(row.*member);
  return values;
}

// Over percent.
Series Over(const problem::Assistance& assistance, std::string name, std::vector<double> values, const char* colour,
            Mark mark = Mark::kLine) {
  return {.name = std::move(name),
          .x = Column(assistance, &AssistanceRow::percent),
          .y = std::move(values),
          .colour = colour,
          .mark = mark};
}

// The speed that the actuator reaches under the force of each row, in the direction `sign`.
std::vector<double> ReachedSpeeds(const problem::Assistance& assistance, const problem::LinearActuator& actuator,
                                  int sign) {
  std::vector<double> speeds;
  for (const AssistanceRow& row : assistance.rows) {
    const double speed = actuator.SpeedAt(std::isnan(row.force_n) ? 0 : std::abs(row.force_n));
    speeds.push_back(std::isnan(row.speed_mm_s) ? AssistanceRow::kUnknown : sign * speed);
  }
  return speeds;
}

// The theme's colours are of quantities; these are of any eight actuators.
constexpr std::array kCurveColours = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                      "#8B6914", "#2E8BC0", "#222222", "#777777"};
constexpr std::array kMarks = {7, 5, 9, 11, 13, 7, 5, 9};

// As a text of its own in a figure, not too long.
std::string Shortened(const std::string& text, std::size_t most) {
  if (text.size() <= most) return text;
  std::size_t end = most - 1;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;  // not within a character of UTF-8
  return text.substr(0, end) + "…";
}

struct Line {
  std::vector<double> assist, duration;
};

Line LineOf(const synthesis::ActuatorCurve& curve) {
  Line line;
  for (const synthesis::FrontPoint& point : curve.points)
    if (point.solved && std::isfinite(point.assistance.shortest_s)) {
      line.assist.push_back(100 * point.assist);
      line.duration.push_back(point.assistance.shortest_s);
    }
  return line;
}

// Why a curve ends, or that it is no curve.
std::string EndOf(const synthesis::ActuatorCurve& curve) {
  const synthesis::FrontPoint* last = curve.Last();
  const std::string limits = fmt::format("{}", fmt::join(curve.limits, ", "));
  if (!last) return "no design: " + limits;
  std::string text;
  if (!curve.Actuator().HasSpeed()) text = fmt::format("speed not known; designs up to {:.0f} %", 100 * last->assist);
  if (curve.failing.empty()) return text;
  return text + (text.empty() ? "" : "; ") + fmt::format("no design beyond {:.0f} %: ", 100 * last->assist) + limits;
}

// Of all durations, with room around them.
std::string YRange(const std::vector<synthesis::ActuatorCurve>& curves, double own_duration_s) {
  double least = own_duration_s, most = own_duration_s;
  for (const synthesis::ActuatorCurve& curve : curves)
    for (const double duration : LineOf(curve).duration) {
      least = std::min(least, duration);
      most = std::max(most, duration);
    }
  constexpr double kRoom = 1.6;
  return fmt::format("set yrange [{}:{}]", least / kRoom, most * kRoom * kRoom);
}

}  // namespace

void DrawAssistance(const std::filesystem::path& path, const problem::Assistance& assistance,
                    const problem::SynthesisProblem& problem) {
  struct Panel {
    const char *axis, *title;
    double AssistanceRow::*member;
  };
  std::vector<LineChart> charts;
  for (const Panel& panel : {Panel{"force (N)", "actuator, pushing", &AssistanceRow::force_n},
                             Panel{"speed (mm/s)", "actuator, extending", &AssistanceRow::speed_mm_s},
                             Panel{"power (W)", "actuator, driving", &AssistanceRow::power_w}})
    charts.push_back({.x = {.label = "rise (%)", .from = 0, .to = 100},
                      .y = {.label = panel.axis},
                      .series = {Over(assistance, panel.title, Column(assistance, panel.member), colour::kNew)}});
  if (problem.actuator) {
    const problem::LinearActuator& actuator = *problem.actuator;
    const auto limit = [&](std::size_t chart, std::string name, std::vector<double> values) {
      charts[chart].series.push_back(
          Over(assistance, std::move(name), std::move(values), colour::kExoskeleton, Mark::kDashed));
    };
    if (const auto force_n = actuator.LiftingForce())
      limit(0, fmt::format("lifts {:.0f} N", *force_n), std::vector<double>(assistance.rows.size(), *force_n));
    if (actuator.HasSpeed()) {
      limit(1, actuator.HasForceSpeedLaw() ? "its limit under this force" : "its limit without load",
            ReachedSpeeds(assistance, actuator, 1));
      limit(1, "", ReachedSpeeds(assistance, actuator, -1));
    }
  }
  const std::string name = problem.actuator ? problem.actuator->name + ", " : "";
  DrawCharts(path, charts, 1,
             fmt::format("{}{:.0f} % of the knee's moment, a rise in {:.1f} s", name, 100 * problem.assist.value_or(1),
                         assistance.duration_s));
}

void DrawActuatorFront(const std::filesystem::path& path, const std::vector<synthesis::ActuatorCurve>& curves,
                       double own_duration_s) {
  constexpr int kNoteHeight_px = 22, kPlotHeight_px = 800;
  constexpr double kWholeShare = 100;  // percent
  std::vector<std::string> notes;
  for (const synthesis::ActuatorCurve& curve : curves)
    if (const std::string end = EndOf(curve); !end.empty())
      notes.push_back(Shortened(curve.Actuator().name + ": " + end, 150));
  const int height_px = kPlotHeight_px + kNoteHeight_px * static_cast<int>(notes.size());
  GnuplotFigure figure(1300, height_px);
  figure.Line(
      "set lmargin at screen 0.08; set rmargin at screen 0.80; set tmargin at screen 0.96; set bmargin at screen {}",
      1 - (kPlotHeight_px - 80.0) / height_px);
  figure.Line("set logscale y; set xlabel 'share of the knee moment (%)'; set ylabel 'shortest rise (s)'");
  figure.Line("set xrange [0:105]; set key top left samplen 2.5; {}", YRange(curves, own_duration_s));
  for (std::size_t i = 0; i < notes.size(); ++i)
    figure.Line("set label {} at screen 0.02, screen {} left noenhanced font ',12'", QuoteForGnuplot(notes[i]),
                (kNoteHeight_px * (notes.size() - i) - 8.0) / height_px);
  std::string plot = fmt::format("{} with lines lw 2 dt (8,4) lc rgb '{}' title 'the person{} own rise'",
                                 own_duration_s, colour::kHuman, "''s");
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const Line line = LineOf(curves[i]);
    if (line.assist.empty()) continue;
    const bool known = curves[i].Actuator().HasForceSpeedLaw();
    const char* const colour = kCurveColours[i % kCurveColours.size()];
    const bool ends_early = line.assist.back() < kWholeShare;  // beside it others may go on, so its name stands above
    figure.Line("set label {} at first {}, first {} left offset 1,{} noenhanced",
                QuoteForGnuplot(curves[i].Actuator().name + (known ? "" : " (at least)")), line.assist.back(),
                line.duration.back(), ends_early ? 0.8 : 0);
    plot += fmt::format(", {} using 1:2 with linespoints lw 2.5 pt {} ps 1.5 lc rgb '{}'{}",
                        figure.Data({line.assist, line.duration}), kMarks[i % kMarks.size()] - (known ? 0 : 1), colour,
                        known ? "" : " dt (3,4)");
  }
  figure.Line("plot " + plot).Write(path);
}

}  // namespace lake::figure
