#include "lake/reviewing/run_review.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "lake/commands/compare.h"
#include "lake/compare/decomposition.h"
#include "lake/compare/registration.h"
#include "lake/core/child_program.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/core/json_or_null.h"
#include "lake/core/shell_word.h"
#include "lake/core/standard_output.h"
#include "lake/motion/saved_corrections.h"
#include "lake/review/open_browser.h"
#include "lake/review/pages.h"
#include "lake/review/review.h"
#include "lake/reviewing/design_review.h"
#include "lake/reviewing/tracked_folder.h"
#include "lake/tracking/track_markers.h"
#include "other_reviews.h"
#include "result_inputs.h"

namespace lake::reviewing {

namespace {

namespace fs = std::filesystem;

fs::path OutputOf(const fs::path& video) {
  return fs::path("lake-out") / video.stem();
}

// Those of lake-track's options that the page asks for, beside markers and seeds; and those that lake-review was given.
constexpr std::array kAsked = {"camera",   "scale", "plane-points", "vertical", "crop",         "detector",
                               "polarity", "color", "start",        "end",      "capture-rate", "movement"};

Json WithGiven(Json choices, const Json& given) {
  choices["options"].update(given);
  return choices;
}

// lake-track's options as they were chosen; `words` are what its command line says. Throws UsageError for a choice that
// cannot be.
commands::TrackRunOptions Chosen(const fs::path& video, const Json& choices, std::vector<std::string>& words) {
  commands::TrackRunOptions options;
  OptionList list = OptionsOf(options);
  words = {OperandOf(video)};
  const auto give = [&](const std::string& name, const OptionTexts& texts) {
    for (Option& option : list.All())
      if (option.Name() == name) option.Give(texts);
    for (const std::string& text : texts) words.push_back(fmt::format("--{}={}", name, text));
  };
  give("markers", {fmt::format("{}", fmt::join(choices.at("markers").get<OptionTexts>(), ","))});
  OptionTexts seeds;
  for (const auto& [name, spot] : choices.at("seeds").items()) {
    if (spot.is_array() && spot.size() == 3)
      seeds.push_back(fmt::format("{}={:.1f},{:.1f}@{}", name, spot[0].get<double>(), spot[1].get<double>(),
                                  spot[2].get<std::int64_t>()));
    else if (spot.is_number_unsigned())
      seeds.push_back(fmt::format("{}=#{}", name, spot.get<std::uint64_t>()));
    else
      throw UsageError("marker '{}': this is not the number of a detection", name);
  }
  if (!seeds.empty()) give("seed", seeds);
  for (const char* name : kAsked)
    if (const std::string text = choices.at("options").value(name, ""); !text.empty()) give(name, {text});
  list.Apply();
  options.video = video;
  return options;
}

// The arguments of lake-track.
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
          {"trial_there", fs::exists(OutputOf(video) / "tracks.csv") ? OutputOf(video).string() : ""},
          {"camera_beside", CameraBeside(video)},
          {"detectors", tracking::DetectorNames()},
          {"spots", spots},
          {"choices", {{"markers", tracking::kLegMarkers}, {"seeds", Json::object()}, {"options", Json::object()}}}};
}

// Runs lake-track into a folder.
review::ReviewedTrial Track(const fs::path& programs, const std::vector<std::string>& arguments, const fs::path& folder,
                            const review::BackgroundJob::Control& control) {
  const fs::path tracks = folder / "tracks.csv";
  const auto time_written = [&] {
    return fs::exists(tracks) ? std::optional(fs::last_write_time(tracks)) : std::nullopt;
  };
  const auto before = time_written();
  const ChildEnd end = RunChild(programs / "lake-track", arguments, control.say, control.throw_if_stopped);
  // Its tracks are there also where no leg could be fitted: that may be put right. Those of an earlier run do not
  // count.
  if (end.code != 0 && time_written() == before)
    throw Fail("lake-track ended with code {}: {}", end.code, end.last_line);
  return ReviewedTrialOf(ReadTrackedFolder(folder), programs);
}

// `given`: options of lake-track's beside those that the page asks for.
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
    return Track(programs, ArgumentsOf(video, WithGiven(choices, given)), OutputOf(video), control);
  };
  return work;
}

// Each rise at 0 to 100 %, as it was compared: the compared joint in the leg frame, mm, and the knee angle.
Json RisesOf(const fs::path& folder, const std::string& marker, const Eigen::Vector2d& marker_at_mm) {
  Run reading({"lake-review", "", Json::object(), folder, true});
  compare::RegistrationOptions registration;
  registration.knee = marker;
  registration.marker_at_mm = marker_at_mm;
  const compare::RegisteredTrial trial =
      compare::RegisterTrial(commands::ReadTrialTables(folder, {}, marker, reading), registration);
  Json rises = Json::array();
  for (const compare::StsCurve& curve : trial.repetitions) {
    Json rise = {{"repetition", curve.repetition}, {"knee_deg", curve.knee_deg}};
    for (const Eigen::Vector2d& knee : curve.knee) {
      rise["x"].push_back(knee.x());
      rise["y"].push_back(knee.y());
    }
    rises.push_back(std::move(rise));
  }
  return rises;
}

review::ComparedVideo ReadVideo(const fs::path& folder, const std::string& marker,
                                const Eigen::Vector2d& marker_at_mm) {
  TrackedFolder tracked = ReadTrackedFolder(TrackedTrialOf(folder));
  review::ComparedVideo trial;
  trial.name = fs::path(tracked.options.video).filename().string();
  trial.marker = marker;
  trial.video = tracked.options.video;
  trial.reader = tracked.options.track.reader;
  trial.tracks = motion::ReadMarkerCsv(tracked.folder / "tracks.csv");
  trial.motion = motion::ReadKinematicsCsv(folder / "kinematics.csv");
  trial.rises = RisesOf(folder, marker, marker_at_mm);
  return trial;
}

// Of a trial that was compared.
fs::path TrialFolder(const Json& summary, const std::string& role, const fs::path& folder) {
  if (!InputOf(summary, role + " motion"))
    throw Fail("{}: compares files without a video; lake review shows comparisons of two lake-track folders",
               folder.string());
  return FindInput(summary, role + " motion", folder).parent_path();
}

Json CurvesOf(const fs::path& folder, const Json& summary) {
  const CsvTable table = CsvTable::Read(folder / "misalignment.csv");
  Json curves = Json::object();
  for (const char* name : {"percent", "distance_mm", "human_knee_deg", "exo_knee_deg", "spike"}) {
    const std::size_t column = table.Column(name);
    Json& values = curves[name] = Json::array();
    for (std::size_t row = 0; row < table.Rows(); ++row) {
      const auto number = table.Number(row, column);
      values.push_back(ValueOrNull(number));
    }
  }
  const Json& parts = summary.at("decomposition");
  curves["rms_mm"] = summary.at("metrics").at("rms_mm");
  for (const compare::Part& part : compare::kParts) curves["parts"][part.name] = parts.at(part.name).at("fraction");
  return curves;
}

// Throws Error: not a folder of lake-compare's, a trial that has no video or is not to be found.
review::ComparedPair ReadComparedPair(const fs::path& folder) {
  const Json summary = ReadSummary(folder / "summary.json");
  try {
    const fs::path human = TrialFolder(summary, "human", folder), exo = TrialFolder(summary, "exo", folder);
    const Json& markers = summary.at("markers");
    const fs::path name = folder.has_filename() ? folder : folder.parent_path();
    const auto joint_at_mm = summary.value("joint_at_mm", std::array<double, 2>{0, 0});  // of older comparisons: none
    return {name.filename().string(), ReadVideo(human, markers.at("human"), Eigen::Vector2d::Zero()),
            ReadVideo(exo, markers.at("exo"), {joint_at_mm[0], joint_at_mm[1]}), CurvesOf(folder, summary)};
  } catch (const nlohmann::json::exception& error) {
    throw Fail("{}: is not a summary as lake compare writes it ({})", (folder / "summary.json").string(), error.what());
  }
}

void Announce(const std::string& address, const review::PageOptions& page) {
  if (const std::string warning = WhoCanReach(page); !warning.empty()) fmt::print(stderr, "lake-review: {}\n", warning);
  fmt::print("{}\nOpen this address in a browser; closing the page or Ctrl-C ends it.\n", address);
  FlushStdout();
  if (page.open) review::OpenInBrowser("lake-review", address);
}

// With the steps of the last session, unless its corrections were changed by hand since.
review::CorrectionBook BookOf(const TrackedFolder& folder) {
  const video::VideoInfo& video = folder.tracked.video;
  review::CorrectionBook book(folder.tracked.recording, video.width, video.height, folder.tracked.times.repeated,
                              folder.made, folder.events);
  if (folder.history.is_null()) return book;
  std::string why;
  try {
    book.TakeHistory(folder.history);
  } catch (const Error& error) {
    why = error.what();
  } catch (const nlohmann::json::exception& error) {
    why = error.what();
  }
  if (!why.empty())
    fmt::print(stderr, "lake-review: warning: {}: earlier steps cannot be undone: {}\n", folder.folder.string(), why);
  return book;
}

}  // namespace

void Describe(ReviewRunOptions& o, OptionList& options) {
  options
      .AddOperand(
          "subject", o.subject,
          "A folder of lake-track, lake-compare, lake-optimize, lake-simulate or lake-run; a design.yaml; a video "
          "whose markers are to be named; or a folder of films and results, to begin in")
      .Required()
      .IsPath(Option::Path::kVideo);
  review::Describe(o.page, options);
  options.Add("capture-rate", o.capture_rate_hz, "Of a video: the rate at which its pictures were taken")
      .Unit("Hz")
      .Positive()
      .Otherwise("the file's own times");
  gait::DescribeMovement(o.movement, options);
  options.Add("problem", o.problem, "Of a design: the problem file with its limits")
      .Otherwise("those that it was optimised with, else the paper's");
}

review::ReviewedTrial ReviewedTrialOf(TrackedFolder tracked_folder, const fs::path& programs) {
  const auto folder = std::make_shared<TrackedFolder>(std::move(tracked_folder));
  const auto fit = [folder](const motion::MarkerRecording& corrected) {
    tracking::TrackResult tracked = folder->tracked;
    tracked.recording = corrected;
    commands::TrackFit fitted = commands::FitTracked(folder->options, tracked);
    return review::TrialFit{std::move(fitted.leg), std::move(fitted.tracks), std::move(fitted.estimates),
                            std::move(fitted.in_plane), std::move(fitted.warnings)};
  };
  const auto save = [folder](const review::CorrectionBook& book) { SaveCorrections(*folder, book); };
  const auto is_applied = [folder] { return motion::UnappliedCorrections(folder->folder).empty(); };
  std::function<review::ReviewedTrial(const review::BackgroundJob::Control&)> apply;
  if (!folder->arguments.empty())
    apply = [folder, programs](const review::BackgroundJob::Control& control) {
      std::vector<std::string> arguments = folder->arguments;
      if (const fs::path events = folder->folder / motion::kSavedEvents; fs::exists(events))
        arguments.insert(arguments.end(), {"--events", events.string()});
      return Track(programs, arguments, folder->folder, control);
    };
  Json measures = Json::array();
  for (const gait::MarkerMeasure& measure : folder->options.measures) measures.push_back(gait::MeasureJson(measure));
  tracking::DetectorMaker detector = tracking::ClickDetector(folder->options.video, folder->options.track);
  const video::VideoInfo& video = folder->tracked.video;
  const std::vector<std::int64_t>& repeated = folder->tracked.times.repeated;
  return {BookOf(*folder),
          repeated,
          {fit, save, is_applied},
          std::move(apply),
          std::move(detector),
          {{"name", folder->options.video.filename().string()},
           {"folder", folder->folder.string()},
           {"command", folder->command},
           {"command_with_events", folder->command_with_events},
           {"can_apply", !folder->arguments.empty()},
           {"measures", measures},
           {"warnings", folder->warnings},
           {"width", video.width},
           {"height", video.height}}};
}

namespace {

void ReviewDesign(const ReviewRunOptions& options, const review::PageOptions& page, const fs::path& programs) {
  const DesignSubject subject = ReadDesignSubject(options.subject, options.problem);
  review::ServeDesign(page, subject.explored, DesignWorkOf(subject, programs));
}

// What lake-review says over lake-track's own options.
Json GivenToTrack(const ReviewRunOptions& options) {
  Json given = Json::object();
  if (options.capture_rate_hz > 0) given["capture-rate"] = fmt::format("{}", options.capture_rate_hz);
  if (options.movement) given["movement"] = gait::NameOf(*options.movement);
  return given;
}

void ReviewVideo(const ReviewRunOptions& options, const review::PageOptions& page, const fs::path& programs) {
  review::ReviewOptions video;
  video.page = page;
  video.video = options.subject;
  video.reader.capture_rate_hz = options.capture_rate_hz;
  review::ServeReview(video, std::nullopt, NamingOf(options.subject, GivenToTrack(options), programs));
}

void ReviewTrial(const ReviewRunOptions& options, const review::PageOptions& page, const fs::path& programs) {
  TrackedFolder folder = ReadTrackedFolder(options.subject, GivenToTrack(options));
  review::ReviewOptions trial;
  trial.page = page;
  trial.video = folder.options.video;
  trial.reader = folder.options.track.reader;
  review::ServeReview(trial, ReviewedTrialOf(std::move(folder), programs), std::nullopt);
}

bool IsDesignFile(const fs::path& file) {
  return file.extension() == ".yaml" || file.extension() == ".yml";
}

}  // namespace

void RunReview(const ReviewRunOptions& options, const fs::path& programs) {
  review::PageOptions page = options.page;
  page.ready = [&options](const std::string& address) { Announce(address, options.page); };
  const bool is_folder = fs::is_directory(options.subject);
  const std::string maker = is_folder ? MakerOf(options.subject) : "";
  const bool is_design = is_folder ? FindsDesigns(maker) || maker == "lake-simulate" : IsDesignFile(options.subject);
  if (!is_design && !options.problem.empty())
    throw UsageError("--problem has the limits of a design, and this is none");
  if ((is_design || is_folder) && options.capture_rate_hz > 0)
    throw UsageError("--capture-rate only applies to a video; a folder of lake track knows its rate");
  if ((is_design || maker == "lake-compare" || maker == "lake-run") && options.movement)
    throw UsageError("--movement is of a trial or a video, and this is none");
  if (is_design) return ReviewDesign(options, page, programs);
  if (maker == "lake-compare") return review::ServeComparison(page, ReadComparedPair(options.subject));
  if (maker == "lake-run") return review::ServeStudy(page, StudyWorkOf(options.subject, options.page, programs));
  if (is_folder && maker.empty()) {
    fs::current_path(options.subject);  // what is made from there on lies in it
    return review::ServeStart(page, StartWorkOf(options.page, programs));
  }
  if (is_folder) return ReviewTrial(options, page, programs);
  ReviewVideo(options, page, programs);
}

}  // namespace lake::reviewing
