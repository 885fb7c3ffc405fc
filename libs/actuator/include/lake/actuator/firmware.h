// The schedule as the UNO has it: whole ms, um/s and PWM counts, in a header that is compiled with the firmware's
// sources.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "lake/actuator/duty_table.h"
#include "lake/actuator/stroke_schedule.h"

namespace lake {

inline constexpr int kPwmPeriod = 4000;      // counts of timer 1 at 16 MHz: 4 kHz
inline constexpr int kSpeedIntervals = 16;   // of the firmware's own duty-to-speed table
inline constexpr int kSegmentBytes = 10;     // of a segment in flash
inline constexpr int kFlashBytes = 32256;    // of the ATmega328P beside the UNO's bootloader
inline constexpr int kFirmwareBytes = 8192;  // kept for the code, which takes less
inline constexpr int kMostSegments = (kFlashBytes - kFirmwareBytes) / kSegmentBytes;

struct FirmwareOptions {
  double home_stroke_mm = 0;            // at which the retract end stop acts; 0: the design's d_min
  double home_speed_mm_s = 5;           // while homing, at most; less if the duty table has less
  double dead_time_s = 0.1;             // of the brake; the schedule's
  double command_timeout_s = 2;         // motion stops when the host is silent for so long; 0: never
  double speed_tolerance_percent = 10;  // by which speeds may differ from the duty table: for the bound on the drift, …
  double lag_s = 0.05;                  // … as are the time by which speed lags behind duty …
  double home_error_mm = 0.1;           // … and how well the stroke is known after homing
  double table_tolerance_mm = 0.05;     // allowed when a program has too many knots for the flash

  void Check() const;  // throws UsageError
};

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

// The text of stroke_table.h; `made_by` goes into its comment.
std::string StrokeTableHeader(const StrokeTable& stroke, const StrokeSchedule& schedule, const DutyTable& table,
                              double d_min_mm, const FirmwareOptions& options, const std::string& made_by);

// The header of a firmware without a program: it jogs, for the logs that a duty table is made of.
std::string CalibrationHeader(const FirmwareOptions& options, const std::string& made_by);

// The firmware's sources, as in libs/actuator/firmware; with stroke_table.h they are a sketch for the Arduino IDE,
// whose folder must have the name of its .ino.
inline constexpr const char* kSketchFolder = "lake_stroke";
struct FirmwareFile {
  std::string name, text;
};
const std::vector<FirmwareFile>& FirmwareSources();

}  // namespace lake
