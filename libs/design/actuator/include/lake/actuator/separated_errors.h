// A prototype's error in two: what its linkage does at the strokes that it had, and what its actuator does with the
// program.
#pragma once

#include <string>
#include <vector>

#include "lake/actuator/prototype_validation.h"
#include "lake/actuator/stroke_schedule.h"

namespace lake::actuator {

// Measured strokes, mm; times ascend, s.
struct StrokeSeries {
  std::string name;  // for messages
  std::vector<double> time_s, stroke_mm;
};

// Both clocks are the strokes' own: a log's, or the video's.
struct SeparatedErrors {
  double linkage_rms_deg = 0, linkage_max_deg = 0;  // measured angle less theta(measured stroke)
  double stroke_offset_mm = 0;  // of lengths between markers: less this they are strokes; fitted to the angles
  double actuator_rms_mm = 0, actuator_max_mm = 0;  // measured stroke less the program's, over its duration
  double actuator_end_mm = 0;                       // at its end
  double program_start_s = 0;                       // in the strokes' time
};

// Strokes that a log of the firmware has from its potentiometer (measured_mm), while it ran the program. The angles'
// clock is aligned as in ValidatePrototype. Throws Error as that does, and if the log has too few rows.
SeparatedErrors SeparateErrorsByLog(const StrokeSchedule& plan, const StrokeSeries& strokes,
                                    const std::vector<AngleSample>& angles);

// Lengths between a marker on the actuator's body and one on its rod, of the same video as the angles. A length is a
// stroke plus a constant that nobody knows: the median that the angles ask for, so a constant error of the linkage's
// strokes stays hidden in it. Throws Error if fewer than 10 frames have both.
SeparatedErrors SeparateErrorsByVideo(const StrokeSchedule& plan, const StrokeSeries& lengths,
                                      const std::vector<AngleSample>& angles);

// The rows of the firmware's log in which it ran: time_s, measured_mm. Throws Error naming the file: no such column.
StrokeSeries ReadMeasuredStrokes(const std::filesystem::path& path);

}  // namespace lake::actuator
