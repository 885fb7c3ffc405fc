#include "lake/actuator/stroke_schedule.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"

namespace lake::actuator {

namespace {

using Knot = linkage::StrokeProgram::Knot;
using Knots = std::vector<Knot>;

constexpr double kStrokeTolerance_mm = 1e-6;  // of a solver's last digits
constexpr double kSpeedTolerance = 1e-6;      // relative, likewise

double StrokeAtAngle(const linkage::Design& design, const SoftLimits& limits, double angle_deg, const char* option) {
  const auto stroke = linkage::StrokeForAngle(design.links, limits.used, RadiansFromDegrees(angle_deg));
  if (stroke && *stroke >= limits.lower_mm - kStrokeTolerance_mm && *stroke <= limits.upper_mm + kStrokeTolerance_mm)
    return *stroke;
  const double a = KneeDegAt(design.links, limits.lower_mm), b = KneeDegAt(design.links, limits.upper_mm);
  throw UsageError("{} {}°: between its soft limits ({:.3f}..{:.3f} mm) this design has {:.2f}°..{:.2f}°", option,
                   angle_deg, limits.lower_mm, limits.upper_mm, std::min(a, b), std::max(a, b));
}

Knots ConstantKnots(const linkage::Design& design, const SoftLimits& limits, double speed_mm_s,
                    const ScheduleOptions& options) {
  const double from =
      options.from_deg ? StrokeAtAngle(design, limits, *options.from_deg, "--from-angle") : limits.lower_mm;
  const double to = options.to_deg ? StrokeAtAngle(design, limits, *options.to_deg, "--to-angle") : limits.upper_mm;
  if (std::abs(to - from) < kStrokeTolerance_mm)
    throw UsageError("the program starts where it ends, at a stroke of {:.3f} mm", from);
  return {{0, from}, {std::abs(to - from) / speed_mm_s, to}};
}

Knots BaseKnots(const linkage::Design& design, const SoftLimits& limits, const ScheduleOptions& options) {
  if (options.speed_mm_s) return ConstantKnots(design, limits, *options.speed_mm_s, options);
  if (!design.program) throw UsageError("the design has no program; give its constant speed with --speed MM_S");
  if (design.program->kind == linkage::StrokeProgram::Kind::kConstant)
    return ConstantKnots(design, limits, design.program->speed_mm_s, options);
  if (options.from_deg || options.to_deg)
    throw UsageError("--from-angle and --to-angle belong to a constant program; this design's has knots of its own");
  Knots knots = design.program->knots;
  const double start = knots.front().time_s;
  for (Knot& knot : knots) knot.time_s -= start;
  return knots;
}

void CheckLimits(Knots& knots, const SoftLimits& limits, double margin_mm) {
  for (Knot& knot : knots) {
    const bool low = knot.stroke_mm < limits.lower_mm - kStrokeTolerance_mm;
    if (low || knot.stroke_mm > limits.upper_mm + kStrokeTolerance_mm)
      throw Fail("the program's stroke {:.4f} mm at {} s is {} the soft limit {:.4f} mm (margin {} mm, see --margin)",
                 knot.stroke_mm, SignificantText(knot.time_s, 4), low ? "below" : "above",
                 low ? limits.lower_mm : limits.upper_mm, margin_mm);
    knot.stroke_mm = std::clamp(knot.stroke_mm, limits.lower_mm, limits.upper_mm);
  }
}

void CheckMaxSpeed(const Knots& knots, double max_speed_mm_s) {
  for (std::size_t i = 1; i < knots.size(); ++i) {
    const double speed = SpeedOf(knots[i - 1], knots[i]);
    if (std::abs(speed) > max_speed_mm_s * (1 + kSpeedTolerance))
      throw Fail("the program asks for {} mm/s from {} s to {} s; --max-speed is {} mm/s", SignificantText(speed, 4),
                 SignificantText(knots[i - 1].time_s, 4), SignificantText(knots[i].time_s, 4), max_speed_mm_s);
  }
}

void AppendReturn(Knots& knots, double hold_s) {
  const Knots there = knots;
  const double begin = there.back().time_s + hold_s;
  for (auto knot = there.rbegin(); knot != there.rend(); ++knot)
    if (hold_s > 0 || knot != there.rbegin())
      knots.push_back({begin + there.back().time_s - knot->time_s, knot->stroke_mm});
}

// The knots at which the direction changes, and both ends; of a rest at an extreme its first knot.
std::vector<std::size_t> Extremes(const Knots& knots) {
  std::vector<std::size_t> extremes = {0};
  int last_direction = 0;
  std::size_t arrived = 0;
  for (std::size_t i = 1; i < knots.size(); ++i) {
    const int direction = DirectionOf(SpeedOf(knots[i - 1], knots[i]));
    if (direction == 0) continue;
    if (last_direction == -direction) extremes.push_back(arrived);
    last_direction = direction;
    arrived = i;
  }
  extremes.push_back(knots.size() - 1);
  return extremes;
}

// The smallest reversal there and back becomes a rest half way between its two extremes, over and over: that moves the
// program by half of it.
void RestInsteadOfSmallReversals(StrokeSchedule& schedule, double most_mm) {
  Knots& knots = schedule.knots;
  for (;;) {
    const std::vector<std::size_t> extremes = Extremes(knots);
    std::size_t smallest = 0;
    double least = 2 * most_mm;
    for (std::size_t i = 1; i + 2 < extremes.size(); ++i) {
      const double way = std::abs(knots[extremes[i + 1]].stroke_mm - knots[extremes[i]].stroke_mm);
      const double before = std::abs(knots[extremes[i]].stroke_mm - knots[extremes[i - 1]].stroke_mm),
                   after = std::abs(knots[extremes[i + 2]].stroke_mm - knots[extremes[i + 1]].stroke_mm);
      if (way <= least && before > way / 2 && after > way / 2) {
        least = way;
        smallest = i;
      }
    }
    if (smallest == 0) return;
    const std::size_t from = extremes[smallest - 1], a = extremes[smallest], b = extremes[smallest + 1],
                      to = extremes[smallest + 2];
    const double level = (knots[a].stroke_mm + knots[b].stroke_mm) / 2;
    const double arrives_s = TimeAt(knots, from, a, level), leaves_s = TimeAt(knots, b, to, level);
    Knots rested;
    for (const Knot& knot : knots)
      if (knot.time_s < arrives_s) rested.push_back(knot);
    rested.push_back({arrives_s, level});
    rested.push_back({leaves_s, level});
    for (const Knot& knot : knots)
      if (knot.time_s > leaves_s) rested.push_back(knot);
    schedule.smoothed_mm = std::max(schedule.smoothed_mm, least / 2);
    knots = std::move(rested);
  }
}

// Puts in what is missing to a rest of `dead_time_s` before each change of direction.
void RestBeforeReversals(StrokeSchedule& schedule, double dead_time_s) {
  Knots rested = {schedule.knots.front()};
  int last_direction = 0;
  double rest_s = 0;
  for (std::size_t i = 1; i < schedule.knots.size(); ++i) {
    const Knot &a = schedule.knots[i - 1], &b = schedule.knots[i];
    const int direction = DirectionOf(SpeedOf(a, b));
    if (direction == 0) {
      rest_s += b.time_s - a.time_s;
    } else {
      if (direction == -last_direction) {
        ++schedule.reversals;
        const double missing_s = dead_time_s - rest_s;
        if (missing_s > 1e-9) {
          schedule.added_rest_s += missing_s;
          rested.push_back({a.time_s + schedule.added_rest_s, a.stroke_mm});
        }
      }
      last_direction = direction;
      rest_s = 0;
    }
    rested.push_back({b.time_s + schedule.added_rest_s, b.stroke_mm});
  }
  schedule.knots = std::move(rested);
}

}  // namespace

int DirectionOf(double speed_mm_s) {
  constexpr double kRest_mm_s = 0.0005;
  return speed_mm_s >= kRest_mm_s ? 1 : speed_mm_s <= -kRest_mm_s ? -1 : 0;
}

double TimeAt(const Knots& knots, std::size_t first, std::size_t last, double stroke_mm) {
  for (std::size_t i = first; i < last; ++i) {
    const double a = knots[i].stroke_mm - stroke_mm, b = knots[i + 1].stroke_mm - stroke_mm;
    if (a * b <= 0 && a != b) return std::lerp(knots[i].time_s, knots[i + 1].time_s, a / (a - b));
  }
  return knots[last].time_s;
}

double KneeDegAt(const linkage::Links& links, double stroke_mm) {
  return DegreesFromRadians(linkage::RequirePose(links, stroke_mm).theta_rad);
}

SoftLimits SoftLimitsOf(const linkage::Design& design, double margin_mm) {
  SoftLimits limits;
  limits.used = linkage::FindUsedRange(design.links, design.d_min_mm, design.d_max_mm);
  const linkage::StrokeRange& used = limits.used.stroke;
  limits.lower_mm = used.lower_mm;
  limits.upper_mm = used.upper_mm;
  limits.upper_end_mm = linkage::FindUsedRange(design.links, design.d_min_mm, std::nullopt).stroke.upper_mm;
  for (const linkage::StrokeRange& part : linkage::AssemblyRanges(design.links)) {
    if (!part.Contains(used.lower_mm)) continue;
    limits.lower_end_mm = part.lower_mm;
    limits.lower_mm = std::max(limits.lower_mm, part.lower_mm + margin_mm);
    limits.upper_end_mm = std::min(limits.upper_end_mm, part.upper_mm);
  }
  limits.upper_mm = std::min(limits.upper_mm, limits.upper_end_mm - margin_mm);
  if (!(limits.upper_mm > limits.lower_mm))
    throw Fail("a margin of {} mm leaves nothing of the used strokes {:.4f}..{:.4f} mm", margin_mm, used.lower_mm,
               used.upper_mm);
  return limits;
}

StrokeSchedule MakeSchedule(const linkage::Design& design, const ScheduleOptions& options) {
  StrokeSchedule schedule{design.links, SoftLimitsOf(design, options.margin_mm), {}};
  schedule.knots = BaseKnots(design, schedule.limits, options);
  CheckLimits(schedule.knots, schedule.limits, options.margin_mm);
  if (options.smooth_mm > 0) RestInsteadOfSmallReversals(schedule, options.smooth_mm);
  if (options.max_speed_mm_s) CheckMaxSpeed(schedule.knots, *options.max_speed_mm_s);
  if (options.return_trip) AppendReturn(schedule.knots, options.hold_s);
  RestBeforeReversals(schedule, options.dead_time_s);
  return schedule;
}

void CheckSpeeds(const StrokeSchedule& schedule, const DutyTable& table) {
  for (std::size_t i = 1; i < schedule.knots.size(); ++i) {
    const Knot &a = schedule.knots[i - 1], &b = schedule.knots[i];
    const double speed = SpeedOf(a, b);
    const int direction = DirectionOf(speed);
    if (direction == 0) continue;
    const DutyCurve& curve = table.Curve(direction);
    const bool fast = std::abs(speed) > curve.MostSpeed() * (1 + kSpeedTolerance);
    if (fast || std::abs(speed) < curve.LeastSpeed())
      throw Fail("the program asks for {} mm/s from {} s to {} s; {} has {}..{} mm/s {}", SignificantText(speed, 4),
                 SignificantText(a.time_s, 4), SignificantText(b.time_s, 4), table.name,
                 SignificantText(curve.LeastSpeed(), 4), SignificantText(curve.MostSpeed(), 4),
                 direction > 0 ? "extending" : "retracting");
  }
}

std::vector<ScheduleRow> SampleSchedule(const StrokeSchedule& schedule, double rate_hz, const DutyTable* table) {
  if (!(rate_hz > 0 && rate_hz <= 1000))
    throw UsageError("--rate must be above 0 and at most 1000 Hz, not {}", rate_hz);
  const double samples = std::floor(schedule.Duration() * rate_hz);
  if (!(samples + static_cast<double>(schedule.knots.size()) < static_cast<double>(kMostScheduleRows)))
    throw Fail("a program of {} s at {} Hz has more than {} rows; lower --rate or shorten the program",
               SignificantText(schedule.Duration(), 6), rate_hz, kMostScheduleRows);
  std::vector<double> times;
  for (std::size_t i = 0; static_cast<double>(i) <= samples; ++i) times.push_back(static_cast<double>(i) / rate_hz);
  for (const Knot& knot : schedule.knots) times.push_back(knot.time_s);
  std::sort(times.begin(), times.end());
  constexpr double kSameTime_s = 1e-9;
  times.erase(std::unique(times.begin(), times.end(), [](double a, double b) { return b - a < kSameTime_s; }),
              times.end());
  std::vector<ScheduleRow> rows;
  for (std::size_t i = 0; i < times.size(); ++i) {
    ScheduleRow row{times[i], schedule.StrokeAt(times[i])};
    row.knee_deg = KneeDegAt(schedule.links, row.stroke_mm);
    if (i + 1 < times.size())
      row.speed_mm_s = (schedule.StrokeAt(times[i + 1]) - row.stroke_mm) / (times[i + 1] - times[i]);
    row.direction = DirectionOf(row.speed_mm_s);
    row.duty = std::numeric_limits<double>::quiet_NaN();
    if (table) {
      const DutyCurve& curve = table->Curve(row.direction);
      row.duty = row.direction == 0
                     ? 0
                     : curve.DutyFor(std::clamp(std::abs(row.speed_mm_s), curve.LeastSpeed(), curve.MostSpeed()));
    }
    rows.push_back(row);
  }
  return rows;
}

void WriteScheduleCsv(const std::filesystem::path& path, const std::vector<ScheduleRow>& rows) {
  CsvWriter table({"time_s", "stroke_mm", "speed_mm_s", "knee_deg", "direction", "duty"});
  for (const ScheduleRow& row : rows)
    table.AddRow(row.time_s, row.stroke_mm, row.speed_mm_s, row.knee_deg, row.direction, row.duty);
  table.Write(path);
}

// What a motor with a screw cannot do: crawl below the speed at which it sticks, change its speed at once.

namespace {

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
