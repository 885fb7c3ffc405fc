// What a motor with a screw cannot do: crawl below the speed at which it sticks, change its speed at once.
#include <algorithm>
#include <cmath>

#include "lake/actuator/stroke_schedule.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"

namespace lake::actuator {
namespace {

using Knot = linkage::StrokeProgram::Knot;
using Knots = std::vector<Knot>;

// Of the steps that replace crawling: about 0.2 degrees, as shorter ones shake more; and how long each moves at least,
// so that the motor's lag matters little.
constexpr double kLeastStep_mm = 0.2, kLeastMove_s = 0.1;
constexpr double kRounding = 1e-9;      // of a whole number of steps
constexpr double kRampStep_s = 0.02;    // of a ramp, made of short stretches of constant speed
constexpr double kLeastRamp_s = 0.001;  // shorter ramps are none: the firmware counts in ms

// 0 unless the stretch after a knot is slower than the table's slowest; else its direction.
int CrawlAt(const StrokeSchedule& schedule, std::size_t i, const DutyTable& table) {
  const double speed = SpeedOf(schedule.knots[i], schedule.knots[i + 1]);
  const int direction = DirectionOf(speed);
  if (direction == 0) return 0;
  return std::abs(speed) < 0.999 * table.Curve(direction).LeastMovingSpeed() ? direction : 0;
}

// Rest, then catch up at `speed`, in steps that are as short as the brake and kLeastMove_s allow.
void AddSteps(const StrokeSchedule& schedule, std::size_t first, std::size_t last, double speed_mm_s,
              double dead_time_s, Knots& stepped, CrawlSummary& summary) {
  const Knots& plan = schedule.knots;
  const double begin = plan[first].stroke_mm, way = plan[last].stroke_mm - begin;
  const double duration_s = plan[last].time_s - plan[first].time_s, move_s = std::abs(way) / speed_mm_s;
  const double by_way = std::floor(std::abs(way) / std::max(kLeastStep_mm, speed_mm_s * kLeastMove_s) + kRounding);
  const double by_rest = std::floor((duration_s - move_s) / dead_time_s + kRounding);
  const int steps = static_cast<int>(std::max(1.0, std::min(by_way, by_rest)));
  double arrived_s = plan[first].time_s;
  for (int i = 1; i <= steps; ++i) {
    const double stroke = i == steps ? plan[last].stroke_mm : begin + way * i / steps;
    const double leave_s = std::max(TimeAt(plan, first, last, stroke) - move_s / steps, arrived_s);
    const double at = stepped.back().stroke_mm, planned = schedule.StrokeAt(leave_s);
    summary.stroke_error_mm = std::max(summary.stroke_error_mm, std::abs(planned - at));
    summary.knee_error_deg =
        std::max(summary.knee_error_deg, std::abs(KneeDegAt(schedule.links, planned) - KneeDegAt(schedule.links, at)));
    summary.added_rest_s += std::max(0.0, dead_time_s - (leave_s - arrived_s));
    arrived_s = leave_s + move_s / steps;
    stepped.push_back({leave_s + summary.added_rest_s, at});
    stepped.push_back({arrived_s + summary.added_rest_s, stroke});
  }
  summary.duration_s += duration_s;
  ++summary.stretches;
}

double HalfRamp(double change_mm_s, double most_mm_s2) {
  const double ramp_s = std::abs(change_mm_s) / most_mm_s2;
  return ramp_s < kLeastRamp_s ? 0 : ramp_s / 2;
}

// The parabola that takes the place of a knot: constant acceleration from one speed to the other.
void AddRamp(const Knot& knot, double before_mm_s, double after_mm_s, double half_s, Knots& ramped) {
  if (half_s == 0) {
    ramped.push_back(knot);
    return;
  }
  const int steps = static_cast<int>(std::ceil(2 * half_s / kRampStep_s));
  for (int i = 0; i <= steps; ++i) {
    const double t = half_s * (2.0 * i / steps - 1), since = t + half_s;
    const double stroke = knot.stroke_mm + before_mm_s * t + (after_mm_s - before_mm_s) * since * since / (4 * half_s);
    if (ramped.empty() || knot.time_s + t > ramped.back().time_s + 1e-9) ramped.push_back({knot.time_s + t, stroke});
  }
}

}  // namespace

CrawlSummary StepInsteadOfCrawling(StrokeSchedule& schedule, const DutyTable& table, double dead_time_s) {
  CrawlSummary summary;
  const Knots& plan = schedule.knots;
  Knots stepped = {plan.front()};
  for (std::size_t first = 0, last; first + 1 < plan.size(); first = last) {
    last = first + 1;
    const int direction = CrawlAt(schedule, first, table);
    if (direction == 0) {
      stepped.push_back({plan[last].time_s + summary.added_rest_s, plan[last].stroke_mm});
      continue;
    }
    while (last + 1 < plan.size() && CrawlAt(schedule, last, table) == direction) ++last;
    AddSteps(schedule, first, last, table.Curve(direction).LeastMovingSpeed(), dead_time_s, stepped, summary);
  }
  schedule.knots = std::move(stepped);
  schedule.added_rest_s += summary.added_rest_s;
  return summary;
}

void LimitAcceleration(StrokeSchedule& schedule, double most_mm_s2, double dead_time_s) {
  Knots& knots = schedule.knots;
  const std::size_t count = knots.size();
  std::vector<double> speeds = {0}, half_s;  // speeds[i] before knot i
  for (std::size_t i = 0; i + 1 < count; ++i) speeds.push_back(SpeedOf(knots[i], knots[i + 1]));
  speeds.push_back(0);
  for (std::size_t i = 0; i < count; ++i) half_s.push_back(HalfRamp(speeds[i + 1] - speeds[i], most_mm_s2));
  double later_s = half_s.front();
  schedule.added_rest_s += half_s.front() + half_s.back();
  Knots spread = {{later_s, knots.front().stroke_mm}};
  for (std::size_t i = 0; i + 1 < count; ++i) {
    const double length_s = knots[i + 1].time_s - knots[i].time_s, ramps_s = half_s[i] + half_s[i + 1];
    const bool rest = DirectionOf(speeds[i + 1]) == 0;
    const double missing_s = (rest ? std::min(length_s, dead_time_s) : 0) + ramps_s - length_s;
    if (!rest && missing_s > 1e-9)
      throw Fail(
          "the part at {} mm/s from {} s to {} s is too short for its ramps of {} s together; "
          "raise --max-acceleration ({} mm/s²) or slow the program down",
          SignificantText(speeds[i + 1], 4), SignificantText(knots[i].time_s, 4),
          SignificantText(knots[i + 1].time_s, 4), SignificantText(ramps_s, 4), most_mm_s2);
    if (rest && missing_s > 0) {
      later_s += missing_s;
      schedule.added_rest_s += missing_s;
    }
    spread.push_back({knots[i + 1].time_s + later_s, knots[i + 1].stroke_mm});
  }
  Knots ramped;
  for (std::size_t i = 0; i < count; ++i) AddRamp(spread[i], speeds[i], speeds[i + 1], half_s[i], ramped);
  knots = std::move(ramped);
}

}  // namespace lake::actuator
