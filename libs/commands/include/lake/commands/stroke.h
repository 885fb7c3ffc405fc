// The work of lake-stroke: a design's stroke program and its firmware; a duty table from logs; a prototype's video
// against its prediction.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/actuator/duty_calibration.h"
#include "lake/actuator/firmware.h"
#include "lake/actuator/stroke_schedule.h"
#include "lake/actuator/stroke_session.h"
#include "lake/core/options.h"
#include "lake/core/run.h"

namespace lake::commands {

struct StrokeRunOptions {
  StrokeRunOptions() { schedule.smooth_mm = actuator::kStrokeResolution_mm; }

  std::filesystem::path design;
  std::optional<std::filesystem::path> duty_table;  // none: no duty, no firmware
  std::optional<std::filesystem::path> motion;    // lake-track or lake-gait folder: a constant program runs between its
                                                  // seated and standing knee angles
  std::optional<std::filesystem::path> validate;  // lake-track folder of a prototype
  std::optional<std::filesystem::path> stroke_log;  // of that prototype's run, with measured strokes: errors apart, …
  std::vector<std::string> rod;                     // … as by the same video's markers on the actuator's body and rod
  double tolerance_deg = 2;                         // RMS up to which a prototype follows its prediction
  double rate_hz = 50;                              // of program.csv
  actuator::ScheduleOptions schedule;
  actuator::FirmwareOptions firmware;
};

void Describe(StrokeRunOptions& o, OptionList& options);
std::vector<InputFile> InputsOf(const StrokeRunOptions& options);

// Writes the firmware's sources with this stroke_table.h into the folder kSketchFolder of the results,
// `notes` on top of the file that one reads first; returns their names.
// Further files, of this program alone, beside them.
Json WriteSketch(actuator::Feedback feedback, const std::string& stroke_table, const std::string& notes, Run& run,
                 const std::vector<actuator::FirmwareFile>& further = {});

// Writes program.csv, program.png; with a duty table the firmware's sketch; with `validate` validation.csv and
// validation.png. Returns the results for the summary.
Json RunStroke(const StrokeRunOptions& options, Run& run);

struct StrokeSessionRunOptions {
  std::filesystem::path folder;  // that RunStroke wrote
  actuator::SessionOptions session;
};
void Describe(StrokeSessionRunOptions& options, OptionList& list);

// Homing alone, with nobody in the exoskeleton.
struct StrokeHomeRunOptions {
  StrokeSessionRunOptions run;
};
void Describe(StrokeHomeRunOptions& options, OptionList& list);

struct StrokeTalkRunOptions {
  actuator::TalkOptions talk;
};
void Describe(StrokeTalkRunOptions& options, OptionList& list);

// A terminal for the firmware, on standard input and output; writes serial.csv, which the calibration reads.
Json RunStrokeTalk(const StrokeTalkRunOptions& options, Run& run);

// Runs the firmware in the board and writes log.csv, the firmware's rows as they came.
Json RunStrokeSession(const StrokeSessionRunOptions& options, Run& run);

// The actuator's length in a tracked video: the distance of two markers, on the actuator's body and on its rod, in the
// frames that show both, mm. Throws Error naming the file: no trajectory in mm, no such marker.
actuator::StrokeSeries ReadRodFilm(const std::filesystem::path& folder, const std::vector<std::string>& names);

struct DutyRunOptions {
  std::vector<std::filesystem::path> logs;
  std::optional<actuator::PotentiometerScale> potentiometer;
  std::optional<std::filesystem::path> video;       // lake-track folder of a film of the actuator; then one log
  std::vector<std::string> rod = {"mount", "rod"};  // its markers: on the body, on the rod
  bool write_firmware = false;                      // the firmware that jogs, instead of reading logs
  actuator::CalibrateOptions calibrate;
  actuator::FirmwareOptions firmware;
};

void Describe(DutyRunOptions& o, OptionList& options);

// Writes duty_table.csv, plateaus.csv, duty_table.png; or the calibration firmware.
Json RunDutyCalibration(const DutyRunOptions& options, Run& run);

}  // namespace lake::commands
