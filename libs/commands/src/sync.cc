#include "lake/commands/sync.h"

#include <fmt/format.h>

#include "lake/commands/gait.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"
#include "lake/exchange/convert.h"
#include "lake/figure/trial_figures.h"
#include "png_and_svg.h"

namespace lake::commands {
namespace {

namespace fs = std::filesystem;

sync::Alignment Align(const SyncRunOptions& options) {
  const sync::Movement a = sync::ReadMovement(options.a, options.reading),
                       b = sync::ReadMovement(options.b, options.reading);
  if (options.signal_a.empty()) return sync::AlignByMotion(a, b, options.align);
  return sync::AlignBySignal(sync::SampledSignal(sync::RisesOf(options.a, options.signal_a, options.reading), a),
                             sync::SampledSignal(sync::RisesOf(options.b, options.signal_b, options.reading), b), a, b,
                             options.align);
}

Json AlignmentJson(const sync::Alignment& alignment) {
  Json parts = Json::array();
  for (const sync::PartOffset& part : alignment.parts)
    parts.push_back({{"time_s", part.time_s}, {"departure_s", part.departure_s}, {"sd_s", part.sd_s}});
  return {{"offset_s", alignment.clock.offset_s},
          {"offset_interval_s",
           {alignment.clock.offset_s - 1.96 * alignment.clock.sd_s,
            alignment.clock.offset_s + 1.96 * alignment.clock.sd_s}},
          {"drift_ppm", alignment.clock.drift_ppm},
          {"drift_sd_ppm", alignment.drift_sd_ppm},
          {"from_s", alignment.clock.from_s},
          {"sd_s", alignment.clock.sd_s},
          {"method", alignment.clock.method},
          {"compared", alignment.comparison.name},
          {"unexplained", alignment.unexplained},
          {"overlap_s", alignment.overlap_s},
          {"parts", parts}};
}

std::string ReportOf(const sync::Alignment& alignment) {
  const sync::Clock& clock = alignment.clock;
  return fmt::format(
      "offset {} s (1 SD) to add to B's times, drift {} ppm; by {}, {} ({:.1f} % not explained) over {:.1f} s\n",
      WithSign(PlusMinusText(clock.offset_s, clock.sd_s, 4)),
      WithSign(PlusMinusText(clock.drift_ppm, alignment.drift_sd_ppm, 1)), clock.method, alignment.comparison.name,
      100 * alignment.unexplained, alignment.overlap_s);
}

}  // namespace

void Describe(SyncRunOptions& o, OptionList& options) {
  const char* known = "A lake-track folder, a trial file, ground forces (.mot, .sto) or a sensor's table (.csv)";
  options.AddOperand("a", o.a, fmt::format("{}: its clock stays", known)).Required();
  options.AddOperand("b", o.b, "The other recording of the movement, likewise: its times are brought to A's clock")
      .Required();
  options
      .Add("signal-a", o.signal_a,
           "Marker of A that comes into sight (a lamp), or column that rises (a trigger), at the same time as B's")
      .Otherwise("aligned by the movement");
  options.Add("signal-b", o.signal_b, "The same of B").Otherwise("aligned by the movement");
  options.Add("drift-sd", o.align.drift_sd_ppm, "How far apart clocks of this kind run, 1 SD; 0: they do not drift")
      .Unit("ppm")
      .NotNegative();
  exchange::DescribeRate(o.reading.rate_hz, options);
  options.Check([&o](const OptionList&) {
    if (o.signal_a.empty() != o.signal_b.empty())
      throw UsageError("--signal-a and --signal-b: a common signal stands in both recordings; give both");
  });
}

std::vector<InputFile> InputsOf(const SyncRunOptions& options) {
  std::vector<InputFile> inputs;
  for (const auto& [path, role] : {std::pair{options.a, "a"}, {options.b, "b"}})
    if (IsTrialFolder(path)) {
      inputs.push_back({path / "trajectory.csv", role});
      inputs.push_back({path / "tracks.csv", role, true});
    } else {
      inputs.push_back({path, role});
    }
  return inputs;
}

Json RunSync(const SyncRunOptions& options, Run& run) {
  sync::Alignment alignment = Align(options);
  alignment.clock.a = options.a;
  alignment.clock.b = options.b;
  run.AddInputs(InputsOf(options));
  run.Begin({"summary.json", "sync.yaml", "sync.png", "sync.svg"});
  sync::WriteClock(run.Result("sync.yaml"), alignment.clock);
  DrawPngAndSvg("sync", run, figure::DrawSync, alignment,
                fmt::format("{} and {}", options.a.filename().string(), options.b.filename().string()));
  run.Report(ReportOf(alignment));
  return AlignmentJson(alignment);
}

}  // namespace lake::commands
