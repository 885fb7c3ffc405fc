#include <cmath>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/provenance.h"
#include "lake/pipeline/stroke.h"
#include "lake/render/stroke_figures.h"

namespace lake {
namespace {

void WritePlateaus(const std::filesystem::path& path, const std::vector<Plateau>& plateaus) {
  CsvWriter table({"log", "begin_s", "end_s", "duty", "speed_mm_s", "standard_error_mm_s", "used"});
  for (const Plateau& p : plateaus)
    table.Add(p.log)
        .Add(p.begin_s)
        .Add(p.end_s)
        .Add(p.duty)
        .Add(p.speed_mm_s)
        .Add(p.standard_error_mm_s)
        .Add(p.used ? 1 : 0)
        .EndRow();
  table.Write(path);
}

Json BandJson(const DeadBand& band) {
  return {{"duty", band.duty}, {"low", band.low}, {"high", band.high}};
}

Json WriteCalibrationFirmware(const DutyRunOptions& options, Run& run) {
  options.firmware.Check();
  WriteTextFile(run.Result("stroke_table.h"),
                CalibrationHeader(options.firmware, fmt::format("Made by lake-stroke {}.", Version())));
  Json files = {"stroke_table.h"};
  for (const FirmwareFile& file : FirmwareSources()) {
    WriteTextFile(run.Result(file.name), file.text);
    files.push_back(file.name);
  }
  return {{"firmware", {{"files", files}, {"segments", 0}}}};
}

}  // namespace

Json RunDutyCalibration(const DutyRunOptions& options, Run& run) {
  if (options.write_firmware && !options.logs.empty())
    throw UsageError("--write-firmware comes before there are logs; give one or the other");
  if (options.write_firmware) return WriteCalibrationFirmware(options, run);
  if (options.logs.empty()) throw UsageError("which logs? name CSV files, or --write-firmware to make them with");
  std::vector<DutyLog> logs;
  for (const auto& path : options.logs) {
    logs.push_back(ReadDutyLog(path, options.potentiometer));
    run.AddInput(path);
  }
  const DutyCalibration calibration = CalibrateDuty(logs, options.calibrate);
  for (const std::string& warning : calibration.warnings) run.Warn(warning);
  WriteDutyTable(run.Result("duty_table.csv"), calibration.rows);
  WritePlateaus(run.Result("plateaus.csv"), calibration.plateaus);
  DrawDutyCalibration(run.Result("duty_table.png"), calibration);
  const DutyTable table = MakeDutyTable(calibration.rows, "duty_table.csv");
  return {{"plateaus", calibration.plateaus.size()},
          {"dead_band", {{"extend", BandJson(calibration.extend)}, {"retract", BandJson(calibration.retract)}}},
          {"largest_speed_mm_s", {{"extend", table.extend.MostSpeed()}, {"retract", table.retract.MostSpeed()}}},
          {"largest_adjustment_mm_s", calibration.largest_adjustment_mm_s}};
}

std::string DutyReport(const Json& summary) {
  if (summary.contains("firmware")) return "calibration firmware written; it obeys jog and stop\n";
  std::string text = fmt::format("{} plateaus\n", summary["plateaus"].get<int>());
  for (const char* direction : {"extend", "retract"}) {
    const Json& band = summary["dead_band"][direction];
    text += fmt::format("{:<8} dead band up to {:.4f} (between {:.4f} and {:.4f}), at most {:.3f} mm/s\n", direction,
                        band["duty"].get<double>(), band["low"].get<double>(), band["high"].get<double>(),
                        summary["largest_speed_mm_s"][direction].get<double>());
  }
  return text;
}

}  // namespace lake
