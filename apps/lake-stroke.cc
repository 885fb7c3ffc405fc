// lake-stroke: a design's stroke program with the firmware that runs it; a duty table from logs; a prototype's video
// against its prediction.
#include <filesystem>
#include <optional>
#include <string>

#include "lake/commands/stroke.h"
#include "lake/core/error.h"
#include "program.h"

namespace lake {
namespace {

struct CalibrateArguments {
  commands::DutyRunOptions options;
  std::string potentiometer;
};

void BindFirmware(CLI::App& cli, actuator::FirmwareOptions& o) {
  cli.add_option("--home-stroke", o.home_stroke_mm,
                 "Stroke at which the retract end stop acts, mm (0: the lower soft limit)");
  cli.add_option("--home-speed", o.home_speed_mm_s, "Speed of homing, mm/s, as far as the duty table has it");
  cli.add_option("--command-timeout", o.command_timeout_s,
                 "Motion stops when the host is silent for so long, s (0: never)");
  cli.add_option(
      "--speed-tolerance", o.speed_tolerance_percent,
      "How far speeds may differ from the duty table, percent: part of the drift bound (default: the table's "
      "tolerance_percent, else 10)");
  cli.add_option("--home-error", o.home_error_mm,
                 "How well the stroke is known after homing, mm: part of the drift bound");
  cli.add_option("--lag", o.lag_s, "Time by which the speed may lag behind the duty, s: part of the drift bound");
  cli.add_option("--stop-travel", o.stop_travel_mm,
                 "Within which an end stop releases when the actuator moves away from it, mm");
  cli.add_option("--extend-stop", o.extend_stop_mm,
                 "The extend end stop acts so many mm before the linkage's end (0: there is none)");
  cli.add_flag("--accept-drift", o.accept_drift,
               "For a bench without a person: write a program whose drift may pass the linkage's end");
  cli.add_option("--table-tolerance", o.table_tolerance_mm,
                 "Stroke error allowed to fit a long program into the flash, mm");
}

void BindProgram(CLI::App& cli, commands::StrokeRunOptions& o) {
  cli.add_option("design", o.design, "design.yaml, as lake-optimize writes it")->type_name("DESIGN");
  cli.add_option("--duty-table", o.duty_table,
                 "duty_table.csv of this actuator, bridge and supply; without it no firmware");
  cli.add_option("--speed", o.schedule.speed_mm_s, "Constant speed in mm/s instead of the design's program");
  cli.add_option("--from-angle", o.schedule.from_deg, "Constant program: knee angle at its start (default: at d_min)");
  cli.add_option("--to-angle", o.schedule.to_deg, "Constant program: knee angle at its end (default: standing)");
  cli.add_option("--motion", o.motion, "Folder of a human trial: its seated and standing angles are the program's")
      ->type_name("TRACKDIR");
  cli.add_flag("--return", o.schedule.return_trip, "Afterwards back to the start, the same way");
  cli.add_option("--hold", o.schedule.hold_s, "Rest before --return, s");
  cli.add_option("--margin", o.schedule.margin_mm, "Kept from standing and from the linkage's ends, mm of stroke");
  cli.add_option("--max-speed", o.schedule.max_speed_mm_s, "Speed limit of the actuator, mm/s");
  cli.add_option("--max-acceleration", o.schedule.max_acceleration_mm_s2,
                 "Acceleration limit of the actuator, mm/s² (none: speeds change at once)");
  cli.add_option("--dead-time", o.schedule.dead_time_s, "Brake before a reversal, s");
  cli.add_option("--rate", o.rate_hz, "Rows per second of program.csv");
  cli.add_option("--validate", o.validate, "lake-track folder of a prototype's video to hold against the program")
      ->type_name("TRACKDIR");
  cli.add_option("--tolerance", o.tolerance_deg, "RMS up to which a prototype follows its prediction, degrees");
  BindFirmware(cli, o.firmware);
}

CLI::App* BindCalibrate(CLI::App& cli, CalibrateArguments& a) {
  CLI::App* sub = cli.add_subcommand("calibrate", "A duty table from logs of time_s,stroke_mm,duty");
  actuator::CalibrateOptions& o = a.options.calibrate;
  sub->add_option("logs", a.options.logs, "CSV logs, or the firmware's serial output")->type_name("LOGS");
  sub->add_option("--pot", a.potentiometer, "Scale of the adc column: COUNTS=MM,COUNTS=MM");
  sub->add_option("--video", a.options.video,
                  "lake-track folder of a video of the actuator, filmed while the log was written")
      ->type_name("TRACKDIR");
  sub->add_option("--rod-markers", a.options.rod, "Its two markers: on the actuator's body, on its rod")
      ->delimiter(',')
      ->type_name("BODY,ROD");
  sub->add_option("--settle", o.settle_s, "Left out at the beginning of each plateau, s");
  sub->add_option("--min-plateau", o.min_plateau_s, "Shortest plateau of constant duty, s");
  sub->add_option("--still", o.still_mm_s, "Slower is standing still, mm/s");
  sub->add_option("--steady", o.steady_fraction, "How much the speeds of a plateau's halves may differ");
  sub->add_flag("--write-firmware", a.options.write_firmware, "No logs yet: write the firmware that makes them");
  sub->add_option("--dead-time", a.options.firmware.dead_time_s, "Its brake before a reversal, s");
  sub->add_option("--command-timeout", a.options.firmware.command_timeout_s,
                  "Its motion stops when the host is silent for so long, s (0: never)");
  sub->footer("Example:\n  lake-stroke calibrate serial.csv --pot 102=242,921=372 -o actuator");
  sub->fallthrough();
  return sub;
}

std::string ResultName(const commands::StrokeRunOptions& stroke, bool calibrate) {
  return calibrate ? "duty" : "stroke-" + stroke.design.stem().string();
}

}  // namespace
}  // namespace lake

int main(int argc, char** argv) {
  using namespace lake;
  Program program("lake-stroke", "A design's stroke program and the firmware that drives the actuator through it.",
                  "lake-stroke design.yaml --speed 5 --duty-table duty_table.csv -o stroke");
  commands::StrokeRunOptions stroke;
  CalibrateArguments calibrate;
  BindProgram(program.Cli(), stroke);
  const CLI::App* calibrate_command = BindCalibrate(program.Cli(), calibrate);
  program.Cli().require_subcommand(0, 1);
  return program.Main(
      argc, argv, [&] { return ResultName(stroke, calibrate_command->parsed()); },
      [&](Run& run) {
        if (!calibrate_command->parsed()) {
          if (stroke.design.empty()) throw UsageError("which design? see lake-stroke --help");
          return commands::RunStroke(stroke, run);
        }
        if (!calibrate.potentiometer.empty())
          calibrate.options.potentiometer = actuator::ParsePotentiometerScale(calibrate.potentiometer);
        return commands::RunDutyCalibration(calibrate.options, run);
      },
      [&](const Json& summary) {
        return calibrate_command->parsed() ? commands::DutyReport(summary) : commands::StrokeReport(summary);
      });
}
