#include "lake/actuator/firmware.h"

#include <algorithm>
#include <cmath>

#include "lake/core/error.h"

namespace lake::actuator {
namespace {

using Knot = linkage::StrokeProgram::Knot;

constexpr double kMostStroke_mm = 2000;        // in nm within 32 bits
constexpr double kMostDuration_s = 2'000'000;  // in ms within 31 bits

// Douglas & Peucker 1973 in stroke over time: keeps those knots whose chord is farther than the tolerance.
void Thin(const std::vector<Knot>& knots, std::size_t first, std::size_t last, double tolerance_mm,
          std::vector<bool>& keep) {
  std::vector<std::pair<std::size_t, std::size_t>> todo = {{first, last}};
  while (!todo.empty()) {
    const auto [a, b] = todo.back();
    todo.pop_back();
    double worst = tolerance_mm;
    std::size_t at = a;
    for (std::size_t i = a + 1; i < b; ++i) {
      const double fraction = (knots[i].time_s - knots[a].time_s) / (knots[b].time_s - knots[a].time_s);
      const double distance =
          std::abs(std::lerp(knots[a].stroke_mm, knots[b].stroke_mm, fraction) - knots[i].stroke_mm);
      if (distance > worst) worst = distance, at = i;
    }
    keep[at] = true;
    if (at != a) todo.emplace_back(a, at), todo.emplace_back(at, b);
  }
}

// Turning points and rests stay, so that the reversals keep their pauses.
std::vector<Knot> Thinned(const std::vector<Knot>& knots, double tolerance_mm) {
  std::vector<bool> keep(knots.size(), false);
  const auto direction = [&](std::size_t i) {
    return DirectionOf((knots[i + 1].stroke_mm - knots[i].stroke_mm) / (knots[i + 1].time_s - knots[i].time_s));
  };
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
    throw Fail("a program of {:.6g} s is too long for the firmware, which counts up to {:.0f} s", schedule.Duration(),
               kMostDuration_s);
  if (schedule.limits.upper_mm > kMostStroke_mm)
    throw Fail("a stroke of {:.6g} mm is too long for the firmware, which counts up to {:.0f} mm",
               schedule.limits.upper_mm, kMostStroke_mm);
}

int CountsFor(const DutyTable& table, double speed_mm_s) {
  const int direction = DirectionOf(speed_mm_s);
  if (direction == 0) return 0;
  const DutyCurve& curve = table.Curve(direction);
  const double duty = curve.DutyFor(std::clamp(std::abs(speed_mm_s), curve.LeastSpeed(), curve.MostSpeed()));
  return static_cast<int>(std::lround(duty * kPwmPeriod));
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

double HighestStroke(const StrokeSchedule& schedule) {
  double highest = 0;
  for (const Knot& knot : schedule.knots) highest = std::max(highest, knot.stroke_mm);
  return highest;
}

std::int64_t Um(double mm) {
  return std::llround(mm * 1e3);
}

// Where the program starts, how the actuator gets there from the retract end stop.
struct Homing {
  double stroke_mm, speed_mm_s, position_speed_mm_s;
  int counts, position_counts;
  std::int64_t timeout_ms, back_off_ms, touch_timeout_ms;
  // From where the end stop was seen to release, one of them 0: on to the start, or back to it.
  std::int64_t position_ms = 0, return_ms = 0;
};

Homing HomingOf(const StrokeTable& stroke, const StrokeSchedule& schedule, const DutyTable& table,
                const FirmwareOptions& options) {
  Homing homing{};
  homing.stroke_mm = HomeStroke(stroke, schedule, options);
  if (homing.stroke_mm > stroke.start_mm + 1e-3)
    throw UsageError(
        fmt::format("--home-stroke {} mm is past the program's start at {:.3f} mm", homing.stroke_mm, stroke.start_mm));
  const auto speed = [&](const DutyCurve& curve) {
    return std::clamp(options.home_speed_mm_s, curve.LeastMovingSpeed(), curve.MostSpeed());
  };
  homing.speed_mm_s = speed(table.retract);
  homing.position_speed_mm_s = speed(table.extend);
  homing.counts = CountsFor(table, -homing.speed_mm_s);
  homing.position_counts = CountsFor(table, homing.position_speed_mm_s);
  const double travel_mm = schedule.limits.used.stroke.upper_mm - homing.stroke_mm;
  homing.timeout_ms = std::llround(1e3 * (1.5 * travel_mm / homing.speed_mm_s + 2));
  homing.back_off_ms = std::llround(1e3 * options.stop_travel_mm / homing.position_speed_mm_s);
  const double released_mm = homing.stroke_mm + 1e-3 * homing.back_off_ms * homing.position_speed_mm_s;
  if (stroke.start_mm >= released_mm)
    homing.position_ms = std::llround(1e3 * (stroke.start_mm - released_mm) / homing.position_speed_mm_s);
  else
    homing.return_ms = std::llround(1e3 * (released_mm - stroke.start_mm) / homing.speed_mm_s);
  homing.touch_timeout_ms = std::llround(1e3 * (2 * options.stop_travel_mm / homing.speed_mm_s + 1));
  return homing;
}

double ToleranceOf(const DutyTable& table, const FirmwareOptions& options) {
  return options.speed_tolerance_percent.value_or(table.TolerancePercent().value_or(kUnmeasuredTolerance_percent));
}

// The bound as the firmware has it: integers, ms by ms.
class DriftBound {
 public:
  DriftBound(const StrokeTable& stroke, const DutyTable& table, const FirmwareOptions& options,
             std::int64_t velocity_um_s = 0)
      : start_um_(std::llround(std::ceil(1e3 * (options.home_error_mm + stroke.pwm_error_mm)))),
        per_1024_(std::llround(std::ceil(10.24 * ToleranceOf(table, options)))),
        lag_ms_(std::llround(std::ceil(1e3 * options.lag_s))),
        velocity_um_s_(velocity_um_s) {}

  std::int64_t StartUm() const { return start_um_; }
  std::int64_t Per1024() const { return per_1024_; }
  std::int64_t LagMs() const { return lag_ms_; }

  void Turn(std::int64_t velocity_um_s) {
    const std::int64_t change = velocity_um_s - velocity_um_s_;
    velocity_um_s_ = velocity_um_s;
    (change < 0 ? slowing_nm_ : speeding_nm_) += std::abs(change) * lag_ms_;
  }
  void Go(std::int64_t ms) {
    way_nm_ += std::abs(velocity_um_s_) * ms;
    rounding_nm_ += velocity_um_s_ == 0 ? 0 : ms;
    tolerance_nm_ += ms * ((std::abs(velocity_um_s_) * per_1024_ + 1023) / 1024);
  }

  double Drift() const { return 1e-6 * static_cast<double>(FixedNm() + tolerance_nm_); }
  // The largest per_1024_ that stays below a room.
  double TolerablePer1024(double room_mm) const {
    const double left_nm = 1e6 * room_mm - static_cast<double>(FixedNm() + rounding_nm_);
    return way_nm_ > 0 ? std::floor(1024 * left_nm / static_cast<double>(way_nm_)) : left_nm > 0 ? 1024 : -1;
  }

 private:
  std::int64_t FixedNm() const { return 1000 * start_um_ + std::max(speeding_nm_, slowing_nm_); }

  std::int64_t start_um_, per_1024_, lag_ms_;
  std::int64_t velocity_um_s_;
  std::int64_t way_nm_ = 0, rounding_nm_ = 0, tolerance_nm_ = 0, speeding_nm_ = 0, slowing_nm_ = 0;
};

// Follows the bound to the linkage's upper end.
class DriftWatch {
 public:
  DriftWatch(DriftBound bound, DriftForecast& forecast) : bound_(bound), forecast_(forecast) {}

  void Turn(std::int64_t velocity_um_s, double time_s, double planned_mm) {
    bound_.Turn(velocity_um_s);
    Look(time_s, planned_mm);
  }
  void Go(std::int64_t ms, double time_s, double planned_mm) {
    bound_.Go(ms);
    Look(time_s, planned_mm);
  }
  double Drift() const { return bound_.Drift(); }
  double TolerablePercent() const { return std::floor(10 * tolerable_per_1024_ / 10.24) / 10; }

 private:
  void Look(double time_s, double planned_mm) {
    tolerable_per_1024_ = std::min(tolerable_per_1024_, bound_.TolerablePer1024(forecast_.end_mm - planned_mm));
    if (planned_mm + bound_.Drift() <= forecast_.planned_mm + forecast_.drift_mm) return;
    forecast_.time_s = time_s, forecast_.planned_mm = planned_mm, forecast_.drift_mm = bound_.Drift();
  }

  DriftBound bound_;
  DriftForecast& forecast_;
  double tolerable_per_1024_ = 1024;
};

// How far past an end stop the actuator may come to rest, faster than planned by the speeds' tolerance.
double RunOn(double speed_mm_s, const DutyTable& table, const FirmwareOptions& options) {
  return options.home_error_mm + options.lag_s * speed_mm_s * (1 + ToleranceOf(table, options) / 100);
}

// The least --extend-stop, in 0.1 mm: of the fastest jog.
double LeastExtendStop(const DutyTable& table, const FirmwareOptions& options) {
  return std::floor(10 * RunOn(table.extend.MostSpeed(), table, options) + 1) / 10;
}

void RequireExtendStop(const StrokeSchedule& schedule, const DutyTable& table, const FirmwareOptions& options) {
  const double stop_mm = *ExtendStop(schedule, options), end_mm = schedule.limits.upper_end_mm;
  if (options.extend_stop_mm < LeastExtendStop(table, options) - 1e-9)
    throw Fail(
        "past an extend end stop at {:.3f} mm the actuator may run on by {:.3f} mm, to the linkage's end at {:.3f} mm: "
        "give --extend-stop {:.1f} or more",
        stop_mm, RunOn(table.extend.MostSpeed(), table, options), end_mm, LeastExtendStop(table, options));
  if (HighestStroke(schedule) >= stop_mm)
    throw Fail(
        "the program goes to {:.3f} mm, and the extend end stop acts at {:.3f} mm: a smaller --extend-stop, or a "
        "program that ends earlier",
        HighestStroke(schedule), stop_mm);
}

void RequireRoom(const DriftForecast& forecast, const StrokeSchedule& schedule, const DutyTable& table,
                 const FirmwareOptions& options) {
  if (forecast.Fits()) return;
  std::string stop;
  if (const double least_mm = LeastExtendStop(table, options); HighestStroke(schedule) < forecast.end_mm - least_mm)
    stop = fmt::format("an extend end stop before it (--extend-stop {:.1f}), ", least_mm);
  std::string tolerance;
  if (forecast.tolerable_percent > 0)
    tolerance = fmt::format(
        "a duty table with a measured tolerance of at most {:.1f} % (lake-stroke calibrate; now {:.3g} %{}), ",
        forecast.tolerable_percent, forecast.tolerance_percent, forecast.is_measured ? "" : ", not measured");
  throw Fail(
      "the drift may carry the actuator past the linkage's end at {:.3f} mm: {:.3f} ± {:.3f} mm are planned at {:.2f} "
      "s. "
      "Ways out: {}{}a program that ends at least {:.1f} mm earlier (--margin or --to-angle, if its speed is "
      "constant), "
      "or "
      "--accept-drift on a bench without a person",
      forecast.end_mm, forecast.planned_mm, forecast.drift_mm, forecast.time_s, stop, tolerance,
      std::ceil(10 * (forecast.drift_mm - forecast.Room()) + 0.01) / 10);
}

// Homing keeps the lower soft limit, run-on past the switch and all.
void RequireHome(const Homing& homing, const SoftLimits& limits, const DutyTable& table,
                 const FirmwareOptions& options) {
  if (homing.stroke_mm < limits.lower_mm - 1e-3)
    throw UsageError(fmt::format(
        "--home-stroke {:.3f} mm is below the soft limit {:.3f} mm: put the retract end stop there, or give "
        "--accept-drift on a bench without a person",
        homing.stroke_mm, limits.lower_mm));
  const double run_on_mm = RunOn(homing.speed_mm_s, table, options);
  if (homing.stroke_mm - run_on_mm <= limits.lower_end_mm)
    throw Fail(
        "homing to {:.3f} mm may run on by {:.3f} mm, past the linkage's end at {:.3f} mm: raise --margin or "
        "--home-stroke, lower --home-speed, or give --accept-drift on a bench without a person",
        homing.stroke_mm, run_on_mm, limits.lower_end_mm);
}

std::string SegmentRows(const StrokeTable& stroke) {
  std::string text;
  for (const StrokeSegment& segment : stroke.segments)
    text += fmt::format("    {{{}, {}, {}}},\n", segment.end_ms, segment.velocity_um_s, segment.counts);
  return text;
}

// The greatest speed of each duty: below the first row, if that moves, it may be the row's, and no speed without duty.
std::string SpeedRow(const DutyCurve& curve) {
  std::string text = "0";
  for (int i = 1; i <= kSpeedIntervals; ++i)
    text += fmt::format(", {}", Um(std::max(curve.LeastSpeed(), curve.SpeedFor(i / double{kSpeedIntervals}))));
  return text;
}

// The first node that lies within the measured duties.
int FirstNode(const DutyCurve& curve) {
  return static_cast<int>(std::ceil(curve.DeadBandDuty() * kSpeedIntervals - 1e-9));
}

int MostCounts(const DutyCurve& curve) {
  return static_cast<int>(std::lround(curve.MostDuty() * kPwmPeriod));
}

std::string Comment(const std::string& text) {
  std::string line;
  for (const char c : text) line += c == '\n' || c == '\r' || c == '\\' ? ' ' : c;
  return line;
}

// Readings are sums of four conversions of 10 bits, of 5 V.
constexpr double kMostReading = 4092, kReference_v = 5;

int ReadingOf(double volt) {
  return static_cast<int>(std::lround(std::clamp(volt / kReference_v, 0.0, 1.0) * kMostReading));
}

std::string SupplyDefines(const FirmwareOptions& options) {
  const double sensed_v = options.supply_v / kSupplyDivider;
  return fmt::format("#define LAKE_SUPPLY_SENSE {}\n#define LAKE_SUPPLY_LEAST {}\n#define LAKE_SUPPLY_MOST {}\n",
                     options.supply_v > 0 ? 1 : 0, ReadingOf(sensed_v * (1 - kSupplyTolerance)),
                     ReadingOf(sensed_v * (1 + kSupplyTolerance)));
}

std::string CurrentDefines(const FirmwareOptions& options) {
  constexpr int kLeast_ma = 40;  // of any motor that turns
  return fmt::format(
      "#define LAKE_CURRENT_SENSE {}\n#define LAKE_CURRENT_ZERO {}\n#define LAKE_CURRENT_UA_PER_COUNT {}L\n#define "
      "LAKE_CURRENT_MOST_MA {}\n#define LAKE_CURRENT_STALL_MA {}\n#define LAKE_CURRENT_LEAST_MA {}\n",
      options.current_sense ? 1 : 0, ReadingOf(options.current_zero_v),
      std::lround(1e6 * kReference_v / kMostReading / options.current_v_per_a),
      std::lround(1e3 * options.max_current_a), std::lround(1e3 * options.stall_current_a), kLeast_ma);
}

// The stroke of a reading, and the readings that no stroke between the ends has: 5 mm beyond them, or near a rail.
std::string FeedbackDefines(const FirmwareOptions& options, const SoftLimits* limits) {
  if (options.feedback == Feedback::kNone || !limits) return "#define LAKE_FEEDBACK 0\n";
  const PotentiometerScale& scale = *options.potentiometer;
  constexpr double kBeyond_mm = 5, kRail = 40;
  const double mm_per_reading = (scale.mm_b - scale.mm_a) / (scale.counts_b - scale.counts_a) / 4;
  const double zero_mm = scale.mm_a - 4 * scale.counts_a * mm_per_reading;
  const double a = (limits->lower_end_mm - kBeyond_mm - zero_mm) / mm_per_reading,
               b = (limits->upper_end_mm + kBeyond_mm - zero_mm) / mm_per_reading;
  const auto reading = [&](double value) { return std::lround(std::clamp(value, kRail, kMostReading - kRail)); };
  return fmt::format(
      "#define LAKE_FEEDBACK 1\n#define LAKE_POT_ZERO_NM {}L  // the stroke of a reading of 0, …\n#define "
      "LAKE_POT_NM_PER_COUNT {}L  // … of sums of four\n#define LAKE_POT_LEAST {}\n#define LAKE_POT_MOST {}\n#define "
      "LAKE_POT_ERROR_UM {}L\n",
      std::llround(1e6 * zero_mm), std::llround(1e6 * mm_per_reading), reading(std::min(a, b)), reading(std::max(a, b)),
      Um(options.feedback_error_mm));
}

// Without standard errors nobody has measured it: a model's, or a data sheet's.
bool IsMeasured(const DutyTable& table) {
  return std::any_of(table.rows.begin(), table.rows.end(), [](const DutyRow& row) {
    return !std::isnan(row.extend_se_mm_s) || !std::isnan(row.retract_se_mm_s);
  });
}

std::string DutyTableName(const DutyTable& table) {
  return IsMeasured(table) ? "measured" : "MODEL, not measured";
}

std::string CommonDefines(const FirmwareOptions& options, std::size_t segments, const SoftLimits* limits) {
  return fmt::format(
             "#define LAKE_PWM_PERIOD {}  // counts: 4 kHz at 16 MHz\n#define LAKE_DEAD_TIME_MS {}  // brake before "
             "anything else\n#define LAKE_COMMAND_TIMEOUT_MS {}  // 0: none\n#define LAKE_SEGMENT_COUNT {}\n",
             kPwmPeriod, std::llround(1e3 * options.dead_time_s), std::llround(1e3 * options.command_timeout_s),
             segments) +
         SupplyDefines(options) + CurrentDefines(options) + FeedbackDefines(options, limits);
}

// The tolerances behind the bound on the drift.
std::string DriftDefines(const DriftBound& bound, const FirmwareOptions& options) {
  return fmt::format(
      "#define LAKE_DRIFT_START_UM {}  // the bound on the drift: at first, …\n#define LAKE_DRIFT_PER_1024 {}  // … "
      "per 1024 of the way, …\n#define LAKE_LAG_MS {}  // … and per change of speed\n#define LAKE_DRIFT_ACCEPTED "
      "{}\n#define LAKE_DRIFT_LIMITED {}  // 0: accepted, or an extend end stop comes first\n",
      bound.StartUm(), bound.Per1024(), bound.LagMs(), options.accept_drift ? 1 : 0,
      options.accept_drift || options.extend_stop_mm > 0 ? 0 : 1);
}

constexpr const char* kTypes =
    "\ntypedef struct {\n  uint32_t end_ms;         // since the program's start\n"
    "  int32_t velocity_um_s;   // positive extends\n  uint16_t counts;         // PWM\n} lake_segment;\n\n";

}  // namespace

void FirmwareOptions::Check() const {
  const auto require = [](bool good, const char* option, double value, const char* what) {
    if (!good) throw UsageError(fmt::format("{} must be {}, not {}", option, what, value));
  };
  require(home_stroke_mm >= 0 && home_stroke_mm <= kMostStroke_mm, "--home-stroke", home_stroke_mm,
          "within 0..2000 mm");
  require(home_speed_mm_s > 0 && home_speed_mm_s <= 1000, "--home-speed", home_speed_mm_s,
          "above 0 and at most 1000 mm/s");
  require(dead_time_s >= kLeastDeadTime_s && dead_time_s <= 5, "--dead-time", dead_time_s, "within 0.1..5 s");
  require(command_timeout_s == 0 || (command_timeout_s >= 0.1 && command_timeout_s <= 60), "--command-timeout",
          command_timeout_s, "0 or within 0.1..60 s");
  if (speed_tolerance_percent)
    require(*speed_tolerance_percent >= 0 && *speed_tolerance_percent <= 100, "--speed-tolerance",
            *speed_tolerance_percent, "within 0..100 percent");
  require(extend_stop_mm >= 0 && extend_stop_mm <= 100, "--extend-stop", extend_stop_mm, "within 0..100 mm");
  require(stop_travel_mm >= 0.1 && stop_travel_mm <= 10, "--stop-travel", stop_travel_mm, "within 0.1..10 mm");
  require(lag_s >= 0 && lag_s <= 0.5, "--lag", lag_s, "within 0..0.5 s");
  require(home_error_mm >= 0 && home_error_mm <= 10, "--home-error", home_error_mm, "within 0..10 mm");
  require(supply_v == 0 || (supply_v >= 4 && supply_v * (1 + kSupplyTolerance) / kSupplyDivider < 4.95), "--supply",
          supply_v, "0 or within 4..17.3 V");
  if (feedback == Feedback::kPotentiometer && !potentiometer)
    throw UsageError(
        "--feedback pot needs the potentiometer's scale, two readings with their strokes: --pot COUNTS=MM,COUNTS=MM");
  require(feedback_error_mm >= 0 && feedback_error_mm <= 10, "--feedback-error", feedback_error_mm, "within 0..10 mm");
  require(current_zero_v >= 0 && current_zero_v <= 4, "--current-zero", current_zero_v, "within 0..4 V");
  require(current_v_per_a >= 0.01 && current_v_per_a <= 5, "--current-scale", current_v_per_a, "within 0.01..5 V/A");
  require(max_current_a > 0 && max_current_a * current_v_per_a + current_zero_v < 4.9, "--max-current", max_current_a,
          "above 0 and within what the sensor reads below 4.9 V");
  require(stall_current_a > 0 && stall_current_a <= max_current_a, "--stall-current", stall_current_a,
          "above 0 and at most --max-current");
  require(table_tolerance_mm > 0 && table_tolerance_mm <= 10, "--table-tolerance", table_tolerance_mm,
          "above 0 and at most 10 mm");
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
    const double exact = (knots[i].stroke_mm - knots[i - 1].stroke_mm) / (knots[i].time_s - knots[i - 1].time_s);
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

std::optional<double> ExtendStop(const StrokeSchedule& schedule, const FirmwareOptions& options) {
  if (options.extend_stop_mm == 0) return std::nullopt;
  return schedule.limits.upper_end_mm - options.extend_stop_mm;
}

double HomeStroke(const StrokeTable& stroke, const StrokeSchedule& schedule, const FirmwareOptions& options) {
  return options.home_stroke_mm > 0 ? options.home_stroke_mm : std::min(schedule.limits.lower_mm, stroke.start_mm);
}

DriftForecast ForecastDrift(const StrokeTable& stroke, const StrokeSchedule& schedule, const DutyTable& table,
                            const FirmwareOptions& options) {
  const Homing homing = HomingOf(stroke, schedule, table, options);
  DriftForecast forecast;
  forecast.tolerance_percent = ToleranceOf(table, options);
  forecast.is_measured = !options.speed_tolerance_percent && table.TolerancePercent();
  forecast.end_mm = schedule.limits.upper_end_mm;
  if (options.feedback == Feedback::kPotentiometer) {
    forecast.planned_mm = HighestStroke(schedule);
    forecast.drift_mm = forecast.last_drift_mm = options.feedback_error_mm + kFollowingError_mm;
    forecast.tolerable_percent = 100;
    return forecast;
  }
  DriftWatch watch(DriftBound(stroke, table, options, -Um(homing.speed_mm_s)), forecast);
  // Homing ends by a stop from its speed; then to the start.
  watch.Turn(0, 0, homing.stroke_mm);
  watch.Turn(Um(homing.position_speed_mm_s), 0, homing.stroke_mm);
  watch.Go(homing.back_off_ms + homing.position_ms, 0,
           std::max(stroke.start_mm, homing.stroke_mm + options.stop_travel_mm));
  watch.Turn(0, 0, stroke.start_mm);
  if (homing.return_ms > 0) {
    watch.Turn(-Um(homing.speed_mm_s), 0, stroke.start_mm);
    watch.Go(homing.return_ms, 0, stroke.start_mm);
    watch.Turn(0, 0, stroke.start_mm);
  }
  std::int64_t now_ms = 0;
  double planned_mm = stroke.start_mm;
  for (const StrokeSegment& segment : stroke.segments) {
    watch.Turn(segment.velocity_um_s, 1e-3 * static_cast<double>(now_ms), planned_mm);
    planned_mm += 1e-6 * static_cast<double>(segment.velocity_um_s * (segment.end_ms - now_ms));
    watch.Go(segment.end_ms - now_ms, 1e-3 * static_cast<double>(segment.end_ms), planned_mm);
    now_ms = segment.end_ms;
  }
  watch.Turn(0, 1e-3 * static_cast<double>(now_ms), planned_mm);
  forecast.last_drift_mm = watch.Drift();
  forecast.tolerable_percent = watch.TolerablePercent();
  return forecast;
}

std::string StrokeTableHeader(const StrokeTable& stroke, const StrokeSchedule& schedule, const DutyTable& table,
                              const FirmwareOptions& options, const std::string& made_by) {
  const Homing homing = HomingOf(stroke, schedule, table, options);
  if (!options.accept_drift) {
    RequireHome(homing, schedule.limits, table, options);
    if (options.extend_stop_mm > 0)
      RequireExtendStop(schedule, table, options);
    else
      RequireRoom(ForecastDrift(stroke, schedule, table, options), schedule, table, options);
  }
  std::string text = options.accept_drift ? kDriftAccepted : "";
  text += fmt::format("// Stroke program for the UNO. {}\n", Comment(made_by));
  text += "#ifndef LAKE_STROKE_TABLE_H\n#define LAKE_STROKE_TABLE_H\n\n#include \"portable.h\"\n\n";
  text += CommonDefines(options, stroke.segments.size(), &schedule.limits);
  text += DriftDefines(DriftBound(stroke, table, options), options);
  text += fmt::format("#define LAKE_SPEED_INTERVALS {}\n", kSpeedIntervals);
  text += fmt::format("#define LAKE_LOWER_LIMIT_UM {}L\n#define LAKE_UPPER_LIMIT_UM {}L\n#define LAKE_START_UM {}L\n",
                      Um(std::min(schedule.limits.lower_mm, stroke.start_mm)), Um(schedule.limits.upper_mm),
                      Um(stroke.start_mm));
  text += fmt::format("#define LAKE_UPPER_END_UM {}L  // of the linkage: what the drift must not reach\n",
                      Um(schedule.limits.upper_end_mm));
  text += fmt::format("#define LAKE_STOP_TRAVEL_UM {}L  // within which an end stop releases\n",
                      Um(options.stop_travel_mm));
  text += fmt::format("#define LAKE_EXTEND_STOP_UM {}L  // 0: there is none\n",
                      Um(ExtendStop(schedule, options).value_or(0)));
  text += fmt::format(
      "#define LAKE_EXTEND_LEAST_UM_S {}L  // that the duty table has\n#define LAKE_EXTEND_MOST_UM_S {}L\n#define "
      "LAKE_RETRACT_LEAST_UM_S {}L\n#define LAKE_RETRACT_MOST_UM_S {}L\n",
      Um(table.extend.LeastMovingSpeed()), Um(table.extend.MostSpeed()), Um(table.retract.LeastMovingSpeed()),
      Um(table.retract.MostSpeed()));
  text += fmt::format("#define LAKE_HOME_KNEE \"{:.1f}\"  // degrees\n", KneeDegAt(schedule.links, homing.stroke_mm));
  text += fmt::format("#define LAKE_DESIGN \"{}\"\n#define LAKE_DUTY_TABLE \"{}\"\n", options.design_hash,
                      DutyTableName(table));
  text += fmt::format("#define LAKE_HOME_UM {}L  // at the retract end stop\n", Um(homing.stroke_mm));
  text +=
      fmt::format("#define LAKE_HOME_COUNTS {}\n#define LAKE_HOME_SPEED_UM_S {}L\n#define LAKE_HOME_TIMEOUT_MS {}L\n",
                  homing.counts, Um(homing.speed_mm_s), homing.timeout_ms);
  text += fmt::format(
      "#define LAKE_POSITION_COUNTS {}  // away from the end stop\n#define LAKE_POSITION_SPEED_UM_S {}L\n"
      "#define LAKE_POSITION_MS {}L  // from where it has released on to the start, …\n"
      "#define LAKE_RETURN_MS {}L  // … or back to it\n",
      homing.position_counts, Um(homing.position_speed_mm_s), homing.position_ms, homing.return_ms);
  text += fmt::format(
      "#define LAKE_BACK_OFF_MS {}L  // from the end stop, to see it release\n#define LAKE_TOUCH_TIMEOUT_MS {}L\n",
      homing.back_off_ms, homing.touch_timeout_ms);
  text += fmt::format(
      "#define LAKE_EXTEND_FIRST_NODE {}  // of lake_speed_um_s: below it a duty may also stand still\n"
      "#define LAKE_RETRACT_FIRST_NODE {}\n#define LAKE_EXTEND_MOST_COUNTS {}u  // the duty table ends there\n"
      "#define LAKE_RETRACT_MOST_COUNTS {}u\n",
      FirstNode(table.extend), FirstNode(table.retract), MostCounts(table.extend), MostCounts(table.retract));
  text += kTypes;
  text += "static const lake_segment lake_segments[LAKE_SEGMENT_COUNT] PROGMEM = {\n" + SegmentRows(stroke) + "};\n\n";
  text += "// The greatest speed, um/s, at equal steps of duty from 0 to 1: extending, retracting.\n";
  text += fmt::format(
      "static const uint32_t lake_speed_um_s[2][LAKE_SPEED_INTERVALS + 1] PROGMEM = {{\n    {{{}}},\n    "
      "{{{}}}}};\n\n#endif\n",
      SpeedRow(table.extend), SpeedRow(table.retract));
  return text;
}

std::string SketchNotes(const StrokeTable& stroke, const StrokeSchedule& schedule, const DutyTable& table,
                        const FirmwareOptions& options, const std::string& from) {
  const double home_mm = HomeStroke(stroke, schedule, options);
  const auto place = [&](double stroke_mm) {
    return fmt::format("{:.3f} mm (knee {:.1f} degrees)", stroke_mm, KneeDegAt(schedule.links, stroke_mm));
  };
  std::string text = options.accept_drift ? kDriftAccepted : "";
  text += fmt::format("// {}\n// Design {} (SHA-256), duty table: {}.\n//\n", Comment(from), options.design_hash,
                      DutyTableName(table));
  if (!IsMeasured(table))
    text += "// WARNING: MODEL duty table. This actuator's speeds were not measured: lake-stroke calibrate.\n";
  text += fmt::format("// WARNING: UNWORN ONLY: home takes the knee to {:.1f} degrees.\n",
                      KneeDegAt(schedule.links, home_mm));
  if (options.feedback == Feedback::kNone)
    text += "// WARNING: open loop. The stroke that it says is planned; what the actuator does nobody measures.\n";
  if (options.supply_v == 0) text += "// WARNING: it does not see the emergency stop: after one, reset and home.\n";
  text += fmt::format("// Program: from {} to {} in {:.1f} s, {} segments.\n", place(stroke.start_mm),
                      place(schedule.knots.back().stroke_mm), schedule.Duration(), stroke.segments.size());
  text += fmt::format("// Retract end stop at {}; extend end stop {}. The linkage ends at {:.3f} and {:.3f} mm.\n",
                      place(home_mm),
                      options.extend_stop_mm > 0 ? "at " + place(*ExtendStop(schedule, options))
                                                 : "before the linkage's end, as near as it can be put",
                      schedule.limits.lower_end_mm, schedule.limits.upper_end_mm);
  text += "// Pins, commands, error codes: README.txt in this folder.\n\n";
  return text;
}

std::string CalibrationHeader(const FirmwareOptions& options, const std::string& made_by) {
  return fmt::format(
      "// No program: a firmware that jogs, for the logs of lake-stroke calibrate. {}\n#ifndef LAKE_STROKE_TABLE_H\n"
      "#define LAKE_STROKE_TABLE_H\n\n{}\n#endif\n",
      Comment(made_by), CommonDefines(options, 0, nullptr));
}

}  // namespace lake::actuator
