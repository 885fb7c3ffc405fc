#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>

#include "lake/commands/stroke.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/json_or_null.h"

namespace lake::commands {

namespace {

std::string WaitedText(const std::optional<double>& waited_s) {
  if (!waited_s) return ", perhaps longer than planned: the firmware's line about it was damaged";
  if (*waited_s < 0.05) return "";
  return fmt::format(", {:.1f} s longer than planned, as the actuator had not the speed", *waited_s);
}

}  // namespace

Json RunStrokeSession(const StrokeSessionRunOptions& options, Run& run) {
  if (options.folder.empty()) throw UsageError("which program? give the folder that lake-stroke wrote");
  if (options.session.port.empty()) throw UsageError("which serial line? give --port /dev/ttyACM0");
  const actuator::SketchIdentity sketch = actuator::ReadSketchIdentity(options.folder);
  run.AddInput(options.folder / "stroke_table.h", "stroke table");
  for (const std::string& unknown : sketch.unknowns) run.Warn(unknown);
  run.Warn(actuator::kUntried);
  const auto total_ms = static_cast<std::int64_t>(std::llround(1e3 * sketch.duration_s));
  std::optional<Progress> progress;
  std::int64_t shown_ms = 0;
  const auto poll = [&](const std::string& state, double time_s) {
    ThrowIfInterrupted();
    if (state != "running") return;
    if (!progress) progress.emplace("running", "ms", total_ms, run.Quiet());
    const std::int64_t now_ms = std::min(total_ms, static_cast<std::int64_t>(std::llround(1e3 * time_s)));
    progress->Advance(now_ms - shown_ms);
    shown_ms = now_ms;
  };
  const std::filesystem::path log = run.Result("log.csv");
  const actuator::SessionResult result = actuator::RunSession(options.session, sketch, log, poll);
  const std::string ran = result.run_s == 0 ? "" : fmt::format(", ran for {:.1f} s", result.run_s);
  run.Report("homed in {:.1f} s{}{}; {} rows in log.csv\n", result.homing_s, ran, WaitedText(result.waited_s),
             result.rows);
  return {{"rows", result.rows},
          {"homing_s", result.homing_s},
          {"run_s", result.run_s},
          {"waited_s", NumberOrNull(result.waited_s)},
          {"design_hash", sketch.design_hash},
          {"program_hash", sketch.program_hash}};
}

void Describe(StrokeSessionRunOptions& o, OptionList& options) {
  options.AddOperand("folder", o.folder, "Folder of the program that the board has, as lake-stroke wrote it")
      .IsPath(Option::Path::kFolder)
      .Value("DIR");
  options.Add("port", o.session.port, "Serial line of the board: /dev/ttyACM0").Value("TTY");
  options.Add("keep-alive", o.session.keep_alive_s, "Between two signs of life to the firmware")
      .Unit("s")
      .Between(0.02, 10);
  options.Add("acknowledge", o.session.acknowledge, "The board's fault of before was seen to: clear it");
  options.Add("home", o.session.home, "Home first; --no-home: the actuator stands at the program's start")
      .WithNegation();
}

void Describe(StrokeHomeRunOptions& o, OptionList& options) {
  o.run.session.task = actuator::SessionTask::kHome;
  options.AddOperand("folder", o.run.folder, "Folder of the program that the board has, as lake-stroke wrote it")
      .IsPath(Option::Path::kFolder)
      .Value("DIR");
  options.Add("port", o.run.session.port, "Serial line of the board: /dev/ttyACM0").Value("TTY");
  options.Add("acknowledge", o.run.session.acknowledge, "The board's fault of before was seen to: clear it");
}

Json RunStrokeTalk(const StrokeTalkRunOptions& options, Run& run) {
  if (options.talk.port.empty()) throw UsageError("which serial line? give --port /dev/ttyACM0");
  actuator::RunTalk(options.talk, STDIN_FILENO, std::cout, run.Result("serial.csv"), ThrowIfInterrupted);
  run.Report("what the firmware said is in serial.csv\n");
  return Json::object();
}

void Describe(StrokeTalkRunOptions& o, OptionList& options) {
  options.Add("port", o.talk.port, "Serial line of the board: /dev/ttyACM0").Value("TTY");
  options.Add("keep-alive", o.talk.keep_alive_s, "Between two signs of life to the firmware")
      .Unit("s")
      .Between(0.02, 10);
}

}  // namespace lake::commands
