#include "naming_review.h"

#include <array>
#include <cmath>
#include <memory>
#include <mutex>
#include <optional>

#include "lake/core/child_program.h"
#include "lake/core/error.h"
#include "lake/core/json_or_null.h"
#include "lake/core/shell_word.h"
#include "lake/reviewing/run_review.h"
#include "lake/tracking/track_markers.h"

namespace lake::reviewing {

namespace fs = std::filesystem;

namespace {

fs::path OutputOf(const fs::path& video) {
  return fs::path("lake-out") / video.stem();
}

// Those of lake-track's options that the page asks for, beside markers and seeds; and those that lake-review was given.
constexpr std::array kAsked = {"camera", "scale", "vertical", "crop",         "detector", "polarity",
                               "color",  "start", "end",      "capture-rate", "movement"};

Json WithGiven(Json choices, const Json& given) {
  choices["options"].update(given);
  return choices;
}

// lake-track's options as they were chosen; `words` are what its command line says. Throws UsageError for a choice that
// cannot be.
commands::TrackRunOptions Chosen(const fs::path& video, const Json& choices, std::vector<std::string>& words) {
  commands::TrackRunOptions options;
  OptionList list = OptionsOf(options);
  words = {(video.string().starts_with('-') ? "./" : "") + video.string()};
  const auto give = [&](const std::string& name, const OptionTexts& texts) {
    for (Option& option : list.All())
      if (option.Name() == name) option.Give(texts);
    for (const std::string& text : texts) words.push_back(fmt::format("--{}={}", name, text));
  };
  give("markers", {fmt::format("{}", fmt::join(choices.at("markers").get<OptionTexts>(), ","))});
  OptionTexts seeds;
  for (const auto& [name, spot] : choices.at("seeds").items()) {
    if (!spot.is_number_unsigned()) throw UsageError("marker '{}': this is not the number of a detection", name);
    seeds.push_back(fmt::format("{}=#{}", name, spot.get<std::uint64_t>()));
  }
  if (!seeds.empty()) give("seed", seeds);
  for (const char* name : kAsked)
    if (const std::string text = choices.at("options").value(name, ""); !text.empty()) give(name, {text});
  list.Apply();
  options.video = video;
  return options;
}

// What lake-track is told, one word each.
std::vector<std::string> ArgumentsOf(const fs::path& video, const Json& choices) {
  std::vector<std::string> words;
  Chosen(video, choices, words);
  words.push_back("-o");
  words.push_back(OutputOf(video).string());
  return words;
}

// At most so many places of a path, evenly chosen.
Json PathJson(const std::vector<Eigen::Vector2d>& path) {
  constexpr std::size_t kMost = 100;
  Json places = Json::array();
  for (std::size_t i = 0; i < path.size(); i += 1 + path.size() / kMost)
    places.push_back({std::round(10 * path[i].x()) / 10, std::round(10 * path[i].y()) / 10});
  return places;
}

// A camera file that lies beside the video, for the person to take; empty if none does.
std::string CameraBeside(const fs::path& video) {
  const fs::path camera = video.parent_path() / "camera.yaml";
  return fs::is_regular_file(camera) ? camera.string() : "";
}

Json SpotsJson(const fs::path& video, const tracking::CandidateList& list, const video::VideoInfo& info) {
  Json spots = Json::array();
  for (const tracking::Candidate& c : list.candidates)
    spots.push_back({{"id", c.id},
                     {"path", PathJson(c.path)},
                     {"frame", c.frame},
                     {"x", c.position.x()},
                     {"y", c.position.y()},
                     {"radius", c.radius_px},
                     {"moves", c.moves}});
  return {{"name", video.filename().string()},
          {"frame", list.frame},
          {"width", info.width},
          {"height", info.height},
          {"frames", ValueOrNull(info.frames)},
          {"camera_beside", CameraBeside(video)},
          {"spots", spots},
          {"choices", {{"markers", tracking::kLegMarkers}, {"seeds", Json::object()}, {"options", Json::object()}}}};
}

review::ReviewedTrial Track(const fs::path& video, const fs::path& programs, const Json& choices,
                            const review::BackgroundJob::Control& control) {
  const fs::path tracks = OutputOf(video) / "tracks.csv";
  const auto time_written = [&] {
    return fs::exists(tracks) ? std::optional(fs::last_write_time(tracks)) : std::nullopt;
  };
  const auto before = time_written();
  const ChildEnd end =
      RunChild(programs / "lake-track", ArgumentsOf(video, choices), control.say, control.throw_if_stopped);
  // Its tracks are there also where no leg could be fitted: that may be put right. Those of an earlier run do not
  // count.
  if (end.code != 0 && time_written() == before)
    throw Fail("lake-track ended with code {}: {}", end.code, end.last_line);
  return ReviewedTrialOf(ReadTrackedFolder(OutputOf(video)));
}

}  // namespace

review::NamingWork NamingOf(const fs::path& video, const Json& given, const fs::path& programs) {
  review::NamingWork work;
  work.find = [video, given, busy = std::make_shared<std::mutex>()](const Json& options) {
    const std::lock_guard one_at_a_time(*busy);
    std::vector<std::string> words;
    const Json choices = {{"markers", tracking::kLegMarkers}, {"seeds", Json::object()}, {"options", options}};
    tracking::TrackOptions track = Chosen(video, WithGiven(choices, given), words).track;
    track.quiet = true;
    const video::VideoInfo info = video::VideoReader::Open(video, track.reader)->Info();
    return SpotsJson(video, tracking::FindCandidates(video, track), info);
  };
  work.said = [video, given](const Json& choices) {
    std::vector<std::string> words = {"lake", "track"};
    for (const std::string& word : ArgumentsOf(video, WithGiven(choices, given))) words.push_back(ShellWord(word));
    return fmt::format("{}", fmt::join(words, " "));
  };
  work.track = [video, given, programs](const Json& choices, const auto& control) {
    return Track(video, programs, WithGiven(choices, given), control);
  };
  return work;
}

}  // namespace lake::reviewing
