#include "lake/figure/stroke_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lake/core/colours.h"
#include "lake/core/numbers.h"
#include "lake/figure/gnuplot.h"

namespace lake::figure {
namespace {

constexpr const char* kExtendColour = "#0072B2";
constexpr const char* kRetractColour = "#D55E00";

void Place(GnuplotFigure& figure, double left, double right, double bottom, double top) {
  figure.Line("set lmargin at screen {}; set rmargin at screen {}; set bmargin at screen {}; set tmargin at screen {}",
              left, right, bottom, top);
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

void DrawStroke(GnuplotFigure& figure, const actuator::StrokeSchedule& schedule, const ProgramColumns& c) {
  const double lower = schedule.limits.lower_mm, upper = schedule.limits.upper_mm, pad = 0.12 * (upper - lower);
  figure.Line("set ylabel 'stroke (mm)'; set yrange [{}:{}]", lower - pad, upper + pad);
  for (const auto& [limit, side] : {std::pair{lower, -1}, std::pair{upper, 1}})
    figure.Line("set label 'soft limit {:.2f} mm' at graph 0.5, first {} center offset 0,{} tc rgb '#666666'", limit,
                limit, 0.7 * side);
  figure.Line(
      "plot {0} with lines lw 2 dt 2 lc rgb '{4}', {1} with lines lw 2 dt 2 lc rgb '{4}', {2} using 1:2 with lines lw "
      "3 lc rgb '{3}'",
      lower, upper, figure.Data({c.time, c.stroke}), kExtendColour, colour::kGuide);
  figure.Line("unset label");
}

// Speed on the left, signed duty on the right, their zeros at one height.
void DrawSpeed(GnuplotFigure& figure, const ProgramColumns& c) {
  const double top = std::max(0.0, *std::max_element(c.speed.begin(), c.speed.end()));
  const double least = std::min(0.0, *std::min_element(c.speed.begin(), c.speed.end()));
  const double pad = 0.12 * (top - least), high = top + 3 * pad;
  double low = least - pad;
  const bool has_duty = !std::isnan(c.duty.front());
  const double percent_per_speed = 105 / std::max(high, -low);
  if (has_duty) low = std::min(low, 1.1 * *std::min_element(c.duty.begin(), c.duty.end()) / percent_per_speed);
  figure.Line("set ylabel 'speed (mm/s)'; set yrange [{}:{}]; set key top right horizontal", low, high);
  if (has_duty) {
    figure.Line("set y2label 'duty (%), signed'; set y2range [{}:{}]; set y2tics 50; set border 11",
                percent_per_speed * low, percent_per_speed * high);
  }
  std::string plot = fmt::format("plot {} using 1:2 with steps lw 3 lc rgb '{}' title 'speed'",
                                 figure.Data({c.time, c.speed}), kExtendColour);
  if (has_duty)
    plot += fmt::format(", {} using 1:2 axes x1y2 with steps lw 2.5 dt 3 lc rgb '{}' title 'duty'",
                        figure.Data({c.time, c.duty}), kRetractColour);
  figure.Line(plot);
  figure.Line("unset y2label; unset y2tics; set border 3");
}

// Columns: duty in %, speed, its error.
std::string TableOf(GnuplotFigure& figure, const std::vector<actuator::DutyRow>& rows, double actuator::DutyRow::*speed,
                    double actuator::DutyRow::*error) {
  std::vector<double> duty, speeds, errors;
  for (const actuator::DutyRow& row : rows) {
    if (std::isnan(row.*speed)) continue;
    duty.push_back(100 * row.duty);
    speeds.push_back(row.*speed);
    errors.push_back(std::isnan(row.*error) ? 0 : row.*error);
  }
  return figure.Data({duty, speeds, errors});
}

std::string CurveOf(GnuplotFigure& figure, const actuator::DutyCurve& curve) {
  constexpr int kSteps = 200;
  std::vector<double> duty, speeds;
  for (int i = 0; i <= kSteps; ++i) {
    speeds.push_back(std::lerp(curve.LeastSpeed(), curve.MostSpeed(), i / double{kSteps}));
    duty.push_back(100 * curve.DutyFor(speeds.back()));
  }
  return figure.Data({duty, speeds});
}

std::string PlateausOf(GnuplotFigure& figure, const std::vector<actuator::Plateau>& plateaus, bool used) {
  std::vector<double> duty = {kNaN}, speeds = {kNaN};
  for (const actuator::Plateau& plateau : plateaus)
    if (plateau.used == used) {
      duty.push_back(100 * std::abs(plateau.duty));
      speeds.push_back(std::abs(plateau.speed_mm_s));
    }
  return figure.Data({duty, speeds});
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

std::string AngleCurve(GnuplotFigure& figure, const actuator::StrokeSchedule& schedule) {
  constexpr int kSteps = 400;
  std::vector<double> strokes, angles;
  for (int i = 0; i <= kSteps; ++i) {
    strokes.push_back(
        std::lerp(schedule.limits.used.stroke.lower_mm, schedule.limits.used.stroke.upper_mm, i / double{kSteps}));
    angles.push_back(actuator::KneeDegAt(schedule.links, strokes.back()));
  }
  return figure.Data({strokes, angles});
}

}  // namespace

void DrawStrokeProgram(const std::filesystem::path& path, const actuator::StrokeSchedule& schedule,
                       const std::vector<actuator::ScheduleRow>& rows) {
  GnuplotFigure figure(1200, 1000);
  const ProgramColumns columns(rows);
  figure.Line("set multiplot");
  figure.Line("set xrange [0:{}]; set format x ''", schedule.Duration());
  Place(figure, 0.09, 0.90, 0.68, 0.97);
  DrawStroke(figure, schedule, columns);
  Place(figure, 0.09, 0.90, 0.38, 0.64);
  DrawSpeed(figure, columns);
  Place(figure, 0.09, 0.90, 0.07, 0.34);
  figure.Line(
      "set format x '%g'; set xlabel 'time (s)'; set ylabel 'knee angle (°)'; set yrange [0:*]; set offsets 0, 0, "
      "graph 0.08, 0");
  figure.Line("plot {} using 1:2 with lines lw 3 lc rgb '{}'", figure.Data({columns.time, columns.knee}),
              colour::kExoskeleton);
  figure.Line("unset multiplot").Write(path);
}

void DrawDutyCalibration(const std::filesystem::path& path, const actuator::DutyCalibration& calibration) {
  GnuplotFigure figure(1100, 700);
  const actuator::DutyTable table = actuator::MakeDutyTable(calibration.rows, "the table");
  figure.Line("set xlabel 'duty (%)'; set ylabel 'speed (mm/s)'; set xrange [0:102]; set yrange [0:*]");
  figure.Line("set key top left; set rmargin 4; set tmargin 2; set offsets 0, 0, graph 0.06, 0");
  const auto direction = [&](const actuator::DutyCurve& curve, double actuator::DutyRow::*speed,
                             double actuator::DutyRow::*error, const char* colour, const char* name,
                             const actuator::DeadBand& band) {
    const std::string drawn = CurveOf(figure, curve), rows = TableOf(figure, calibration.rows, speed, error);
    return fmt::format(
        "{} using 1:2 with lines lw 2 lc rgb '{}' title '{}, dead band up to {:.1f} %', {} using 1:2:3 with yerrorbars "
        "pt 7 ps 1.1 lw 2 lc rgb '{}'",
        drawn, colour, name, 100 * band.duty, rows, colour);
  };
  std::string plot =
      "plot " + direction(table.extend, &actuator::DutyRow::extend_mm_s, &actuator::DutyRow::extend_se_mm_s,
                          kExtendColour, "extending", calibration.extend);
  plot += ", " + direction(table.retract, &actuator::DutyRow::retract_mm_s, &actuator::DutyRow::retract_se_mm_s,
                           kRetractColour, "retracting", calibration.retract);
  plot += fmt::format(", {} using 1:2 with points pt 6 ps 1.6 lc rgb '#555555' title 'plateaus'",
                      PlateausOf(figure, calibration.plateaus, true));
  const bool left_out = std::any_of(calibration.plateaus.begin(), calibration.plateaus.end(),
                                    [](const actuator::Plateau& plateau) { return !plateau.used; });
  if (left_out)
    plot += fmt::format(", {} using 1:2 with points pt 2 ps 1.6 lw 2 lc rgb '#CC79A7' title 'left out, not steady'",
                        PlateausOf(figure, calibration.plateaus, false));
  figure.Line(plot).Write(path);
}

void DrawValidation(const std::filesystem::path& path, const actuator::StrokeSchedule& schedule,
                    const actuator::Validation& validation) {
  GnuplotFigure figure(1600, 800);
  const ValidationColumns c(validation);
  const std::string curve = AngleCurve(figure, schedule),
                    samples = figure.Data({c.time, c.stroke, c.predicted, c.measured, c.error});
  figure.Line("set multiplot");
  Place(figure, 0.06, 0.47, 0.10, 0.97);
  figure.Line(
      "set xlabel 'stroke length (mm)'; set ylabel 'knee angle (°)'; set key top right; set offsets graph 0.02, graph "
      "0.02, graph 0.05, graph 0.05");
  figure.Line(
      "plot {} using 2:4 with points pt 7 ps 0.7 lc rgb '{}' title 'prototype, tracked', {} using 1:2 with lines lw 2 "
      "lc rgb '{}' title 'simulation'",
      samples, colour::kHuman, curve, colour::kText);
  Place(figure, 0.55, 0.98, 0.43, 0.97);
  figure.Line("set format x ''; unset xlabel");
  figure.Line(
      "plot {} using 1:4 with points pt 7 ps 0.7 lc rgb '{}' title 'prototype, tracked', {} using 1:3 with lines lw 2 "
      "lc rgb '{}' title 'simulation'",
      samples, colour::kHuman, samples, colour::kText);
  Place(figure, 0.55, 0.98, 0.10, 0.37);
  figure.Line(
      "set format x '%g'; set xlabel 'time since the program began (s)'; set ylabel 'difference (°)'; set offsets 0, "
      "0, graph 0.35, graph 0.05");
  figure.Line(
      "plot {} using 1:5 with lines lw 1.5 lc rgb '{}' title 'RMS {:.2f}°, largest {:.2f}°', 0 lw 1 lc rgb '{}'",
      samples, colour::kExoskeleton, validation.rms_deg, validation.max_deg, colour::kGuide);
  figure.Line("unset multiplot").Write(path);
}

}  // namespace lake::figure
