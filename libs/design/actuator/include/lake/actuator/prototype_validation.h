// A prototype's knee angle, as tracked in a video, against what its linkage has at the strokes it was driven through:
// the paper's last figure.
#pragma once

#include <filesystem>
#include <vector>

#include "lake/actuator/stroke_schedule.h"

namespace lake::actuator {

// One frame; NaN never.
struct AngleSample {
  double time_s = 0, knee_deg = 0;
};

struct ValidatedSample {
  double time_s = 0;          // of the video
  double program_time_s = 0;  // of the program, after alignment
  double stroke_mm = 0, predicted_deg = 0, measured_deg = 0;
  bool moving = false;  // the program is between its start and its end

  double Error() const { return measured_deg - predicted_deg; }
};

struct Validation {
  std::vector<ValidatedSample> samples;
  double shift_s = 0;               // the program's start in the video's time
  double rms_deg = 0, max_deg = 0;  // over the moving samples
  double max_time_s = 0;            // where the largest error is
  double offset_deg = 0;  // a constant that the measured angle may have (a marker or a link off its place), …
  double rms_with_offset_deg = 0;  // … fitted together with a shift of its own: what then is left, over all samples
  double speed_mm_s = 0, speed_se_mm_s = 0;  // constant programs: the prototype's own, from d(measured angle); else NaN
  double travel_factor = 1;                  // what the prototype travels for each mm of the program, …
  double start_with_factor_s = 0;            // … fitted together with its start in the video's time, …
  double rms_with_factor_deg = 0;  // … and what then is left, over the program's duration: the linkage's own error
  double drift_mm = 0;             // by the factor: where the prototype ends, less where the program ends
  double covered = 0;              // fraction of the program's duration that the video shows
};

// The shift minimises the RMS of theta(d(t - shift)) against all samples, before the start and after the end at rest;
// it is sought over all overlaps, then refined by Brent's minimisation to a microsecond. Where the angle changes evenly
// a shift hides an offset; only a video that shows a rest tells them apart. Throws Error for fewer than 10 samples,
// times that do not ascend, an angle that does not change, or a video that shows less than a quarter of the program.
Validation ValidatePrototype(const StrokeSchedule& schedule, const std::vector<AngleSample>& samples);

// What the comparison comes to.
enum class Verdict {
  kFollows,      // the program's angles at the program's times
  kOtherSpeed,   // the linkage does what it should, the actuator runs faster or slower
  kOtherAngles,  // not the linkage's angles at any speed
};

// Within the tolerance is an RMS of at most `tolerance_deg`.
Verdict Judge(const Validation& validation, double tolerance_deg);

void WriteValidationCsv(const std::filesystem::path& path, const Validation& validation);

// A prototype's error in two: what its linkage does at the strokes that it had, and what its actuator does with the
// program.
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
