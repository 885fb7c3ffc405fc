#include "lake/actuator/firmware.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "homing.h"
#include "lake/core/error.h"
#include "lake/core/provenance.h"
#include "lake/core/uncertain_text.h"
#include "pin_name.h"

namespace lake::actuator {
namespace {

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

static_assert(kSupplyTolerance < 0.5, "the firmware's factor for a low supply is less than 2");

// Readings are sums of four conversions of 10 bits.
constexpr double kMostCount = 1023, kMostReading = 4 * kMostCount;

int ReadingOf(double volt) {
  return static_cast<int>(std::lround(std::clamp(volt / kReference_v, 0.0, 1.0) * kMostReading));
}

// The highest voltage at A2 that is told from the converter's end, before the divider and with the supply's tolerance.
constexpr double kMostSupply_v = 0.99 * kReference_v * kSupplyDivider / (1 + kSupplyTolerance);

std::string SupplyDefines(const FirmwareOptions& options) {
  const auto reading = [&](double part) { return ReadingOf(part * options.supply_v / kSupplyDivider); };
  return fmt::format(
      "#define LAKE_SUPPLY_SENSE {}\n#define LAKE_SUPPLY_LEAST {}\n#define LAKE_SUPPLY_MOST {}\n"
      "#define LAKE_SUPPLY_NOMINAL {}\n#define LAKE_SUPPLY_NEAR_LEAST {}  // in open loop\n#define "
      "LAKE_SUPPLY_NEAR_MOST {}\n",
      options.supply_v > 0 ? 1 : 0, reading(1 - kSupplyTolerance), reading(1 + kSupplyTolerance), reading(1),
      reading(1 - kOpenLoopSupplyTolerance), reading(1 + kOpenLoopSupplyTolerance));
}

std::string PinDefines(const FirmwareOptions& options) {
  const Pins& pins = options.pins;
  std::string text;
  for (const auto& [name, pin] : std::initializer_list<std::pair<const char*, int>>{{"ENA", pins.ena},
                                                                                    {"IN1", pins.in1},
                                                                                    {"IN2", pins.in2},
                                                                                    {"RETRACT", pins.retract},
                                                                                    {"EXTEND", pins.extend},
                                                                                    {"OUT1", pins.out1},
                                                                                    {"OUT2", pins.out2}})
    text += fmt::format("#define LAKE_PIN_{} {}\n", name, pin);
  if (pins.safety_relay) text += fmt::format("#define LAKE_PIN_RELAY {}\n", *pins.safety_relay);
  if (pins.hold_button) text += fmt::format("#define LAKE_PIN_BUTTON {}\n", *pins.hold_button);
  return text + fmt::format("#define LAKE_BRIDGE_SENSE {}\n#define LAKE_RELAY {}\n#define LAKE_BUTTON {}\n",
                            options.bridge_sense ? 1 : 0, pins.safety_relay ? 1 : 0, pins.hold_button ? 1 : 0);
}

std::string CurrentDefines(const FirmwareOptions& options) {
  constexpr int kLeast_ma = 100;  // of any motor that is being started
  return fmt::format(
      "#define LAKE_CURRENT_SENSE {}\n#define LAKE_CURRENT_ZERO {}\n#define LAKE_CURRENT_UA_PER_COUNT {}L\n#define "
      "LAKE_CURRENT_MOST_MA {}\n#define LAKE_CURRENT_STALL_MA {}\n#define LAKE_CURRENT_LEAST_MA {}\n",
      options.current_sense ? 1 : 0, ReadingOf(options.current_zero_v),
      std::lround(1e6 * kReference_v / kMostReading / options.current_v_per_a),
      std::lround(1e3 * options.max_current_a), std::lround(1e3 * options.StallCurrent()), kLeast_ma);
}

// Nearer to a rail a reading is one of a wiper that is lost or shorted.
constexpr double kRail = 40;

// The line through the two points of --pot.
struct PotentiometerLine {
  explicit PotentiometerLine(const PotentiometerScale& scale)
      : mm_per_reading((scale.mm_b - scale.mm_a) / (scale.counts_b - scale.counts_a) / 4),
        zero_mm(scale.mm_a - 4 * scale.counts_a * mm_per_reading) {}

  double ReadingAt(double stroke_mm) const { return (stroke_mm - zero_mm) / mm_per_reading; }

  double mm_per_reading, zero_mm;  // the stroke of a reading of 0
};

// By how much a stroke may be off as the converter has whole counts: half a count of the reading itself, and half a
// count of either point of the scale, which grows beyond them.
double CountingError(const PotentiometerScale& scale, double stroke_mm) {
  const double mm_per_count = std::abs(4 * PotentiometerLine(scale).mm_per_reading);
  const double distances = std::abs(stroke_mm - scale.mm_a) + std::abs(stroke_mm - scale.mm_b);
  return mm_per_count / 2 * (1 + distances / std::abs(scale.mm_b - scale.mm_a));
}

// The converter sees every stroke of the program, from home on, and finely enough.
void RequirePotentiometer(const FirmwareOptions& options, const StrokeSchedule& schedule, double home_mm) {
  const PotentiometerScale& scale = *options.potentiometer;
  const PotentiometerLine line(scale);
  const std::string pot = fmt::format("--pot {}={},{}={}", scale.counts_a, scale.mm_a, scale.counts_b, scale.mm_b);
  const auto [lowest, highest] = std::ranges::minmax(schedule.knots, {}, &linkage::StrokeProgram::Knot::stroke_mm);
  for (const double stroke_mm : {std::min(lowest.stroke_mm, home_mm), highest.stroke_mm}) {
    const double reading = line.ReadingAt(stroke_mm), error_mm = CountingError(scale, stroke_mm);
    if (reading < kRail || reading > kMostReading - kRail)
      throw UsageError(
          "{}: a stroke of {:.3f} mm, where home and program go, would read {:.1f} counts, and only {} to {} are "
          "believed: measure the two points again (counts of the firmware's adc column, strokes in mm from pin to "
          "pin), or take a potentiometer that covers the program",
          pot, stroke_mm, reading / 4, kRail / 4, kMostCount - kRail / 4);
    if (error_mm > options.feedback_error_mm)
      throw UsageError(
          "{}: one count is {} mm, so a stroke of {:.3f} mm may be off by {} mm, and --feedback-error is {} mm: "
          "measure two points farther apart, take a potentiometer of shorter travel, or give a larger --feedback-error",
          pot, SignificantText(std::abs(4 * line.mm_per_reading), 3), stroke_mm, SignificantText(error_mm, 3),
          options.feedback_error_mm);
  }
  const double first_mm = line.zero_mm, last_mm = line.zero_mm + kMostReading * line.mm_per_reading;
  if (std::max(std::abs(first_mm), std::abs(last_mm)) > kMostStroke_mm)
    throw UsageError("{}: 0 to {} counts would be {:.0f} to {:.0f} mm, and the firmware counts to {} mm", pot,
                     kMostCount, first_mm, last_mm, kMostStroke_mm);
}

// The stroke of a reading, and the readings that no stroke between the ends has: 5 mm beyond them, or near a rail.
std::string FeedbackDefines(const FirmwareOptions& options, const SoftLimits* limits) {
  if (options.feedback == Feedback::kNone || !limits) return "#define LAKE_FEEDBACK 0\n";
  constexpr double kBeyond_mm = 5;
  const PotentiometerLine line(*options.potentiometer);
  const double a = line.ReadingAt(limits->lower_end_mm - kBeyond_mm),
               b = line.ReadingAt(limits->upper_end_mm + kBeyond_mm);
  const auto reading = [&](double value) { return std::lround(std::clamp(value, kRail, kMostReading - kRail)); };
  return fmt::format(
      "#define LAKE_FEEDBACK 1\n#define LAKE_POT_ZERO_NM {}L  // the stroke of a reading of 0, …\n#define "
      "LAKE_POT_NM_PER_COUNT {}L  // … of sums of four\n#define LAKE_POT_LEAST {}\n#define LAKE_POT_MOST {}\n#define "
      "LAKE_POT_ERROR_UM {}L\n",
      std::llround(1e6 * line.zero_mm), std::llround(1e6 * line.mm_per_reading), reading(std::min(a, b)),
      reading(std::max(a, b)), Um(options.feedback_error_mm));
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
             "#define LAKE_PWM_PERIOD {}  // counts: 4 kHz at 16 MHz\n#define LAKE_DEAD_TIME_MS {}  // a stop before "
             "anything else\n#define LAKE_COMMAND_TIMEOUT_MS {}  // 0: none\n#define LAKE_SEGMENT_COUNT {}\n",
             kPwmPeriod, std::llround(1e3 * options.dead_time_s), std::llround(1e3 * options.command_timeout_s),
             segments) +
         PinDefines(options) + SupplyDefines(options) + CurrentDefines(options) + FeedbackDefines(options, limits);
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

void RequireSpeedLimit(const StrokeTable& stroke, const FirmwareOptions& options) {
  if (!options.speed_limit_mm_s) return;
  std::int32_t most_um_s = 0;
  for (const StrokeSegment& segment : stroke.segments) most_um_s = std::max(most_um_s, std::abs(segment.velocity_um_s));
  if (most_um_s > 1e3 * *options.speed_limit_mm_s)
    throw UsageError("the program goes at {:.3f} mm/s, and --speed-limit is {} mm/s: a slower program (--speed)",
                     most_um_s / 1e3, *options.speed_limit_mm_s);
}

constexpr std::string_view kHashLine = "#define LAKE_PROGRAM \"";

constexpr const char* kTypes =
    "\ntypedef struct {\n  uint32_t end_ms;         // since the program's start\n"
    "  int32_t velocity_um_s;   // positive extends\n  uint16_t counts;         // PWM\n} lake_segment;\n\n";

void CheckPins(const FirmwareOptions& options) {
  const Pins& pins = options.pins;
  if (pins.ena != 9 && pins.ena != 10)
    throw UsageError("--pins: ENA is {}, and only D9 and D10 have a PWM", PinName(pins.ena));
  std::vector<std::pair<std::string, int>> used = {{"the potentiometer", 14}, {"ena", pins.ena},
                                                   {"in1", pins.in1},         {"in2", pins.in2},
                                                   {"retract", pins.retract}, {"extend", pins.extend}};
  if (options.current_sense) used.emplace_back("the current sensor", 15);
  if (options.supply_v > 0) used.emplace_back("the supply sense", 16);
  if (options.bridge_sense) {
    used.emplace_back("out1", pins.out1);
    used.emplace_back("out2", pins.out2);
  }
  if (pins.safety_relay) used.emplace_back("--safety-relay", *pins.safety_relay);
  if (pins.hold_button) used.emplace_back("--hold-button", *pins.hold_button);
  for (auto one = used.begin(); one != used.end(); ++one) {
    if (one->second < 2 || one->second > 19)
      throw UsageError("{}: a pin is 2 to 19 (14 to 19 are A0 to A5; 0 and 1 are the serial line), not {}", one->first,
                       one->second);
    for (auto other = used.begin(); other != one; ++other)
      if (other->second == one->second)
        throw UsageError("{} and {} are both on {}", other->first, one->first, PinName(one->second));
  }
  if (pins.safety_relay && options.supply_v == 0)
    throw UsageError("--safety-relay is tested by the supply behind it: wire its sense as well (--supply VOLT)");
}

// mm/s; 0: never that way.
double FastestStretch(const StrokeTable& stroke, int direction) {
  std::int32_t most_um_s = 0;
  for (const StrokeSegment& segment : stroke.segments)
    most_um_s = std::max(most_um_s, direction * segment.velocity_um_s);
  return most_um_s / 1e3;
}

// mm/s, without a load. Where the supply is measured, the duty rises as it falls, up to the whole.
double LowSupplySpeed(const DutyCurve& curve, bool is_measured) {
  return curve.SpeedFor(is_measured ? std::min(curve.MostDuty(), kLowSupply) : kLowSupply * curve.MostDuty());
}

std::string WhatALowSupplyCannot(double reached_mm_s, double needed_mm_s, int direction) {
  return fmt::format(
      "At {:.0f} % of its supply it {} at {:.1f} mm/s at most, less under a load, and the program needs {:.1f}: there "
      "it {}.",
      100 * kLowSupply, direction > 0 ? "extends" : "retracts", reached_mm_s, needed_mm_s,
      reached_mm_s < kLeastPace * needed_mm_s ? "may fall behind and stop (ALARM:11)" : "takes longer");
}

}  // namespace

double FirmwareOptions::StallCurrent() const {
  return force_limit_n ? std::min(stall_current_a, idle_a + *force_limit_n / force_n_per_a) : stall_current_a;
}

std::vector<std::string> Unknowns(const FirmwareOptions& options) {
  std::vector<std::string> unknown;
  if (options.feedback == Feedback::kNone) {
    unknown.push_back("The stroke is planned, not measured: a stall, a load, a slow or a reversed motor are not seen.");
    if (options.extend_stop_mm == 0)
      unknown.push_back("Without an extend end stop nothing ends a motion the wrong way.");
  }
  if (options.supply_v == 0)
    unknown.push_back("It does not see the emergency stop: released, a program that is under way goes on by itself.");
  if (options.supply_v == 0 && options.feedback == Feedback::kNone)
    unknown.push_back("It does not see the supply's voltage: 10 % less is 10 % and more of stroke.");
  if (!options.current_sense) unknown.push_back("It does not feel a force: only the fuse limits it.");
  if (!options.bridge_sense)
    unknown.push_back("The bridge's outputs are not read back: a stop coasts, without a brake.");
  if (!options.pins.safety_relay)
    unknown.push_back("There is no second way to switch the motor off: a shorted transistor is reported, not stopped.");
  return unknown;
}

std::vector<std::string> Unknowns(const FirmwareOptions& options, const StrokeTable& stroke, const DutyTable& table) {
  std::vector<std::string> unknown = Unknowns(options);
  if (options.feedback == Feedback::kNone) return unknown;
  for (const int direction : {1, -1}) {
    const double reached_mm_s = LowSupplySpeed(table.Curve(direction), options.supply_v > 0),
                 needed_mm_s = FastestStretch(stroke, direction);
    if (reached_mm_s < needed_mm_s) unknown.push_back(WhatALowSupplyCannot(reached_mm_s, needed_mm_s, direction));
  }
  return unknown;
}

void FirmwareOptions::Check() const {
  const auto require = [](bool good, const char* option, double value, const char* what) {
    if (!good) throw UsageError("{} must be {}, not {}", option, what, value);
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
  require(StopTravel() >= 0.1 && StopTravel() <= 10, "--stop-travel", StopTravel(), "within 0.1..10 mm");
  require(lag_s >= 0 && lag_s <= 0.5, "--lag", lag_s, "within 0..0.5 s");
  require(home_error_mm >= 0 && home_error_mm <= 10, "--home-error", home_error_mm, "within 0..10 mm");
  if (supply_v != 0 && !(supply_v >= 4 && supply_v < kMostSupply_v))
    throw UsageError("--supply must be 0 or within 4..{:.1f} V, not {}", kMostSupply_v, supply_v);
  if (feedback == Feedback::kPotentiometer && !potentiometer)
    throw UsageError(
        "--feedback pot needs the potentiometer's scale, two readings with their strokes: --pot COUNTS=MM,COUNTS=MM");
  if (potentiometer)
    for (const double counts : {potentiometer->counts_a, potentiometer->counts_b})
      require(counts >= 0 && counts <= kMostCount, "--pot", counts, "of 0..1023 counts, as the converter has");
  require(feedback_error_mm >= 0 && feedback_error_mm <= 10, "--feedback-error", feedback_error_mm, "within 0..10 mm");
  require(current_zero_v >= 0 && current_zero_v <= 4, "--current-zero", current_zero_v, "within 0..4 V");
  require(current_v_per_a >= 0.01 && current_v_per_a <= 5, "--current-scale", current_v_per_a, "within 0.01..5 V/A");
  require(max_current_a > 0 && max_current_a * current_v_per_a + current_zero_v < 4.9, "--max-current", max_current_a,
          "above 0 and within what the sensor reads below 4.9 V");
  require(stall_current_a > 0 && stall_current_a <= max_current_a, "--stall-current", stall_current_a,
          "above 0 and at most --max-current");
  if (force_limit_n) {
    require(*force_limit_n > 0 && *force_limit_n <= 10'000, "--force-limit", *force_limit_n,
            "above 0 and at most 10000 N");
    require(force_n_per_a > 0, "--force-per-ampere", force_n_per_a, "above 0 N/A where there is a --force-limit");
    if (!current_sense) throw UsageError("--force-limit is held by the motor's current: give --current-sense as well");
  }
  require(idle_a >= 0 && idle_a < max_current_a, "--idle-current", idle_a, "at least 0 and less than --max-current");
  if (speed_limit_mm_s)
    require(*speed_limit_mm_s > 0 && *speed_limit_mm_s <= 1000, "--speed-limit", *speed_limit_mm_s,
            "above 0 and at most 1000 mm/s");
  CheckPins(*this);
  require(table_tolerance_mm > 0 && table_tolerance_mm <= 10, "--table-tolerance", table_tolerance_mm,
          "above 0 and at most 10 mm");
}

std::string StrokeTableHeader(const StrokeTable& stroke, const StrokeSchedule& schedule, const DutyTable& table,
                              const FirmwareOptions& options, const std::string& made_by) {
  const Homing homing = HomingOf(stroke, schedule, table, options);
  if (options.feedback == Feedback::kPotentiometer) RequirePotentiometer(options, schedule, homing.stroke_mm);
  RequireSpeedLimit(stroke, options);
  if (!options.accept_drift) RequireRoomForDrift(homing, stroke, schedule, table, options);
  std::string text = options.accept_drift ? kDriftAccepted : "";
  text += fmt::format("// Stroke program for the UNO. {}\n", Comment(made_by));
  for (const std::string& unknown : Unknowns(options, stroke, table)) text += "// CANNOT KNOW: " + unknown + "\n";
  text += "#ifndef LAKE_STROKE_TABLE_H\n#define LAKE_STROKE_TABLE_H\n\n#include \"portable.h\"\n\n";
  text += CommonDefines(options, stroke.segments.size(), &schedule.limits);
  text += DriftDefines(DriftBound(stroke, table, options), options);
  text += fmt::format("#define LAKE_SPEED_INTERVALS {}\n", kSpeedIntervals);
  text += fmt::format("#define LAKE_LOWER_LIMIT_UM {}L\n#define LAKE_UPPER_LIMIT_UM {}L\n#define LAKE_START_UM {}L\n",
                      Um(std::min(schedule.limits.lower_mm, stroke.start_mm)), Um(schedule.limits.upper_mm),
                      Um(stroke.start_mm));
  text += fmt::format("#define LAKE_UPPER_END_UM {}L  // of the linkage: what the drift must not reach\n",
                      Um(schedule.limits.upper_end_mm));
  text += fmt::format(
      "#define LAKE_STOP_TRAVEL_UM {}L  // within which an end stop releases\n#define LAKE_CHECK_UM {}L  // … while it "
      "is "
      "not known which way the motor turns\n",
      Um(options.StopTravel()), Um(homing.check_mm));
  text += fmt::format(
      "#define LAKE_EXTEND_CREEP_COUNTS {}  // then\n#define LAKE_EXTEND_CREEP_UM_S {}L\n#define "
      "LAKE_RETRACT_CREEP_COUNTS {}\n#define LAKE_RETRACT_CREEP_UM_S {}L\n",
      CountsFor(table, homing.extend_creep_mm_s), Um(homing.extend_creep_mm_s),
      CountsFor(table, -homing.retract_creep_mm_s), Um(homing.retract_creep_mm_s));
  text +=
      fmt::format("#define LAKE_SPEED_LIMIT_UM_S {}L\n",
                  Um(options.speed_limit_mm_s.value_or(std::max(table.extend.MostSpeed(), table.retract.MostSpeed()))));
  text += fmt::format("#define LAKE_HOME_GUARD_UM {}L  // where homing has passed its end stop\n", Um(homing.guard_mm));
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
  const std::string hash_line = fmt::format("{}{}\"\n", kHashLine, ProgramHash(text));
  return text.insert(text.find("#define LAKE_DESIGN "), hash_line);
}

std::string ProgramHash(const std::string& stroke_table_header) {
  std::string text = stroke_table_header;
  if (const std::size_t from = text.find(kHashLine); from != std::string::npos)
    text.erase(from, text.find('\n', from) + 1 - from);
  return Sha256OfText(text).substr(0, 12);
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
  text += fmt::format("// WARNING: {}\n", kUntried);
  if (!IsMeasured(table))
    text += "// WARNING: MODEL duty table. This actuator's speeds were not measured: lake-stroke calibrate.\n";
  text += fmt::format("// WARNING: UNWORN ONLY: home takes the knee to {:.1f} degrees.\n",
                      KneeDegAt(schedule.links, home_mm));
  if (options.feedback == Feedback::kNone) text += "// WARNING: open loop.\n";
  for (const std::string& unknown : Unknowns(options, stroke, table)) text += "// CANNOT KNOW: " + unknown + "\n";
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
