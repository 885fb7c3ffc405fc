#include "lake/figure/stroke_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lake/core/colours.h"
#include "lake/core/numbers.h"
#include "lake/figure/charts.h"

namespace lake::figure {
namespace {

using report::LineChart, report::Mark, report::Series;

constexpr const char* kExtendColour = "#0072B2";
constexpr const char* kRetractColour = "#D55E00";

Series Course(std::string name, std::vector<double> x, std::vector<double> y, const char* colour,
              Mark mark = Mark::kLine) {
  return {.name = std::move(name), .x = std::move(x), .y = std::move(y), .colour = colour, .mark = mark};
}

// Of rows that are too many to draw, every n-th.
std::vector<actuator::ScheduleRow> Drawable(const std::vector<actuator::ScheduleRow>& rows) {
  constexpr std::size_t kMost = 5000;
  const std::size_t step = rows.size() / kMost + 1;
  std::vector<actuator::ScheduleRow> few;
  for (std::size_t i = 0; i < rows.size(); i += step) few.push_back(rows[i]);
  if ((rows.size() - 1) % step != 0) few.push_back(rows.back());
  return few;
}

struct ProgramColumns {
  std::vector<double> time, stroke, speed, knee, duty;

  explicit ProgramColumns(const std::vector<actuator::ScheduleRow>& rows) {
    for (const actuator::ScheduleRow& row : Drawable(rows)) {
      time.push_back(row.time_s);
      stroke.push_back(row.stroke_mm);
      speed.push_back(row.speed_mm_s);
      knee.push_back(row.knee_deg);
      duty.push_back(100 * row.duty * (row.direction < 0 ? -1 : 1));
    }
  }
};

LineChart StrokeChart(const actuator::StrokeSchedule& schedule, const ProgramColumns& c) {
  const double lower = schedule.limits.lower_mm, upper = schedule.limits.upper_mm, pad = 0.12 * (upper - lower);
  LineChart chart{.y = {.label = "stroke (mm)", .from = lower - pad, .to = upper + 5 * pad},
                  .series = {Course("stroke", c.time, c.stroke, kExtendColour)}};
  for (const double limit : {lower, upper})
    chart.series.push_back(Course(fmt::format("soft limit {:.2f} mm", limit), {0, schedule.Duration()}, {limit, limit},
                                  colour::kGuide, Mark::kDashed));
  return chart;
}

// Speeds over duty in %, with their errors.
Series TableOf(const std::vector<actuator::DutyRow>& rows, double actuator::DutyRow::*speed,
               double actuator::DutyRow::*error, const char* colour) {
  Series series{.colour = colour, .mark = Mark::kPoints};
  for (const actuator::DutyRow& row : rows) {
    if (std::isnan(row.*speed)) continue;
    const double error_mm_s = std::isnan(row.*error) ? 0 : row.*error;
    series.x.push_back(100 * row.duty);
    series.y.push_back(row.*speed);
    series.lower.push_back(row.*speed - error_mm_s);
    series.upper.push_back(row.*speed + error_mm_s);
  }
  return series;
}

Series CurveOf(std::string name, const actuator::DutyCurve& curve, const char* colour) {
  constexpr int kSteps = 200;
  Series series{.name = std::move(name), .colour = colour};
  for (int i = 0; i <= kSteps; ++i) {
    series.y.push_back(std::lerp(curve.LeastSpeed(), curve.MostSpeed(), i / double{kSteps}));
    series.x.push_back(100 * curve.DutyFor(series.y.back()));
  }
  return series;
}

Series PlateausOf(std::string name, const std::vector<actuator::Plateau>& plateaus, bool used, const char* colour) {
  Series series{.name = std::move(name), .colour = colour, .mark = Mark::kPoints};
  for (const actuator::Plateau& plateau : plateaus)
    if (plateau.used == used) {
      series.x.push_back(100 * std::abs(plateau.duty));
      series.y.push_back(std::abs(plateau.speed_mm_s));
    }
  return series;
}

struct ValidationColumns {
  std::vector<double> time, stroke, predicted, measured, error;

  explicit ValidationColumns(const actuator::Validation& validation) {
    for (const actuator::ValidatedSample& s : validation.samples) {
      time.push_back(s.program_time_s);
      predicted.push_back(s.predicted_deg);
      measured.push_back(s.measured_deg);
      stroke.push_back(s.moving ? s.stroke_mm : kNaN);
      error.push_back(s.moving ? s.Error() : kNaN);
    }
  }
};

Series AngleCurve(const actuator::StrokeSchedule& schedule) {
  constexpr int kSteps = 400;
  Series curve{.name = "simulation", .colour = colour::kText};
  for (int i = 0; i <= kSteps; ++i) {
    curve.x.push_back(
        std::lerp(schedule.limits.used.stroke.lower_mm, schedule.limits.used.stroke.upper_mm, i / double{kSteps}));
    curve.y.push_back(actuator::KneeDegAt(schedule.links, curve.x.back()));
  }
  return curve;
}

}  // namespace

void DrawStrokeProgram(const std::filesystem::path& path, const actuator::StrokeSchedule& schedule,
                       const std::vector<actuator::ScheduleRow>& rows) {
  const ProgramColumns c(rows);
  std::vector<LineChart> charts = {
      StrokeChart(schedule, c),
      {.y = {.label = "speed (mm/s)"}, .series = {Course("", c.time, c.speed, kExtendColour)}},
      {.y = {.label = "knee angle (°)", .from = 0}, .series = {Course("", c.time, c.knee, colour::kExoskeleton)}}};
  if (!std::isnan(c.duty.front()))
    charts.insert(charts.begin() + 2, LineChart{.y = {.label = "duty (%), signed"},
                                                .series = {Course("", c.time, c.duty, kRetractColour)}});
  for (LineChart& chart : charts) chart.x = {.label = "time (s)", .from = 0, .to = schedule.Duration()};
  DrawCharts(path, charts);
}

void DrawDutyCalibration(const std::filesystem::path& path, const actuator::DutyCalibration& calibration) {
  const actuator::DutyTable table = actuator::MakeDutyTable(calibration.rows, "the table");
  LineChart chart{.x = {.label = "duty (%)", .from = 0, .to = 102}, .y = {.label = "speed (mm/s)", .from = 0}};
  const auto add = [&](const actuator::DutyCurve& curve, double actuator::DutyRow::*speed,
                       double actuator::DutyRow::*error, const char* colour, const char* name,
                       const actuator::DeadBand& band) {
    chart.series.push_back(CurveOf(fmt::format("{}, dead band up to {:.1f} %", name, 100 * band.duty), curve, colour));
    chart.series.push_back(TableOf(calibration.rows, speed, error, colour));
  };
  using Row = actuator::DutyRow;
  add(table.extend, &Row::extend_mm_s, &Row::extend_se_mm_s, kExtendColour, "extending", calibration.extend);
  add(table.retract, &Row::retract_mm_s, &Row::retract_se_mm_s, kRetractColour, "retracting", calibration.retract);
  for (const auto& [name, used, colour] :
       {std::tuple{"plateaus", true, "#555555"}, std::tuple{"left out, not steady", false, "#CC79A7"}})
    if (Series plateaus = PlateausOf(name, calibration.plateaus, used, colour); !plateaus.x.empty())
      chart.series.push_back(std::move(plateaus));
  DrawCharts(path, {chart});
}

void DrawValidation(const std::filesystem::path& path, const actuator::StrokeSchedule& schedule,
                    const actuator::Validation& validation) {
  const ValidationColumns c(validation);
  const auto tracked = [&](const std::vector<double>& x) {
    return Course("prototype, tracked", x, c.measured, colour::kHuman, Mark::kPoints);
  };
  const LineChart over_stroke{.x = {.label = "stroke length (mm)"},
                              .y = {.label = "knee angle (°)"},
                              .series = {AngleCurve(schedule), tracked(c.stroke)}};
  const LineChart over_time{.x = {.label = "time since the program began (s)"},
                            .y = {.label = "knee angle (°)"},
                            .series = {Course("simulation", c.time, c.predicted, colour::kText), tracked(c.time)}};
  const LineChart difference{
      .x = {.label = "time since the program began (s)"},
      .y = {.label = "difference (°)"},
      .series = {Course(fmt::format("RMS {:.2f}°, largest {:.2f}°", validation.rms_deg, validation.max_deg), c.time,
                        c.error, colour::kExoskeleton)}};
  DrawCharts(path, {over_stroke, over_time, difference});
}

}  // namespace lake::figure
