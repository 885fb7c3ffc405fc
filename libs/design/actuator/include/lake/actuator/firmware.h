// The schedule as the firmware has it: whole ms, um/s and PWM counts, in a header that is compiled with the firmware's
// sources; and what a laboratory needs beside such a sketch before anything moves.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lake/actuator/duty_calibration.h"

namespace lake::actuator {

inline constexpr int kPwmPeriod = 4000;     // counts of timer 1 at 16 MHz: 4 kHz
inline constexpr int kSpeedIntervals = 64;  // of the firmware's own duty-to-speed table
inline constexpr int kSegmentBytes = 10;    // of a segment in flash
inline constexpr int kFlashBytes = 32256;   // of the ATmega328P beside the UNO's bootloader
// Kept for the code, with everything wired.
inline constexpr int kFirmwareBytes = 19456;
inline constexpr double kUnmeasuredTolerance_percent = 10;  // of speeds, where nobody has measured it
inline constexpr int kMostSegments = (kFlashBytes - kFirmwareBytes) / kSegmentBytes;

inline constexpr double kReference_v = 5;        // of the converter; the potentiometer is between that and GND
inline constexpr double kSupplyDivider = 4.9;    // of the supply before A2, by 39 kOhm to it and 10 kOhm to GND
inline constexpr double kSupplyTolerance = 0.4;  // of the nominal voltage: outside is a fault
inline constexpr double kLowSupply = 0.7;        // part of the nominal voltage, at which a closed loop is to follow
inline constexpr double kLeastPace = 2.0 / 3;    // of the program's speed: a slower motor is not waited for (program.c)
inline constexpr double kOpenLoopSupplyTolerance = 0.1;  // likewise where nothing but the voltage sets the speed
inline constexpr double kDirectionCheck_mm =
    0.3;                                     // off a pressed end stop while it is not known which way the motor turns
inline constexpr double kStopTravel_mm = 2;  // the default
inline constexpr double kFollowingError_mm = 1;  // at most, in closed loop; at 3 mm the firmware stops

enum class Feedback { kNone, kPotentiometer };

// The UNO's file on top of which stands what belongs to a sketch alone.
inline constexpr const char* kNotesFile = "lake_stroke.ino";

// Which of the board's pins is wired to what; A0 to A5 are 14 to 19. ENA has the PWM: D9 or D10.
struct Pins {
  int ena = 9, in1 = 7, in2 = 8;
  int retract = 2, extend = 3;      // end stops
  int out1 = 17, out2 = 18;         // the bridge's outputs, with bridge_sense
  std::optional<int> safety_relay;  // none: not wired
  std::optional<int> hold_button;   // to ground while it is held; none: not wired
};

struct FirmwareOptions {
  double home_stroke_mm = 0;                      // at which the retract end stop acts; 0: the lower soft limit
  double home_speed_mm_s = 5;                     // while homing, at most; less if the duty table has less
  double dead_time_s = 0.1;                       // of the brake; the schedule's
  double command_timeout_s = 2;                   // motion stops when the host is silent for so long; 0: never
  std::optional<double> speed_tolerance_percent;  // by which speeds may differ from the duty table, for the bound on
                                                  // the drift; none: the table's own, else kUnmeasuredTolerance_percent
  double lag_s = 0.05;                            // by which speed lags behind duty at most, for the bound …
  double home_error_mm = 0.1;                     // … and how well the stroke is known after homing
  std::optional<double> stop_travel_mm;  // within which an end stop releases when the actuator moves away from it;
                                         // none: kStopTravel_mm
  double extend_stop_mm = 0;             // the extend end stop acts so far before the linkage's end; 0: there is none
  bool accept_drift = false;             // for a bench without a person: the drift may leave the linkage's room
  Feedback feedback = Feedback::kNone;   // of the stroke; none: open loop
  std::optional<PotentiometerScale> potentiometer;  // two readings on A0 with their strokes; feedback needs it
  double feedback_error_mm = 0.5;  // by which that stroke may be off: calibration, linearity, resolution
  double supply_v = 0;             // of the motor, seen on A2 through the divider; 0: not wired
  bool current_sense = false;      // A1 measures the motor's current: an ACS712-05B, or …
  double current_zero_v = 2.5, current_v_per_a = 0.185;  // … what reads so without current, and so much per ampere
  double max_current_a = 3;                              // more is a short: off within 10 ms, …
  double stall_current_a = 2;                            // … more than this for 0.3 s a stall
  std::optional<double> force_limit_n;  // of the actuator on the leg: a stall current by the two numbers below, if less
  double force_n_per_a = 0, idle_a = 0;    // the actuator's force per ampere above what it takes without a load
  std::optional<double> speed_limit_mm_s;  // no motion of the closed loop is faster, and no program may be
  Pins pins;
  bool bridge_sense = false;  // the bridge's outputs are read back on A3 and A4: else it is never braked
  std::string design_hash =
      "unknown";                     // the first digits of the design file's SHA-256: no option, said in the greeting
  double table_tolerance_mm = 0.05;  // allowed when a program has too many knots for the flash

  double StopTravel() const { return stop_travel_mm.value_or(kStopTravel_mm); }
  double StallCurrent() const;  // A, by the force limit if that is less
  bool HasFeedback() const { return feedback != Feedback::kNone; }

  void Check() const;  // throws UsageError where options contradict each other
};

// All but the dead time, which is the schedule's.
void Describe(FirmwareOptions& o, OptionList& options);

// One stretch of constant speed.
struct StrokeSegment {
  std::int64_t end_ms = 0;
  std::int32_t velocity_um_s = 0;
  int counts = 0;  // of kPwmPeriod
};

struct StrokeTable {
  std::vector<StrokeSegment> segments;
  double start_mm = 0;
  double rounding_error_mm = 0;  // worst distance of its plan from the schedule, at any time
  double pwm_error_mm = 0;       // the same if the actuator follows the duty table exactly at these counts
};

// Throws Error if it does not fit into the flash within the tolerance, or a number into the firmware's types.
StrokeTable MakeStrokeTable(const StrokeSchedule& schedule, const DutyTable& table, const FirmwareOptions& options);

// All that the firmware of one program is made of.
struct Sketch {
  Sketch(StrokeSchedule program, DutyTable duties, FirmwareOptions how)  // throws as MakeStrokeTable
      : schedule(std::move(program)),
        table(std::move(duties)),
        options(std::move(how)),
        stroke(MakeStrokeTable(schedule, table, options)) {}

  StrokeSchedule schedule;
  DutyTable table;
  FirmwareOptions options;
  StrokeTable stroke;

  double HomeStroke() const;                 // of the retract end stop
  std::optional<double> ExtendStop() const;  // the stroke at which it acts; none without options.extend_stop_mm
  double TolerancePercent() const;           // by which speeds may differ from the table
};

// What a firmware cannot know or do, a sentence each: said on the sketch, by lake-stroke, and before a run. Also where
// a closed loop cannot follow its program at kLowSupply.
std::vector<std::string> Unknowns(const Sketch& sketch);

// What the firmware's bound on the drift comes to, from homing to the program's end, where planned stroke and bound
// together come nearest to the linkage's upper end. At its lower end the retract end stop comes first.
struct DriftForecast {
  double tolerance_percent = 0;  // of the speeds
  bool is_measured = false;      // by the duty table; else given, or kUnmeasuredTolerance_percent
  double end_mm = 0;             // of the linkage
  double time_s = 0;             // of the program, where it comes nearest
  double planned_mm = 0, drift_mm = 0;
  double last_drift_mm = 0;      // at the program's end
  double tolerable_percent = 0;  // the largest tolerance that leaves room, 0.1 % steps; negative: none does

  double Room() const { return end_mm - planned_mm; }
  bool Fits() const { return drift_mm < Room(); }
};
DriftForecast ForecastDrift(const Sketch& sketch);

// The text of stroke_table.h; `made_by` goes into its comment. Unless options.accept_drift, throws Error with the
// numbers and the ways out if the drift may leave the linkage's room and no extend end stop comes first, if an end stop
// acts too near to the linkage's end, or UsageError if home lies below the soft limit.
std::string StrokeTableHeader(const Sketch& sketch, const std::string& made_by);

// The first digits of the SHA-256 of a stroke_table.h but for the line that has them: of the whole table, of every
// option that went into it and of what it was made from. The firmware greets with them.
std::string ProgramHash(const std::string& stroke_table_header);

// What belongs to this sketch and to no other, for the top of the .ino: where it comes from, warnings, end stops,
// sizes, as comment lines. `from` names design and duty table.
std::string SketchNotes(const Sketch& sketch, const std::string& from);

// The header of a firmware without a program: it jogs, for the logs that a duty table is made of.
std::string CalibrationHeader(const FirmwareOptions& options, const std::string& made_by);

// The wiring drawn with this firmware's pins, as SVG: board, bridge, actuator, end stops and whatever of sensors and
// relay is wired, with fuse, emergency stop and pull-down resistors.
std::string SchematicSvg(const FirmwareOptions& options);

// As Markdown: what is checked in which order before the first motion, what must be seen, and room for name, date and
// the value that was found.
std::string SignOffSheet(const Sketch& sketch);

// The firmware's sources, as in libs/design/actuator/firmware; with stroke_table.h they are all that its compiler
// needs: a sketch for the Arduino IDE, whose folder must have the name of its .ino.
inline constexpr const char* kSketchFolder = "lake_stroke";
struct FirmwareFile {
  std::string name, text;
};
const std::vector<FirmwareFile>& FirmwareSources();

// Those of them that a sketch has: of plant_pot.c and plant_open.c that of its feedback.
std::vector<FirmwareFile> SketchSources(Feedback feedback);

// Said wherever a person reads about safety.
inline constexpr const char* kUntried =
    "This firmware has not been tried on a board, only in a simulator: nobody may wear what it drives.";

// What the sketch of a program whose drift was accepted says on its first line.
inline constexpr const char* kDriftAccepted =
    "// DRIFT ACCEPTED: this program may run past the linkage's end. Only for a bench without a person.\n";

}  // namespace lake::actuator
