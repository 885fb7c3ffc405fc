// The program as the firmware's segments.
#include <algorithm>
#include <cmath>

#include "homing.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"

namespace lake::actuator {
namespace {

using Knot = linkage::StrokeProgram::Knot;

constexpr double kMostDuration_s = 2'000'000;  // in ms within 31 bits

// Douglas & Peucker 1973 in stroke over time: keeps those knots whose chord is farther than the tolerance.
void Thin(const std::vector<Knot>& knots, std::size_t first, std::size_t last, double tolerance_mm,
          std::vector<bool>& keep) {
  std::vector<std::pair<std::size_t, std::size_t>> open = {{first, last}};
  while (!open.empty()) {
    const auto [a, b] = open.back();
    open.pop_back();
    double worst = tolerance_mm;
    std::size_t at = a;
    for (std::size_t i = a + 1; i < b; ++i) {
      const double fraction = (knots[i].time_s - knots[a].time_s) / (knots[b].time_s - knots[a].time_s);
      const double distance =
          std::abs(std::lerp(knots[a].stroke_mm, knots[b].stroke_mm, fraction) - knots[i].stroke_mm);
      if (distance > worst) {
        worst = distance;
        at = i;
      }
    }
    keep[at] = true;
    if (at != a) {
      open.emplace_back(a, at);
      open.emplace_back(at, b);
    }
  }
}

// Turning points and rests stay, so that the reversals keep their pauses.
std::vector<Knot> Thinned(const std::vector<Knot>& knots, double tolerance_mm) {
  std::vector<bool> keep(knots.size(), false);
  const auto direction = [&](std::size_t i) { return DirectionOf(SpeedOf(knots[i], knots[i + 1])); };
  keep.front() = keep.back() = true;
  std::size_t first = 0;
  for (std::size_t i = 1; i < knots.size(); ++i) {
    if (i + 1 < knots.size() && direction(i) == direction(i - 1)) continue;
    keep[i] = true;
    Thin(knots, first, i, tolerance_mm, keep);
    first = i;
  }
  std::vector<Knot> thinned;
  for (std::size_t i = 0; i < knots.size(); ++i)
    if (keep[i]) thinned.push_back(knots[i]);
  return thinned;
}

std::vector<Knot> KnotsThatFit(const StrokeSchedule& schedule, double tolerance_mm) {
  if (schedule.knots.size() - 1 <= kMostSegments) return schedule.knots;
  std::vector<Knot> knots = Thinned(schedule.knots, tolerance_mm);
  if (knots.size() - 1 > kMostSegments)
    throw Fail(
        "a program of {} knots takes {} segments within {} mm; the UNO's flash holds {}: raise --table-tolerance",
        schedule.knots.size(), knots.size() - 1, tolerance_mm, kMostSegments);
  return knots;
}

void CheckFits(const StrokeSchedule& schedule) {
  if (schedule.Duration() > kMostDuration_s)
    throw Fail("a program of {} s is too long for the firmware, which counts up to {:.0f} s",
               SignificantText(schedule.Duration(), 6), kMostDuration_s);
  if (schedule.limits.upper_mm > kMostStroke_mm)
    throw Fail("a stroke of {} mm is too long for the firmware, which counts up to {:.0f} mm",
               SignificantText(schedule.limits.upper_mm, 6), kMostStroke_mm);
}

// Both ways of following the table are piecewise linear, so their worst distances from the schedule are at knots of one
// or the other.
void MeasureErrors(StrokeTable& stroke, const StrokeSchedule& schedule, const DutyTable& table) {
  double plan_mm = stroke.start_mm, driven_mm = stroke.start_mm;
  std::size_t knot = 0;
  std::int64_t begin_ms = 0;
  for (const StrokeSegment& segment : stroke.segments) {
    const double plan_speed = segment.velocity_um_s / 1e3;
    const int direction = (segment.velocity_um_s > 0) - (segment.velocity_um_s < 0);
    const double speed =
        direction == 0 ? 0 : direction * table.Curve(direction).SpeedFor(segment.counts / double{kPwmPeriod});
    const double begin_s = begin_ms / 1e3, end_s = segment.end_ms / 1e3;
    const auto compare = [&](double time_s) {
      const double truth = schedule.StrokeAt(time_s), past = time_s - begin_s;
      stroke.rounding_error_mm = std::max(stroke.rounding_error_mm, std::abs(plan_mm + plan_speed * past - truth));
      stroke.pwm_error_mm = std::max(stroke.pwm_error_mm, std::abs(driven_mm + speed * past - truth));
    };
    for (; knot < schedule.knots.size() && schedule.knots[knot].time_s <= end_s; ++knot)
      if (schedule.knots[knot].time_s >= begin_s) compare(schedule.knots[knot].time_s);
    compare(end_s);
    plan_mm += plan_speed * (end_s - begin_s);
    driven_mm += speed * (end_s - begin_s);
    begin_ms = segment.end_ms;
  }
}

}  // namespace

int CountsFor(const DutyTable& table, double speed_mm_s) {
  const int direction = DirectionOf(speed_mm_s);
  if (direction == 0) return 0;
  const DutyCurve& curve = table.Curve(direction);
  const double duty = curve.DutyFor(std::clamp(std::abs(speed_mm_s), curve.LeastSpeed(), curve.MostSpeed()));
  return static_cast<int>(std::lround(duty * kPwmPeriod));
}

StrokeTable MakeStrokeTable(const StrokeSchedule& schedule, const DutyTable& table, const FirmwareOptions& options) {
  options.Check();
  CheckSpeeds(schedule, table);
  CheckFits(schedule);
  const std::vector<Knot> knots = KnotsThatFit(schedule, options.table_tolerance_mm);
  StrokeTable stroke;
  stroke.start_mm = Um(knots.front().stroke_mm) / 1e3;
  double plan_um = stroke.start_mm * 1e3;
  std::int64_t begin_ms = 0;
  for (std::size_t i = 1; i < knots.size(); ++i) {
    StrokeSegment segment;
    segment.end_ms = std::llround(1e3 * knots[i].time_s);
    if (segment.end_ms <= begin_ms) continue;
    const double duration_s = (segment.end_ms - begin_ms) / 1e3;
    const double exact = SpeedOf(knots[i - 1], knots[i]);
    // Towards the knot from where rounding has left the plan, so that errors do not add up.
    const long velocity = std::lround((1e3 * knots[i].stroke_mm - plan_um) / duration_s);
    if (velocity * DirectionOf(exact) > 0) {
      segment.velocity_um_s = static_cast<std::int32_t>(velocity);
      segment.counts = CountsFor(table, exact);
    }
    plan_um += segment.velocity_um_s * duration_s;
    begin_ms = segment.end_ms;
    stroke.segments.push_back(segment);
  }
  if (stroke.segments.empty()) throw Fail("the program is shorter than 1 ms");
  MeasureErrors(stroke, schedule, table);
  return stroke;
}

}  // namespace lake::actuator
