#include "lake/actuator/firmware.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "homing.h"
#include "lake/core/error.h"
#include "lake/core/provenance.h"
#include "lake/core/uncertain_text.h"

namespace lake::actuator {
namespace {

// A constant of the firmware, LAKE_…, as its text, and what it is where the name does not say it.
struct Define {
  std::string name, value, note;

  Define(std::string constant, std::string text, std::string what = "")
      : name(std::move(constant)), value(std::move(text)), note(std::move(what)) {}
  Define(std::string constant, std::int64_t number, std::string what = "")
      : Define(std::move(constant), std::to_string(number), std::move(what)) {}
};
using Defines = std::vector<Define>;

// A constant of 32 bits.
std::string Long(std::int64_t number) {
  return std::to_string(number) + "L";
}

std::string LongUm(double mm) {
  return Long(Um(mm));
}

// Quoted.
std::string Said(const std::string& text) {
  return '"' + text + '"';
}

std::string TextOf(const Defines& defines) {
  std::string text;
  for (const Define& one : defines)
    text += fmt::format("#define LAKE_{} {}{}{}\n", one.name, one.value, one.note.empty() ? "" : "  // ", one.note);
  return text;
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

Defines SupplyDefines(const FirmwareOptions& options) {
  constexpr double kAny_v = 12;  // where it is not wired
  const double nominal_v = options.supply_v > 0 ? options.supply_v : kAny_v;
  const auto reading = [&](double part) { return ReadingOf(part * nominal_v / kSupplyDivider); };
  return {{"SUPPLY_SENSE", options.supply_v > 0},
          {"SUPPLY_LEAST", reading(1 - kSupplyTolerance)},
          {"SUPPLY_MOST", reading(1 + kSupplyTolerance)},
          {"SUPPLY_NOMINAL", reading(1)},
          {"SUPPLY_NEAR_LEAST", reading(1 - kOpenLoopSupplyTolerance), "in open loop"},
          {"SUPPLY_NEAR_MOST", reading(1 + kOpenLoopSupplyTolerance)}};
}

Defines PinDefines(const FirmwareOptions& options) {
  Defines defines;
  for (const Connection& one : ConnectionsOf(options))
    if (*one.define) defines.emplace_back(fmt::format("PIN_{}", one.define), one.pin);
  defines.emplace_back("BRIDGE_SENSE", options.bridge_sense);
  defines.emplace_back("RELAY", options.pins.safety_relay.has_value());
  defines.emplace_back("BUTTON", options.pins.hold_button.has_value());
  return defines;
}

Defines CurrentDefines(const FirmwareOptions& options) {
  constexpr int kLeast_ma = 100;  // of any motor that is being started
  return {{"CURRENT_SENSE", options.current_sense},
          {"CURRENT_ZERO", ReadingOf(options.current_zero_v)},
          {"CURRENT_UA_PER_COUNT", Long(std::lround(1e6 * kReference_v / kMostReading / options.current_v_per_a))},
          {"CURRENT_MOST_MA", std::lround(1e3 * options.max_current_a)},
          {"CURRENT_STALL_MA", std::lround(1e3 * options.StallCurrent())},
          {"CURRENT_LEAST_MA", kLeast_ma}};
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
void RequirePotentiometer(const Sketch& sketch) {
  const FirmwareOptions& options = sketch.options;
  const PotentiometerScale& scale = *options.potentiometer;
  const PotentiometerLine line(scale);
  const std::string pot = fmt::format("--pot {}={},{}={}", scale.counts_a, scale.mm_a, scale.counts_b, scale.mm_b);
  const auto [lowest, highest] =
      std::ranges::minmax(sketch.schedule.knots, {}, &linkage::StrokeProgram::Knot::stroke_mm);
  for (const double stroke_mm : {std::min(lowest.stroke_mm, sketch.HomeStroke()), highest.stroke_mm}) {
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
Defines FeedbackDefines(const FirmwareOptions& options, const SoftLimits& limits) {
  constexpr double kBeyond_mm = 5;
  constexpr PotentiometerScale kAny{
      .counts_a = 0, .mm_a = 0, .counts_b = kMostCount, .mm_b = 100};  // where none is wired
  const PotentiometerLine line(options.HasFeedback() ? *options.potentiometer : kAny);
  const double a = line.ReadingAt(limits.lower_end_mm - kBeyond_mm),
               b = line.ReadingAt(limits.upper_end_mm + kBeyond_mm);
  const auto reading = [&](double value) { return std::lround(std::clamp(value, kRail, kMostReading - kRail)); };
  return {{"FEEDBACK", options.HasFeedback()},
          {"POT_ZERO_NM", Long(std::llround(1e6 * line.zero_mm)), "the stroke of a reading of 0, …"},
          {"POT_NM_PER_COUNT", Long(std::llround(1e6 * line.mm_per_reading)), "… of sums of four"},
          {"POT_LEAST", reading(std::min(a, b))},
          {"POT_MOST", reading(std::max(a, b))},
          {"POT_ERROR_UM", LongUm(options.feedback_error_mm)}};
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

// What the duty table has of one direction. None is a firmware's without a table: it jogs at any duty, and knows no
// speed.
struct TableSide {
  const char* name;
  double least_mm_s = 0, most_mm_s = 0, creep_mm_s = 0;
  int creep_counts = kPwmPeriod, most_counts = kPwmPeriod;
  int first_node = 0;  // that lies within the measured duties
  std::vector<std::int64_t> greatest_um_s = std::vector<std::int64_t>(kSpeedIntervals + 1);  // at each node

  explicit TableSide(const char* direction) : name(direction) {}
  TableSide(const char* direction, const DutyTable& table, double creep_speed_mm_s, int sign) : name(direction) {
    const DutyCurve& curve = table.Curve(sign);
    least_mm_s = curve.LeastMovingSpeed();
    most_mm_s = curve.MostSpeed();
    creep_mm_s = creep_speed_mm_s;
    creep_counts = CountsFor(table, sign * creep_speed_mm_s);
    most_counts = static_cast<int>(std::lround(curve.MostDuty() * kPwmPeriod));
    first_node = static_cast<int>(std::ceil(curve.DeadBandDuty() * kSpeedIntervals - 1e-9));
    // Below the first row, if that moves, it may be the row's, and no speed without duty.
    for (int i = 1; i <= kSpeedIntervals; ++i)
      greatest_um_s[static_cast<std::size_t>(i)] =
          Um(std::max(curve.LeastSpeed(), curve.SpeedFor(i / double{kSpeedIntervals})));
  }

  Defines AsDefines() const {
    const std::string start = name + std::string("_");
    return {{start + "CREEP_COUNTS", creep_counts, "while it is not known which way the motor turns"},
            {start + "CREEP_UM_S", LongUm(creep_mm_s)},
            {start + "LEAST_UM_S", LongUm(least_mm_s), "that the duty table has"},
            {start + "MOST_UM_S", LongUm(most_mm_s)},
            {start + "FIRST_NODE", first_node, "of lake_speed_um_s: below it a duty may also stand still"},
            {start + "MOST_COUNTS", fmt::format("{}u", most_counts), "the duty table ends there"}};
  }
};

// What a program adds to the options; by default there is none, and no limit.
struct Program {
  std::vector<StrokeSegment> segments = {{}};
  double start_mm = 0, extend_stop_mm = 0, home_knee_deg = 0;
  SoftLimits limits;
  Homing homing{.speed_mm_s = 1};  // by which the firmware divides
  DriftBound bound;
  TableSide extend{"EXTEND"}, retract{"RETRACT"};
  std::string duty_table;
};

Defines ProgramDefines(const FirmwareOptions& options, const Program& program) {
  const Homing& homing = program.homing;
  const double most_mm_s = std::max(program.extend.most_mm_s, program.retract.most_mm_s);
  return {
      {"DRIFT_START_UM", program.bound.StartUm(), "the bound on the drift: at first, …"},
      {"DRIFT_PER_1024", program.bound.Per1024(), "… per 1024 of the way, …"},
      {"LAG_MS", program.bound.LagMs(), "… and per change of speed"},
      {"DRIFT_ACCEPTED", options.accept_drift},
      {"DRIFT_LIMITED", !options.accept_drift && options.extend_stop_mm == 0,
       "0: accepted, or an extend end stop comes first"},
      {"SPEED_INTERVALS", kSpeedIntervals},
      {"LOWER_LIMIT_UM", LongUm(std::min(program.limits.lower_mm, program.start_mm))},
      {"UPPER_LIMIT_UM", LongUm(program.limits.upper_mm)},
      {"START_UM", LongUm(program.start_mm)},
      {"UPPER_END_UM", LongUm(program.limits.upper_end_mm), "of the linkage: what the drift must not reach"},
      {"STOP_TRAVEL_UM", LongUm(options.StopTravel()), "within which an end stop releases"},
      {"CHECK_UM", LongUm(homing.check_mm), "… while it is not known which way the motor turns"},
      {"SPEED_LIMIT_UM_S", LongUm(options.speed_limit_mm_s.value_or(most_mm_s))},
      {"HOME_GUARD_UM", LongUm(homing.guard_mm), "where homing has passed its end stop"},
      {"EXTEND_STOP_UM", LongUm(program.extend_stop_mm), "0: there is none"},
      {"HOME_KNEE", Said(fmt::format("{:.1f}", program.home_knee_deg)), "degrees"},
      {"PROGRAM", Said("")},
      {"DESIGN", Said(options.design_hash)},
      {"DUTY_TABLE", Said(program.duty_table)},
      {"HOME_UM", LongUm(homing.stroke_mm), "at the retract end stop"},
      {"HOME_COUNTS", homing.counts},
      {"HOME_SPEED_UM_S", LongUm(homing.speed_mm_s)},
      {"HOME_TIMEOUT_MS", Long(homing.timeout_ms)},
      {"POSITION_COUNTS", homing.position_counts, "away from the end stop"},
      {"POSITION_SPEED_UM_S", LongUm(homing.position_speed_mm_s)},
      {"POSITION_MS", Long(homing.position_ms), "from where it has released on to the start, …"},
      {"RETURN_MS", Long(homing.return_ms), "… or back to it"},
      {"BACK_OFF_MS", Long(homing.back_off_ms), "from the end stop, to see it release"},
      {"TOUCH_TIMEOUT_MS", Long(homing.touch_timeout_ms)},
  };
}

constexpr const char* kTypes =
    "\ntypedef struct {\n  uint32_t end_ms;         // since the program's start\n"
    "  int32_t velocity_um_s;   // positive extends\n  uint16_t counts;         // PWM\n} lake_segment;\n\n";

// From the include guard on.
std::string TableText(const FirmwareOptions& options, const Program& program, bool has_program) {
  std::string text = "#ifndef LAKE_STROKE_TABLE_H\n#define LAKE_STROKE_TABLE_H\n\n#include \"portable.h\"\n\n";
  text += TextOf({{"PWM_PERIOD", kPwmPeriod, "counts: 4 kHz at 16 MHz"},
                  {"DEAD_TIME_MS", std::llround(1e3 * options.dead_time_s), "a stop before anything else"},
                  {"COMMAND_TIMEOUT_MS", std::llround(1e3 * options.command_timeout_s), "0: none"},
                  {"HAS_PROGRAM", has_program, "0: it only jogs, for calibration"},
                  {"SEGMENT_COUNT", static_cast<std::int64_t>(program.segments.size())}});
  for (const Defines& defines :
       {PinDefines(options), SupplyDefines(options), CurrentDefines(options), FeedbackDefines(options, program.limits),
        ProgramDefines(options, program), program.extend.AsDefines(), program.retract.AsDefines()})
    text += TextOf(defines);
  text += kTypes;
  text += "static const lake_segment lake_segments[LAKE_SEGMENT_COUNT] PROGMEM = {\n";
  for (const StrokeSegment& segment : program.segments)
    text += fmt::format("    {{{}, {}, {}}},\n", segment.end_ms, segment.velocity_um_s, segment.counts);
  text += "};\n\n// The greatest speed, um/s, at equal steps of duty from 0 to 1: extending, retracting.\n";
  return text + fmt::format(
                    "static const uint32_t lake_speed_um_s[2][LAKE_SPEED_INTERVALS + 1] PROGMEM = {{\n    {{{}}},\n    "
                    "{{{}}}}};\n\n#endif\n",
                    fmt::join(program.extend.greatest_um_s, ", "), fmt::join(program.retract.greatest_um_s, ", "));
}

// mm/s; 0: never that way.
double FastestStretch(const StrokeTable& stroke, int direction) {
  std::int32_t most_um_s = 0;
  for (const StrokeSegment& segment : stroke.segments)
    most_um_s = std::max(most_um_s, direction * segment.velocity_um_s);
  return most_um_s / 1e3;
}

void RequireSpeedLimit(const Sketch& sketch) {
  const double most_mm_s = std::max(FastestStretch(sketch.stroke, 1), FastestStretch(sketch.stroke, -1));
  if (sketch.options.speed_limit_mm_s && most_mm_s > *sketch.options.speed_limit_mm_s)
    throw UsageError("the program goes at {:.3f} mm/s, and --speed-limit is {} mm/s: a slower program (--speed)",
                     most_mm_s, *sketch.options.speed_limit_mm_s);
}

constexpr std::string_view kHashLine = "#define LAKE_PROGRAM \"";

void CheckPins(const FirmwareOptions& options) {
  if (const int ena = options.pins.ena; ena != 9 && ena != 10)
    throw UsageError("--pins: ENA is {}, and only D9 and D10 have a PWM", PinName(ena));
  std::map<int, const char*> used;
  for (const Connection& one : ConnectionsOf(options)) {
    if (!one.is_wired) continue;
    if (one.pin < 2 || one.pin > 19)
      throw UsageError("{}: a pin is 2 to 19 (14 to 19 are A0 to A5; 0 and 1 are the serial line), not {}", one.name,
                       one.pin);
    if (const auto [other, is_new] = used.emplace(one.pin, one.name); !is_new)
      throw UsageError("{} and {} are both on {}", other->second, one.name, PinName(one.pin));
  }
  if (options.pins.safety_relay && options.supply_v == 0)
    throw UsageError("--safety-relay is tested by the supply behind it: wire its sense as well (--supply VOLT)");
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

std::vector<std::string> Unknowns(const Sketch& sketch) {
  const FirmwareOptions& options = sketch.options;
  std::vector<std::string> unknown;
  const auto add = [&unknown](bool is_so, std::string text) {
    if (is_so) unknown.push_back(std::move(text));
  };
  const bool open_loop = !options.HasFeedback();
  add(open_loop, "The stroke is planned, not measured: a stall, a load, a slow or a reversed motor are not seen.");
  add(open_loop && options.extend_stop_mm == 0, "Without an extend end stop nothing ends a motion the wrong way.");
  add(options.supply_v == 0,
      "It does not see the emergency stop: released, a program that is under way goes on by itself.");
  add(open_loop && options.supply_v == 0,
      "It does not see the supply's voltage: 10 % less is 10 % and more of stroke.");
  add(!options.current_sense, "It does not feel a force: only the fuse limits it.");
  add(!options.bridge_sense, "The bridge's outputs are not read back: a stop coasts, without a brake.");
  add(!options.pins.safety_relay,
      "There is no second way to switch the motor off: a shorted transistor is reported, not stopped.");
  for (const int direction : {1, -1}) {
    const double reached_mm_s = LowSupplySpeed(sketch.table.Curve(direction), options.supply_v > 0),
                 needed_mm_s = FastestStretch(sketch.stroke, direction);
    add(!open_loop && reached_mm_s < needed_mm_s, WhatALowSupplyCannot(reached_mm_s, needed_mm_s, direction));
  }
  return unknown;
}

void FirmwareOptions::Check() const {
  const auto require = [](bool good, const char* option, double value, const char* what) {
    if (!good) throw UsageError("{} must be {}, not {}", option, what, value);
  };
  require(command_timeout_s == 0 || command_timeout_s >= 0.1, "--command-timeout", command_timeout_s,
          "0 or within 0.1..60 s");
  if (supply_v != 0 && !(supply_v >= 4 && supply_v < kMostSupply_v))
    throw UsageError("--supply must be 0 or within 4..{:.1f} V, not {}", kMostSupply_v, supply_v);
  if (HasFeedback() && !potentiometer)
    throw UsageError(
        "--feedback pot needs the potentiometer's scale, two readings with their strokes: --pot COUNTS=MM,COUNTS=MM");
  if (potentiometer)
    for (const double counts : {potentiometer->counts_a, potentiometer->counts_b})
      require(counts >= 0 && counts <= kMostCount, "--pot", counts, "of 0..1023 counts, as the converter has");
  require(max_current_a * current_v_per_a + current_zero_v < 4.9, "--max-current", max_current_a,
          "within what the sensor reads below 4.9 V");
  require(stall_current_a <= max_current_a, "--stall-current", stall_current_a, "at most --max-current");
  require(idle_a < max_current_a, "--idle-current", idle_a, "less than --max-current");
  if (force_limit_n) {
    require(force_n_per_a > 0, "--force-per-ampere", force_n_per_a, "above 0 N/A where there is a --force-limit");
    if (!current_sense) throw UsageError("--force-limit is held by the motor's current: give --current-sense as well");
  }
  CheckPins(*this);
}

std::vector<FirmwareFile> SketchSources(Feedback feedback) {
  const char* const other = feedback == Feedback::kNone ? "plant_pot.c" : "plant_open.c";
  std::vector<FirmwareFile> files = FirmwareSources();
  std::erase_if(files, [&](const FirmwareFile& file) { return file.name == other; });
  return files;
}

std::string StrokeTableHeader(const Sketch& sketch, const std::string& made_by) {
  const FirmwareOptions& options = sketch.options;
  const Homing homing = HomingOf(sketch);
  if (options.HasFeedback()) RequirePotentiometer(sketch);
  RequireSpeedLimit(sketch);
  if (!options.accept_drift) RequireRoomForDrift(sketch, homing);
  std::string text = options.accept_drift ? kDriftAccepted : "";
  text += fmt::format("// Stroke program for the UNO. {}\n", Comment(made_by));
  for (const std::string& unknown : Unknowns(sketch)) text += "// CANNOT KNOW: " + unknown + "\n";
  text += TableText(options,
                    {.segments = sketch.stroke.segments,
                     .start_mm = sketch.stroke.start_mm,
                     .extend_stop_mm = sketch.ExtendStop().value_or(0),
                     .home_knee_deg = KneeDegAt(sketch.schedule.links, homing.stroke_mm),
                     .limits = sketch.schedule.limits,
                     .homing = homing,
                     .bound = DriftBound(sketch),
                     .extend = {"EXTEND", sketch.table, homing.extend_creep_mm_s, 1},
                     .retract = {"RETRACT", sketch.table, homing.retract_creep_mm_s, -1},
                     .duty_table = DutyTableName(sketch.table)},
                    true);
  return text.insert(text.find(kHashLine) + kHashLine.size(), ProgramHash(text));
}

std::string ProgramHash(const std::string& stroke_table_header) {
  std::string text = stroke_table_header;
  if (const std::size_t from = text.find(kHashLine); from != std::string::npos)
    text.erase(from, text.find('\n', from) + 1 - from);
  return Sha256OfText(text).substr(0, 12);
}

std::string SketchNotes(const Sketch& sketch, const std::string& from) {
  const auto& [schedule, table, options, stroke] = sketch;
  const auto place = [&sketch](double stroke_mm) {
    return fmt::format("{:.3f} mm (knee {:.1f} degrees)", stroke_mm, KneeDegAt(sketch.schedule.links, stroke_mm));
  };
  std::string text = options.accept_drift ? kDriftAccepted : "";
  text += fmt::format("// {}\n// Design {} (SHA-256), duty table: {}.\n//\n", Comment(from), options.design_hash,
                      DutyTableName(table));
  text += fmt::format("// WARNING: {}\n", kUntried);
  if (!IsMeasured(table))
    text += "// WARNING: MODEL duty table. This actuator's speeds were not measured: lake-stroke calibrate.\n";
  text += fmt::format("// WARNING: UNWORN ONLY: home takes the knee to {:.1f} degrees.\n",
                      KneeDegAt(schedule.links, sketch.HomeStroke()));
  if (!options.HasFeedback()) text += "// WARNING: open loop.\n";
  for (const std::string& unknown : Unknowns(sketch)) text += "// CANNOT KNOW: " + unknown + "\n";
  text += fmt::format("// Program: from {} to {} in {:.1f} s, {} segments.\n", place(stroke.start_mm),
                      place(schedule.knots.back().stroke_mm), schedule.Duration(), stroke.segments.size());
  text += fmt::format("// Retract end stop at {}; extend end stop {}. The linkage ends at {:.3f} and {:.3f} mm.\n",
                      place(sketch.HomeStroke()),
                      options.extend_stop_mm > 0 ? "at " + place(*sketch.ExtendStop())
                                                 : "before the linkage's end, as near as it can be put",
                      schedule.limits.lower_end_mm, schedule.limits.upper_end_mm);
  text += "// Pins, commands, error codes: README.txt in this folder.\n\n";
  return text;
}

std::string CalibrationHeader(const FirmwareOptions& options, const std::string& made_by) {
  return fmt::format("// No program: a firmware that jogs, for the logs of lake-stroke calibrate. {}\n{}",
                     Comment(made_by), TableText(options, {}, false));
}

}  // namespace lake::actuator
