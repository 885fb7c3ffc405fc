#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <optional>

#include "lake/commands/stroke.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"

namespace lake::commands {

Json RunStrokeSession(const StrokeSessionRunOptions& options, Run& run) {
  if (options.folder.empty()) throw UsageError("which program? give the folder that lake-stroke wrote");
  if (options.session.port.empty()) throw UsageError("which serial line? give --port /dev/ttyACM0");
  const actuator::SketchIdentity sketch = actuator::ReadSketchIdentity(options.folder);
  run.AddInput(options.folder / "stroke_table.h", "stroke table");
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
  return {{"rows", result.rows},
          {"homing_s", result.homing_s},
          {"run_s", result.run_s},
          {"design_hash", sketch.design_hash},
          {"program_hash", sketch.program_hash}};
}

std::string StrokeSessionReport(const Json& summary) {
  return fmt::format("homed in {:.1f} s, ran for {:.1f} s; {} rows in log.csv\n", summary["homing_s"].get<double>(),
                     summary["run_s"].get<double>(), summary["rows"].get<std::size_t>());
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

Json RunStrokeTalk(const StrokeTalkRunOptions& options, Run& run) {
  if (options.talk.port.empty()) throw UsageError("which serial line? give --port /dev/ttyACM0");
  actuator::RunTalk(options.talk, STDIN_FILENO, std::cout, run.Result("serial.csv"), ThrowIfInterrupted);
  return Json::object();
}

void Describe(StrokeTalkRunOptions& o, OptionList& options) {
  options.Add("port", o.talk.port, "Serial line of the board: /dev/ttyACM0").Value("TTY");
  options.Add("keep-alive", o.talk.keep_alive_s, "Between two signs of life to the firmware")
      .Unit("s")
      .Between(0.02, 10);
}

}  // namespace lake::commands
