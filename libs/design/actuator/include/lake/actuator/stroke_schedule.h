// From a design's program to what the actuator shall do when: strokes within soft limits, a pause before each reversal.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/actuator/duty_table.h"
#include "lake/core/options.h"
#include "lake/linkage/design_file.h"

namespace lake::actuator {

inline constexpr double kLeastDeadTime_s = 0.1;

// Of an actuator with a screw: the play between its nut and its bearings is some 0.2 mm, so a smaller reversal does not
// arrive at the rod.
inline constexpr double kStrokeResolution_mm = 0.15;

struct ScheduleOptions {
  double margin_mm = 0.5;            // kept from standing (theta = 0) and from the ends of the assembled branch
  std::optional<double> speed_mm_s;  // constant speed instead of the design's program
  std::optional<double> from_deg;    // constant program: knee angle at its start (none: the soft limit at d_min) …
  std::optional<double> to_deg;      // … and at its end (none: the soft limit at standing)
  std::optional<double> max_speed_mm_s;          // of the actuator
  std::optional<double> max_acceleration_mm_s2;  // likewise; none: speeds change at once
  bool return_trip = false;                      // afterwards back to the start, the same way
  double smooth_mm = 0;                          // reversals of at most twice that become rests half way between
  double hold_s = 2;                             // rest before the return trip
  double dead_time_s = 0.1;                      // brake before a reversal: at least so long a rest
};

void Describe(ScheduleOptions& o, OptionList& options);

// The strokes the actuator may be sent to.
struct SoftLimits {
  linkage::UsedRange used;  // of the linkage
  double lower_mm = 0, upper_mm = 0;
  double lower_end_mm = 0, upper_end_mm = 0;  // of the linkage: its assembly, its turning point, or standing
};

// The used range from d_min to d_max, less the margin wherever the linkage, not the actuator, sets the end. Throws
// Error if nothing is left.
SoftLimits SoftLimitsOf(const linkage::Design& design, double margin_mm);

// Stroke over time: piecewise linear between knots, the first at time 0.
struct StrokeSchedule {
  linkage::Links links;
  SoftLimits limits;
  std::vector<linkage::StrokeProgram::Knot> knots;
  int reversals = 0;
  double smoothed_mm = 0;   // the farthest that taking small reversals away has moved the program
  double added_rest_s = 0;  // by the pauses that were put in before reversals

  double Duration() const { return knots.back().time_s; }
  double StrokeAt(double time_s) const { return linkage::StrokeAt(knots, time_s); }
};

// The program as the design has it; StepInsteadOfCrawling and LimitAcceleration then fit it to the actuator. Throws
// Error naming time, stroke and limit if the program leaves the soft limits or exceeds the speed limit;
// UsageError if the design has no program and no speed is given, or an angle is out of range.
StrokeSchedule MakeSchedule(const linkage::Design& design, const ScheduleOptions& options);

// What steps in place of crawling come to.
struct CrawlSummary {
  int stretches = 0;
  double duration_s = 0;                           // of all of them
  double stroke_error_mm = 0, knee_error_deg = 0;  // the farthest that a step is behind the program
  double added_rest_s = 0;                         // where the brake takes longer than the program has time for
};

// Slower than the slowest speed of its duty table a screw sticks, or moves at a speed that nobody knows. There the
// actuator rests, then catches up at that slowest speed, again and again; each step ends where the program is.
CrawlSummary StepInsteadOfCrawling(StrokeSchedule& schedule, const DutyTable& table, double dead_time_s);

// Ramps of constant acceleration in place of the knots, inside the corners, so strokes stay within their limits. Half a
// ramp is added before and after the program; rests are lengthened where they have no room for their ramps. Throws
// Error naming time and speed of a stretch that is too short for its ramps.
void LimitAcceleration(StrokeSchedule& schedule, double most_mm_s2, double dead_time_s);

// Throws Error naming time, speed and limit if the schedule asks for a speed that the table does not have.
void CheckSpeeds(const StrokeSchedule& schedule, const DutyTable& table);

// Between two knots.
inline double SpeedOf(const linkage::StrokeProgram::Knot& from, const linkage::StrokeProgram::Knot& to) {
  return (to.stroke_mm - from.stroke_mm) / (to.time_s - from.time_s);
}

// 1 extending, -1 retracting, 0 at rest: slower than the firmware's unit of speed, 1 um/s, can hold.
int DirectionOf(double speed_mm_s);

// When the plan between two knots is at a stroke for the first time; at the second knot where it never is.
double TimeAt(const std::vector<linkage::StrokeProgram::Knot>& knots, std::size_t first, std::size_t last,
              double stroke_mm);

// program.csv: a row per sample, and one at each knot and at the end. Speed and duty hold until the next row; speed is
// positive extending, 0 in the last row; duty 0..1, NaN without a table.
struct ScheduleRow {
  double time_s = 0, stroke_mm = 0, speed_mm_s = 0, knee_deg = 0;
  int direction = 0;
  double duty = 0;
};

// Throws Error naming rate and duration if there would be more than kMostScheduleRows rows.
inline constexpr std::size_t kMostScheduleRows = 1'000'000;
std::vector<ScheduleRow> SampleSchedule(const StrokeSchedule& schedule, double rate_hz, const DutyTable* table);
void WriteScheduleCsv(const std::filesystem::path& path, const std::vector<ScheduleRow>& rows);

// Measured strokes; times ascend.
struct StrokeSeries {
  std::string name;  // for messages
  std::vector<linkage::StrokeProgram::Knot> knots;
};

// Knee angle at a stroke of the schedule's linkage.
double KneeDegAt(const linkage::Links& links, double stroke_mm);

}  // namespace lake::actuator
