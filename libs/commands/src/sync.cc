#include "lake/commands/sync.h"

#include <fmt/format.h>

#include "lake/commands/gait.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"
#include "lake/exchange/convert_options.h"
#include "lake/figure/sync_figure.h"
#include "png_and_svg.h"

namespace lake::commands {
namespace {

namespace fs = std::filesystem;

// One recording, and where its signal is; both empty: by the movement.
struct Synced {
  const fs::path& recording;
  const std::string& signal;
  const fs::path& film;
  const sync::ClapOptions& clapped;
};

Synced SyncedA(const SyncRunOptions& o) {
  return {.recording = o.a, .signal = o.signal_a, .film = o.clap_a, .clapped = o.clapped_a};
}

Synced SyncedB(const SyncRunOptions& o) {
  return {.recording = o.b, .signal = o.signal_b, .film = o.clap_b, .clapped = o.clapped_b};
}

bool HasSignal(const Synced& side) {
  return !side.signal.empty() || !side.film.empty();
}

// A trial's times are its film's stamps, unless a rate was given for them or a jump in them was mended.
void CheckFilmsTimes(const Synced& side) {
  const fs::path folder = IsTrialFolder(side.recording) ? side.recording : side.recording.parent_path();
  if (!fs::exists(folder / "summary.json")) return;
  const Json said = ReadJsonFile(folder / "summary.json");
  const Json rate = said.value(Json::json_pointer("/options/capture-rate"), Json());
  if (rate.is_string() && !rate.get<std::string>().empty())
    throw Fail("{}: its times are those of --capture-rate {}, not of the stamps in {}, and the sound is on these",
               folder.string(), rate.get<std::string>(), side.film.string());
  for (const Json& jump : said.value(Json::json_pointer("/video/time_jumps"), Json::array()))
    if (jump.value("applied", false))
      throw Fail("{}: its times after frame {} are not those of the stamps in {}, and the sound is on these",
                 folder.string(), jump.value("after_frame", 0), side.film.string());
}

sync::Signal SignalOf(const Synced& side, const sync::Movement& recording, const sync::MovementOptions& reading) {
  if (side.film.empty()) return sync::SampledSignal(sync::RisesOf(side.recording, side.signal, reading), recording);
  CheckFilmsTimes(side);
  return sync::SignalOfClaps(side.film, side.clapped);
}

sync::Alignment Align(const SyncRunOptions& options) {
  const sync::Movement a = sync::ReadMovement(options.a, options.reading),
                       b = sync::ReadMovement(options.b, options.reading);
  if (!HasSignal(SyncedA(options))) return sync::AlignByMotion(a, b, options.align);
  return sync::AlignBySignal(SignalOf(SyncedA(options), a, options.reading),
                             SignalOf(SyncedB(options), b, options.reading), a, b, options.align);
}

// Both films' sounds were on their way equally long, as far as nothing else is known.
void DescribeClaps(const std::string& letter, fs::path& film, sync::ClapOptions& clapped, OptionList& options) {
  options
      .Add("clap-" + letter, film,
           fmt::format("Film of {} in whose sound there is a clap (or a few): in place of --signal-{}",
                       letter == "a" ? "A" : "B", letter))
      .IsPath(Option::Path::kFile)
      .Otherwise("no clap");
  options
      .Add("clap-distance-" + letter, clapped.distance_mm,
           "From that clap to the film's microphone; sound needs 3 ms a metre")
      .Unit("mm")
      .NotNegative()
      .Otherwise("0 to 5000 mm, equally likely");
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
  DescribeClaps("a", o.clap_a, o.clapped_a, options);
  DescribeClaps("b", o.clap_b, o.clapped_b, options);
  options.Add("drift-sd", o.align.drift_sd_ppm, "How far apart clocks of this kind run, 1 SD; 0: they do not drift")
      .Unit("ppm")
      .NotNegative();
  exchange::DescribeRate(o.reading.rate_hz, options);
  options.Check([&o](const OptionList&) {
    if (HasSignal(SyncedA(o)) != HasSignal(SyncedB(o)))
      throw UsageError(
          "--signal-a or --clap-a, and --signal-b or --clap-b: a common signal stands in both recordings; "
          "give both");
    for (const auto& [side, letter] : {std::pair{SyncedA(o), "a"}, {SyncedB(o), "b"}}) {
      if (!side.signal.empty() && !side.film.empty())
        throw UsageError("--signal-{} and --clap-{}: one of them", letter, letter);
      if (side.film.empty() && side.clapped.distance_mm)
        throw UsageError("--clap-distance-{}: of a clap, --clap-{} FILM", letter, letter);
    }
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
  for (const auto& [film, role] : {std::pair{options.clap_a, "clap_a"}, {options.clap_b, "clap_b"}})
    if (!film.empty()) inputs.push_back({film, role});
  return inputs;
}

Json RunSync(const SyncRunOptions& options, Run& run) {
  sync::Alignment alignment = Align(options);
  alignment.clock.a = options.a;
  alignment.clock.b = options.b;
  run.AddInputs(InputsOf(options));
  run.Begin({"summary.json", "sync.yaml", "sync.png", "sync.svg"});
  for (const std::string& warning : alignment.warnings) run.Warn(warning);
  sync::WriteClock(run.Result("sync.yaml"), alignment.clock);
  DrawPngAndSvg("sync", run, [&](const fs::path& path) {
    figure::DrawSync(path, alignment,
                     fmt::format("{} and {}", options.a.filename().string(), options.b.filename().string()));
  });
  run.Report(ReportOf(alignment));
  return AlignmentJson(alignment);
}

}  // namespace lake::commands
