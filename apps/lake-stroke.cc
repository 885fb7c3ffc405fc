// lake-stroke: a design's stroke program with the firmware that runs it; a duty table from logs; a prototype's video
// against its prediction; the program in the board, watched; a terminal for it.
#include <functional>
#include <string>

#include "lake/commands/stroke.h"
#include "lake/core/error.h"
#include "program.h"

int main(int argc, char** argv) {
  using namespace lake;
  Program program("lake-stroke", "A design's stroke program and the firmware that drives the actuator through it.",
                  "lake-stroke design.yaml --speed 5 --duty-table duty_table.csv -o stroke");
  commands::StrokeRunOptions stroke;
  commands::DutyRunOptions duty;
  program.Add(OptionsOf(stroke));
  const std::function<bool()> calibrate =
      program.AddCommand("calibrate", "A duty table from logs of time_s,stroke_mm,duty",
                         "lake-stroke calibrate serial.csv --pot 102=242,921=372 -o actuator", OptionsOf(duty));
  commands::StrokeSessionRunOptions session;
  const std::function<bool()> run_command =
      program.AddCommand("run", "The program in the board: home, run, watch, log",
                         "lake-stroke run stroke --port /dev/ttyACM0 -o log", OptionsOf(session));
  commands::StrokeHomeRunOptions home;
  const std::function<bool()> home_command =
      program.AddCommand("home", "Home, with nobody in the exoskeleton",
                         "lake-stroke home stroke --port /dev/ttyACM0 -o home", OptionsOf(home));
  commands::StrokeTalkRunOptions talk;
  const std::function<bool()> talk_command = program.AddCommand(
      "talk", "A terminal for the firmware: jog 300 1000, stop, home; until the end of input (Ctrl-D)",
      "lake-stroke talk --port /dev/ttyACM0 -o jogs", OptionsOf(talk));
  return program.Main(
      argc, argv,
      [&]() -> std::string {
        if (run_command()) return "stroke-run";
        if (home_command()) return "stroke-home";
        if (talk_command()) return "stroke-talk";
        return calibrate() ? "duty" : "stroke-" + stroke.design.stem().string();
      },
      [&](Run& run) {
        if (run_command()) return commands::RunStrokeSession(session, run);
        if (home_command()) return commands::RunStrokeSession(home.run, run);
        if (talk_command()) return commands::RunStrokeTalk(talk, run);
        if (calibrate()) return commands::RunDutyCalibration(duty, run);
        if (stroke.design.empty()) throw UsageError("the design is missing: give design.yaml; see lake-stroke --help");
        return commands::RunStroke(stroke, run);
      });
}
