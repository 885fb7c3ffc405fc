#include "lake/reviewing/tracked_folder.h"

#include <algorithm>
#include <functional>
#include <map>
#include <utility>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/provenance.h"
#include "lake/core/shell_word.h"
#include "lake/motion/saved_corrections.h"
#include "lake/video/video_files.h"
#include "result_inputs.h"

namespace lake::reviewing {

namespace fs = std::filesystem;

namespace {

using motion::kReviewFile;
using motion::kSavedCorrections;
using motion::kSavedEvents;

Json ReadSummaryOf(const fs::path& folder) {
  const std::optional<fs::path> path = FindResult(folder, "summary.json");
  Json summary = path ? ReadSummary(*path) : Json::object();
  if (summary.value("program", "") != "lake-track")
    throw Fail("{}: is not a folder of lake track's (no summary.json of it)", folder.string());
  if (!FindResult(folder, "tracks.csv"))
    throw Fail("{}: holds no tracks.csv; start with the video instead, and name the markers there", folder.string());
  return summary;
}

void ReadOptionsOf(const Json& given, OptionList& list) {
  for (Option& option : list.All())
    if (const auto value = given.find(option.Name()); value != given.end())
      option.Give(value->is_array() ? value->get<OptionTexts>() : OptionTexts{value->get<std::string>()});
  list.Apply();
}

// A camera that a study made stands among the inputs alone.
void ResolveInputs(const Json& summary, const fs::path& folder, commands::TrackRunOptions& options) {
  const std::string file = options.video.filename().string();
  const fs::path found = FindInput(summary, "video", folder);
  options.video = fs::is_directory(found) ? found / file : found;
  if (InputOf(summary, "camera")) options.camera = FindInput(summary, "camera", folder);
  // What lake review keeps in the folder takes the place of events that it was tracked with.
  if (options.events && !fs::exists(folder / kSavedEvents)) options.events = FindInput(summary, "events", folder);
}

std::vector<std::string> ArgumentsOf(const OptionList& list, const commands::TrackRunOptions& options,
                                     const fs::path& folder) {
  std::vector<std::string> words = {options.video.string()};
  if (options.camera) words.insert(words.end(), {"--camera", options.camera->string()});
  for (const Option& option : list.All()) {
    const std::string& name = option.Name();
    if (option.IsOperand() || name == "camera" || name == "corrections" || name == "events") continue;
    std::ranges::copy(WordsOf(option), std::back_inserter(words));
  }
  words.insert(words.end(), {"--corrections", (folder / kSavedCorrections).string(), "-o", folder.string()});
  return words;
}

std::string CommandOf(const std::vector<std::string>& arguments, const fs::path& folder, bool events) {
  std::string command = "lake track";
  for (const std::string& word : arguments) command += fmt::format(" {}", ShellWord(word));
  return events ? command + " --events " + ShellWord((folder / kSavedEvents).string()) : command;
}

// The same in a study.
std::string SectionOf(const fs::path& folder, const Json& given, bool events) {
  const auto path = [&](const char* name) { return fs::absolute(folder / name).lexically_normal().string(); };
  std::string section = "in its section of the study file: corrections: " + path(kSavedCorrections);
  for (const auto& [name, value] : given.items()) section += fmt::format(", {}: {}", name, value.get<std::string>());
  return events ? section + ", events: " + path(kSavedEvents) : section;
}

using Cell = std::pair<std::int64_t, std::string>;

// lake-review's files by their names; empty where they are not there.
std::map<std::string, std::string> KeptIn(const fs::path& folder) {
  std::map<std::string, std::string> kept;
  for (const char* name : {kReviewFile, kSavedCorrections, kSavedEvents})
    kept[name] = fs::exists(folder / name) ? ReadTextFile(folder / name) : "";
  return kept;
}

// Corrections that another lake-review, or an editor, saved meanwhile are not overwritten.
void CheckNotChanged(const TrackedFolder& folder) {
  for (const auto& [name, text] : KeptIn(folder.folder))
    if (text != folder.kept.at(name))
      throw Fail("{}: was changed by another program since this lake review read it; start lake review again to go on",
                 (folder.folder / name).string());
}

// review.json; empty where lake-review has not been at work.
Json ReadReview(const fs::path& folder) {
  const fs::path path = folder / kReviewFile;
  return fs::exists(path) ? ReadJsonFile(path) : Json::object();
}

std::vector<motion::Correction> ReadReplaced(const fs::path& folder, const Json& kept) {
  std::vector<motion::Correction> replaced;
  if (kept.empty()) return replaced;
  try {
    for (const Json& json : kept.at("replaced")) replaced.push_back(review::CorrectionFrom(json));
  } catch (const nlohmann::json::exception& error) {
    throw Fail("{}: is not what lake review writes ({})", (folder / kReviewFile).string(), error.what());
  }
  return replaced;
}

// What the tracks were corrected with must be known to lake-review, or the detector's own positions are lost.
void CheckAreKnown(const TrackedFolder& result) {
  if (!result.options.corrections) return;
  std::map<Cell, bool> known;
  for (const motion::Correction& correction : result.known) known[{correction.frame, correction.marker}] = true;
  for (const motion::Correction& correction : result.made)
    if (!known.contains({correction.frame, correction.marker}))
      throw Fail(
          "{}: was tracked with corrections that lake review did not make, and does not hold what they replaced; track "
          "it without --corrections, put that file into the folder as {}, and review it then",
          result.folder.string(), kSavedCorrections);
}

std::vector<motion::Correction> ReadMade(const TrackedFolder& result) {
  const fs::path path = result.folder / kSavedCorrections;
  const fs::path file = fs::exists(path) ? path : result.options.corrections.value_or(path);
  if (!fs::exists(file)) return {};
  return motion::ReadCorrections(file, result.options.track.names, result.tracked.video.width,
                                 result.tracked.video.height);
}

std::vector<motion::EventCorrection> ReadEvents(const TrackedFolder& result) {
  const fs::path path = result.folder / kSavedEvents;
  const fs::path file = fs::exists(path) ? path : result.options.events.value_or(path);
  return fs::exists(file) ? motion::ReadEventCorrections(file) : std::vector<motion::EventCorrection>{};
}

void ReadTracked(const fs::path& folder, const Json& summary, TrackedFolder& result) {
  tracking::TrackResult& tracked = result.tracked;
  tracked.recording = motion::Measurements(motion::ReadMarkerCsv(folder / "tracks.csv"));
  tracked.video = video::VideoReader::Open(result.options.video, result.options.track.reader)->Info();
  const Json& video = summary.at("video");
  const Json& tracking = summary.at("tracking");
  const bool is_told = video.contains("repeated_frame_numbers") && tracking.contains("up_px");
  if (!is_told) throw Fail("{}: was made by an older version of lake track; track it again", folder.string());
  tracked.times.repeated = video.at("repeated_frame_numbers").get<std::vector<std::int64_t>>();
  const Json& up = tracking.at("up_px");
  tracked.up_px = {up.at(0).get<double>(), up.at(1).get<double>()};
  tracked.sigma.lasting_share = tracking.value("lasting_share", 0.0);
}

}  // namespace

TrackedFolder ReadTrackedFolder(const fs::path& folder, const Json& given) {
  TrackedFolder result;
  result.folder = folder;
  const Json summary = ReadSummaryOf(folder);
  try {
    const bool is_study = IsOfStudy(summary);
    OptionList list = OptionsOf(result.options);
    Json said = GivenOptions(summary, folder);
    said.update(given);
    ReadOptionsOf(said, list);
    ResolveInputs(summary, folder, result.options);
    ReadTracked(folder, summary, result);
    const fs::path absolute = fs::absolute(folder).lexically_normal();
    if (!is_study) result.arguments = ArgumentsOf(list, result.options, absolute);
    const auto command = [&](bool events) {
      return is_study ? SectionOf(folder, given, events) : CommandOf(result.arguments, absolute, events);
    };
    result.command = command(false);
    result.warnings = summary.at("warnings").get<std::vector<std::string>>();
    result.command_with_events = command(true);
  } catch (const nlohmann::json::exception& error) {
    throw Fail("{}: is not a summary as lake track writes it ({})", (folder / "summary.json").string(), error.what());
  }
  // Tracks without corrections are the detector's own; what an earlier run detected does not count then.
  result.kept = KeptIn(folder);
  const Json kept = ReadReview(folder);
  if (result.options.corrections) result.known = ReadReplaced(folder, kept);
  result.history = kept.value("history", Json());
  result.made = ReadMade(result);
  result.events = ReadEvents(result);
  CheckAreKnown(result);
  motion::ApplyCorrections(result.known, result.tracked.recording);
  return result;
}

void SaveCorrections(TrackedFolder& folder, const review::CorrectionBook& book) {
  CheckNotChanged(folder);
  const std::vector<motion::Correction> corrections = book.Corrections();
  std::map<Cell, motion::Correction> replaced;
  for (const motion::Correction& known : folder.known) replaced[{known.frame, known.marker}] = known;
  const motion::MarkerRecording& detected = folder.tracked.recording;
  for (const motion::Correction& made : corrections) {
    const auto row =
        std::lower_bound(detected.frame.begin(), detected.frame.end(), made.frame) - detected.frame.begin();
    const motion::MarkerSample& sample = detected.Find(made.marker)->samples[static_cast<std::size_t>(row)];
    replaced.try_emplace({made.frame, made.marker}, motion::Correction{made.frame, made.marker, sample});
  }
  const std::vector<motion::EventCorrection> events = book.Events();
  const bool has_events = !events.empty() || fs::exists(folder.folder / kSavedEvents);
  Json kept = {{"program", "lake-review"},
               {"version", Version()},
               {"video", folder.options.video.string()},
               {"command", has_events ? folder.command_with_events : folder.command},
               {"corrections", book.Count()},
               {"replaced", Json::array()},
               {"history", book.History()}};
  std::vector<motion::Correction> known;
  for (const auto& [cell, correction] : replaced) {
    kept["replaced"].push_back(review::CorrectionJson(correction));
    known.push_back(correction);
  }
  // First what can be more than there is use for. Of one that cannot be written, those before it are known to be new.
  const auto write = [&folder](const char* name, const std::function<void(const fs::path&)>& to) {
    to(folder.folder / name);
    folder.kept[name] = ReadTextFile(folder.folder / name);
  };
  write(kReviewFile, [&](const fs::path& path) { WriteJsonFile(path, kept); });
  write(kSavedCorrections, [&](const fs::path& path) { motion::WriteCorrections(path, corrections); });
  if (has_events) write(kSavedEvents, [&](const fs::path& path) { motion::WriteEventCorrections(path, events); });
  folder.known = std::move(known);
}

}  // namespace lake::reviewing
