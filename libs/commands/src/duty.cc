#include "lake/actuator/duty_calibration.h"
#include "lake/commands/stroke.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json_or_null.h"
#include "lake/core/provenance.h"
#include "lake/figure/stroke_figures.h"
#include "lake/motion/marker_recording.h"
#include "png_and_svg.h"

namespace lake::commands {
namespace {

void WritePlateaus(const std::filesystem::path& path, const std::vector<actuator::Plateau>& plateaus) {
  CsvWriter table({"log", "begin_s", "end_s", "duty", "speed_mm_s", "standard_error_mm_s", "used"});
  for (const actuator::Plateau& p : plateaus)
    table.AddRow(p.log, p.begin_s, p.end_s, p.duty, p.speed_mm_s, p.standard_error_mm_s, p.used);
  table.Write(path);
}

Json BandJson(const actuator::DeadBand& band) {
  return {{"duty", band.duty}, {"low", band.low}, {"high", band.high}};
}

Json WriteCalibrationFirmware(const DutyRunOptions& options, Run& run) {
  options.firmware.Check();
  const std::string header =
      actuator::CalibrationHeader(options.firmware, fmt::format("Made by lake-stroke {}.", Version()));
  run.Report("calibration firmware written; it obeys jog and stop\n{}\n", actuator::kUntried);
  return {{"firmware", {{"files", WriteSketch(options.firmware.feedback, header, "", run)}, {"segments", 0}}}};
}

std::vector<actuator::DutyLog> ReadLogs(const DutyRunOptions& options, Run& run, Json& alignment) {
  std::vector<actuator::DutyLog> logs;
  for (const auto& path : options.logs) run.AddInput(path, "log");
  if (options.video) {
    if (options.logs.size() != 1 || options.potentiometer)
      throw UsageError("--video: give the one log that was written while it was filmed, and no --pot");
    actuator::AlignedLog aligned =
        actuator::AlignWithFilm(actuator::ReadDutyCommands(options.logs[0]), ReadRodFilm(*options.video, options.rod));
    run.AddInput(*options.video / "trajectory.csv", "film");
    alignment = {{"shift_s", aligned.shift_s}, {"correlation", aligned.correlation}};
    return {std::move(aligned.log)};
  }
  for (const auto& path : options.logs) logs.push_back(actuator::ReadDutyLog(path, options.potentiometer));
  return logs;
}

std::string ReportOf(const actuator::DutyCalibration& calibration, const actuator::DutyTable& table) {
  std::string text = fmt::format("{} plateaus\n", calibration.plateaus.size());
  const auto add = [&](const char* direction, const actuator::DeadBand& band, double most_mm_s) {
    text += fmt::format("{:<8} dead band up to {:.4f} (between {:.4f} and {:.4f}), at most {:.3f} mm/s\n", direction,
                        band.duty, band.low, band.high, most_mm_s);
  };
  add("extend", calibration.extend, table.extend.MostSpeed());
  add("retract", calibration.retract, table.retract.MostSpeed());
  return text +
         (calibration.tolerance_percent
              ? fmt::format("speeds within {:.2f} % of the table, under the loads and supplies that were tried\n",
                            *calibration.tolerance_percent)
              : "no duty was tried twice, so the table has no tolerance: lake-stroke will take 10 %\n");
}

const motion::MarkerTrack& TrackOf(const motion::MarkerRecording& recording, const std::string& name,
                                   const std::string& file) {
  if (const motion::MarkerTrack* track = recording.Find(name)) return *track;
  throw Fail("{}: no marker '{}'; --rod-markers BODY,ROD names the two on the actuator", file, name);
}

}  // namespace

actuator::StrokeSeries ReadRodFilm(const std::filesystem::path& folder, const std::vector<std::string>& names) {
  const std::optional<std::filesystem::path> found = FindResult(folder, "trajectory.csv");
  if (!found)
    throw Fail("{}: no trajectory.csv in it; track the video with --scale or a calibrated plane, lengths in mm",
               folder.string());
  if (names.size() != 2) throw UsageError("--rod-markers: give two names, BODY,ROD");
  const std::filesystem::path& file = *found;
  const motion::MarkerRecording recording = motion::ReadMarkerCsv(file);
  const motion::MarkerTrack &body = TrackOf(recording, names[0], file.string()),
                            &rod = TrackOf(recording, names[1], file.string());
  actuator::StrokeSeries film{folder.string(), {}};
  for (std::size_t i = 0; i < recording.Frames(); ++i) {
    if (body.samples[i].status != motion::SampleStatus::kDetected ||
        rod.samples[i].status != motion::SampleStatus::kDetected)
      continue;
    film.knots.push_back({recording.time_s[i], (rod.samples[i].position - body.samples[i].position).norm()});
  }
  return film;
}

Json RunDutyCalibration(const DutyRunOptions& options, Run& run) {
  if (options.write_firmware && !options.logs.empty())
    throw UsageError("--write-firmware comes before there are logs; give one or the other");
  if (options.write_firmware) return WriteCalibrationFirmware(options, run);
  if (options.logs.empty())
    throw UsageError("no logs given: name CSV files, or use --write-firmware for the firmware that makes them");
  Json alignment;
  const std::vector<actuator::DutyLog> logs = ReadLogs(options, run, alignment);
  run.Begin({"summary.json", "duty_table.csv", "plateaus.csv", "duty_table.png", "duty_table.svg"});
  const actuator::DutyCalibration calibration = actuator::CalibrateDuty(logs, options.calibrate);
  for (const std::string& warning : calibration.warnings) run.Warn(warning);
  actuator::WriteDutyTable(run.Result("duty_table.csv"), calibration.rows);
  WritePlateaus(run.Result("plateaus.csv"), calibration.plateaus);
  DrawPngAndSvg("duty_table", run, figure::DrawDutyCalibration, calibration);
  const actuator::DutyTable table = actuator::MakeDutyTable(calibration.rows, "duty_table.csv");
  run.Report(ReportOf(calibration, table));
  return {{"plateaus", calibration.plateaus.size()},
          {"video", alignment},
          {"dead_band", {{"extend", BandJson(calibration.extend)}, {"retract", BandJson(calibration.retract)}}},
          {"largest_speed_mm_s", {{"extend", table.extend.MostSpeed()}, {"retract", table.retract.MostSpeed()}}},
          {"largest_adjustment_mm_s", calibration.largest_adjustment_mm_s},
          {"tolerance_percent", ValueOrNull(calibration.tolerance_percent)}};
}

}  // namespace lake::commands
