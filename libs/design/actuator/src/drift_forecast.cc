// Homing, and how far the actuator may be from its plan.
#include <algorithm>
#include <cmath>

#include "homing.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"

namespace lake::actuator {
namespace {

double HighestStroke(const StrokeSchedule& schedule) {
  double highest = 0;
  for (const linkage::StrokeProgram::Knot& knot : schedule.knots) highest = std::max(highest, knot.stroke_mm);
  return highest;
}

// How far past an end stop the actuator may come to rest, faster than planned by the speeds' tolerance.
double RunOn(double speed_mm_s, const Sketch& sketch) {
  return sketch.options.home_error_mm + sketch.options.lag_s * speed_mm_s * (1 + sketch.TolerancePercent() / 100);
}

// The least --extend-stop, in 0.1 mm: of the fastest jog.
double LeastExtendStop(const Sketch& sketch) {
  return std::floor(10 * RunOn(sketch.table.extend.MostSpeed(), sketch) + 1) / 10;
}

void RequireExtendStop(const Sketch& sketch) {
  const double stop_mm = *sketch.ExtendStop(), highest_mm = HighestStroke(sketch.schedule);
  if (sketch.options.extend_stop_mm < LeastExtendStop(sketch) - 1e-9)
    throw Fail(
        "past an extend end stop at {:.3f} mm the actuator may run on by {:.3f} mm, to the linkage's end at {:.3f} mm: "
        "give --extend-stop {:.1f} or more",
        stop_mm, RunOn(sketch.table.extend.MostSpeed(), sketch), sketch.schedule.limits.upper_end_mm,
        LeastExtendStop(sketch));
  if (highest_mm >= stop_mm)
    throw Fail(
        "the program goes to {:.3f} mm, and the extend end stop acts at {:.3f} mm: a smaller --extend-stop, or a "
        "program that ends earlier",
        highest_mm, stop_mm);
}

void RequireRoom(const Sketch& sketch) {
  const DriftForecast forecast = ForecastDrift(sketch);
  if (forecast.Fits()) return;
  std::string stop;
  if (const double least_mm = LeastExtendStop(sketch); HighestStroke(sketch.schedule) < forecast.end_mm - least_mm)
    stop = fmt::format("an extend end stop before it (--extend-stop {:.1f}), ", least_mm);
  std::string tolerance;
  if (forecast.tolerable_percent > 0)
    tolerance =
        fmt::format("a duty table with a measured tolerance of at most {:.1f} % (lake-stroke calibrate; now {} %{}), ",
                    forecast.tolerable_percent, SignificantText(forecast.tolerance_percent, 3),
                    forecast.is_measured ? "" : ", not measured");
  throw Fail(
      "the drift may carry the actuator past the linkage's end at {:.3f} mm: {:.3f} ± {:.3f} mm are planned at {:.2f} "
      "s. Ways out: {}{}a program that ends at least {:.1f} mm earlier (--margin or --to-angle, if its speed is "
      "constant), or --accept-drift on a bench without a person",
      forecast.end_mm, forecast.planned_mm, forecast.drift_mm, forecast.time_s, stop, tolerance,
      std::ceil(10 * (forecast.drift_mm - forecast.Room()) + 0.01) / 10);
}

// Which way the motor turns is found out within the room that the linkage has beyond an end stop.
void RequireRoomToCheck(const Sketch& sketch, const Homing& homing) {
  const FirmwareOptions& options = sketch.options;
  const double creep_mm_s = std::max(homing.extend_creep_mm_s, homing.retract_creep_mm_s);
  const double least_mm = std::min(homing.check_mm, kDirectionCheck_mm) + RunOn(creep_mm_s, sketch);
  const double below_mm = homing.stroke_mm - sketch.schedule.limits.lower_end_mm;
  const double room_mm = options.extend_stop_mm > 0 ? std::min(below_mm, options.extend_stop_mm) : below_mm;
  if (options.stop_travel_mm && *options.stop_travel_mm >= room_mm)
    throw UsageError(
        "--stop-travel {} mm is not less than the {:.3f} mm that the linkage has beyond an end stop: give less, or "
        "raise --margin, --home-stroke or --extend-stop",
        *options.stop_travel_mm, room_mm);
  if (least_mm >= room_mm)
    throw Fail(
        "to find out which way the motor turns takes {:.3f} mm, and beyond an end stop the linkage has {:.3f} mm: "
        "raise --margin, --home-stroke or --extend-stop, or give --accept-drift on a bench without a person",
        least_mm, room_mm);
}

// Homing keeps the lower soft limit, run-on past the switch and all.
void RequireHome(const Sketch& sketch, const Homing& homing) {
  const SoftLimits& limits = sketch.schedule.limits;
  if (homing.stroke_mm < limits.lower_mm - 1e-3)
    throw UsageError(
        "--home-stroke {:.3f} mm is below the soft limit {:.3f} mm: put the retract end stop there, or give "
        "--accept-drift on a bench without a person",
        homing.stroke_mm, limits.lower_mm);
  const double run_on_mm = RunOn(homing.speed_mm_s, sketch);
  if (homing.stroke_mm - run_on_mm <= limits.lower_end_mm)
    throw Fail(
        "homing to {:.3f} mm may run on by {:.3f} mm, past the linkage's end at {:.3f} mm: raise --margin or "
        "--home-stroke, lower --home-speed, or give --accept-drift on a bench without a person",
        homing.stroke_mm, run_on_mm, limits.lower_end_mm);
}

}  // namespace

Homing HomingOf(const Sketch& sketch) {
  const auto& [schedule, table, options, stroke] = sketch;
  Homing homing;
  homing.stroke_mm = sketch.HomeStroke();
  if (homing.stroke_mm > stroke.start_mm + 1e-3)
    throw UsageError("--home-stroke {} mm is past the program's start at {:.3f} mm", homing.stroke_mm, stroke.start_mm);
  const auto speed = [&](const DutyCurve& curve) {
    return std::clamp(sketch.options.home_speed_mm_s, curve.LeastMovingSpeed(), curve.MostSpeed());
  };
  homing.speed_mm_s = speed(table.retract);
  homing.position_speed_mm_s = speed(table.extend);
  homing.counts = CountsFor(table, -homing.speed_mm_s);
  homing.position_counts = CountsFor(table, homing.position_speed_mm_s);
  const double travel_mm = schedule.limits.used.stroke.upper_mm - homing.stroke_mm;
  homing.timeout_ms = std::llround(1e3 * ((1 + sketch.TolerancePercent() / 100) * travel_mm / homing.speed_mm_s + 1));
  homing.back_off_ms = std::llround(1e3 * options.StopTravel() / homing.position_speed_mm_s);
  const double released_mm = homing.stroke_mm + 1e-3 * homing.back_off_ms * homing.position_speed_mm_s;
  if (stroke.start_mm >= released_mm)
    homing.position_ms = std::llround(1e3 * (stroke.start_mm - released_mm) / homing.position_speed_mm_s);
  else
    homing.return_ms = std::llround(1e3 * (released_mm - stroke.start_mm) / homing.speed_mm_s);
  constexpr double kCreep = 1.5;       // times the slowest speed, so that it does not stick
  constexpr double kSeenCheck_mm = 1;  // a potentiometer tells the wrong way before
  homing.check_mm = std::min(options.StopTravel(), options.HasFeedback() ? kSeenCheck_mm : kDirectionCheck_mm);
  homing.extend_creep_mm_s = std::min(homing.position_speed_mm_s, kCreep * table.extend.LeastMovingSpeed());
  homing.retract_creep_mm_s = std::min(homing.speed_mm_s, kCreep * table.retract.LeastMovingSpeed());
  // What the potentiometer may be off by, and what homing runs on; where the linkage has more room, half of it.
  homing.guard_mm = homing.stroke_mm - std::max(options.feedback_error_mm + RunOn(homing.speed_mm_s, sketch),
                                                std::min(1.0, (homing.stroke_mm - schedule.limits.lower_end_mm) / 2));
  homing.touch_timeout_ms = std::llround(1e3 * (2 * options.StopTravel() / homing.speed_mm_s + 1));
  return homing;
}

double Sketch::TolerancePercent() const {
  return options.speed_tolerance_percent.value_or(table.TolerancePercent().value_or(kUnmeasuredTolerance_percent));
}

std::optional<double> Sketch::ExtendStop() const {
  if (options.extend_stop_mm == 0) return std::nullopt;
  return schedule.limits.upper_end_mm - options.extend_stop_mm;
}

double Sketch::HomeStroke() const {
  return options.home_stroke_mm > 0 ? options.home_stroke_mm : std::min(schedule.limits.lower_mm, stroke.start_mm);
}

DriftForecast ForecastDrift(const Sketch& sketch) {
  const auto& [schedule, table, options, stroke] = sketch;
  const Homing homing = HomingOf(sketch);
  DriftForecast forecast{.tolerance_percent = sketch.TolerancePercent(),
                         .is_measured = !options.speed_tolerance_percent && table.TolerancePercent(),
                         .end_mm = schedule.limits.upper_end_mm};
  if (options.HasFeedback()) {
    forecast.planned_mm = HighestStroke(schedule);
    forecast.drift_mm = forecast.last_drift_mm = options.feedback_error_mm + kFollowingError_mm;
    forecast.tolerable_percent = 100;
    return forecast;
  }
  DriftBound bound(sketch, -Um(homing.speed_mm_s));
  double tolerable_per_1024 = 1024;
  const auto look = [&](double time_s, double at_mm) {
    tolerable_per_1024 = std::min(tolerable_per_1024, bound.TolerablePer1024(forecast.end_mm - at_mm));
    if (at_mm + bound.Drift() <= forecast.planned_mm + forecast.drift_mm) return;
    forecast.time_s = time_s, forecast.planned_mm = at_mm, forecast.drift_mm = bound.Drift();
  };
  const auto turn = [&](std::int64_t velocity_um_s, double time_s, double at_mm) {
    bound.Turn(velocity_um_s);
    look(time_s, at_mm);
  };
  const auto go = [&](std::int64_t ms, double time_s, double at_mm) {
    bound.Go(ms);
    look(time_s, at_mm);
  };
  // Homing ends by a stop from its speed; then to the start.
  turn(0, 0, homing.stroke_mm);
  turn(Um(homing.position_speed_mm_s), 0, homing.stroke_mm);
  go(homing.back_off_ms + homing.position_ms, 0, std::max(stroke.start_mm, homing.stroke_mm + options.StopTravel()));
  turn(0, 0, stroke.start_mm);
  if (homing.return_ms > 0) {
    turn(-Um(homing.speed_mm_s), 0, stroke.start_mm);
    go(homing.return_ms, 0, stroke.start_mm);
    turn(0, 0, stroke.start_mm);
  }
  std::int64_t now_ms = 0;
  double planned_mm = stroke.start_mm;
  for (const StrokeSegment& segment : stroke.segments) {
    turn(segment.velocity_um_s, 1e-3 * static_cast<double>(now_ms), planned_mm);
    planned_mm += 1e-6 * static_cast<double>(segment.velocity_um_s * (segment.end_ms - now_ms));
    go(segment.end_ms - now_ms, 1e-3 * static_cast<double>(segment.end_ms), planned_mm);
    now_ms = segment.end_ms;
  }
  turn(0, 1e-3 * static_cast<double>(now_ms), planned_mm);
  forecast.last_drift_mm = bound.Drift();
  forecast.tolerable_percent = std::floor(10 * tolerable_per_1024 / 10.24) / 10;
  return forecast;
}

void RequireRoomForDrift(const Sketch& sketch, const Homing& homing) {
  RequireHome(sketch, homing);
  RequireRoomToCheck(sketch, homing);
  if (sketch.options.extend_stop_mm > 0)
    RequireExtendStop(sketch);
  else
    RequireRoom(sketch);
}

}  // namespace lake::actuator
