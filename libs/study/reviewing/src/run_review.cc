#include "lake/reviewing/run_review.h"

#include <cstdio>
#include <memory>

#include "comparison_review.h"
#include "lake/core/error.h"
#include "lake/core/standard_output.h"
#include "lake/review/open_browser.h"
#include "lake/review/review.h"
#include "lake/reviewing/design_review.h"
#include "naming_review.h"
#include "result_inputs.h"
#include "study_review.h"

namespace lake::reviewing {

namespace fs = std::filesystem;

namespace {

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

// What measures a marker near a click as the tracker did it; none for patches. An ArUco marker may be larger than what
// is near.
review::SnapDetector DetectorOf(const fs::path& video, const tracking::TrackOptions& track) {
  using tracking::DetectorRegion;
  switch (track.detector) {
    case tracking::DetectorKind::kReflective:
      return [polarity = track.polarity](const DetectorRegion& near) {
        return tracking::MakeReflectiveDetector(polarity, near);
      };
    case tracking::DetectorKind::kColor:
      return [hues = tracking::FindHues(video, track)](const DetectorRegion& near) {
        return tracking::MakeColorDetector(hues, near);
      };
    case tracking::DetectorKind::kAruco:
      return [dictionary = track.dictionary](const DetectorRegion&) {
        return tracking::MakeArucoDetector(dictionary, {});
      };
    case tracking::DetectorKind::kTemplate:
      break;
  }
  return {};
}

}  // namespace

void Describe(ReviewRunOptions& o, OptionList& options) {
  options
      .AddOperand("subject", o.subject,
                  "A folder of lake-track, lake-compare, lake-optimize, lake-simulate or lake-run; a design.yaml; or a "
                  "video whose markers are to be named")
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

review::ReviewedTrial ReviewedTrialOf(TrackedFolder tracked_folder) {
  const auto folder = std::make_shared<TrackedFolder>(std::move(tracked_folder));
  const auto fit = [folder](const motion::MarkerRecording& corrected) {
    tracking::TrackResult tracked = folder->tracked;
    tracked.recording = corrected;
    commands::TrackFit fitted = commands::FitTracked(folder->options, tracked);
    return review::TrialFit{std::move(fitted.leg), std::move(fitted.tracks), std::move(fitted.estimates),
                            std::move(fitted.in_plane), std::move(fitted.warnings)};
  };
  const auto save = [folder](const review::CorrectionBook& book) { SaveCorrections(*folder, book); };
  Json measures = Json::array();
  for (const gait::MarkerMeasure& measure : folder->options.measures) measures.push_back(gait::MeasureJson(measure));
  review::SnapDetector detector = DetectorOf(folder->options.video, folder->options.track);
  const video::VideoInfo& video = folder->tracked.video;
  const std::vector<std::int64_t>& repeated = folder->tracked.times.repeated;
  return {BookOf(*folder),
          repeated,
          {fit, save},
          std::move(detector),
          {{"name", folder->options.video.filename().string()},
           {"folder", folder->folder.string()},
           {"command", folder->command},
           {"command_with_events", folder->command_with_events},
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

void ReviewTrial(const ReviewRunOptions& options, const review::PageOptions& page) {
  TrackedFolder folder = ReadTrackedFolder(options.subject, GivenToTrack(options));
  review::ReviewOptions trial;
  trial.page = page;
  trial.video = folder.options.video;
  trial.reader = folder.options.track.reader;
  review::ServeReview(trial, ReviewedTrialOf(std::move(folder)), std::nullopt);
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
  const bool is_design =
      is_folder ? maker == "lake-optimize" || maker == "lake-simulate" : IsDesignFile(options.subject);
  if (!is_design && !options.problem.empty())
    throw UsageError("--problem has the limits of a design, and this is none");
  if ((is_design || is_folder) && options.capture_rate_hz > 0)
    throw UsageError("--capture-rate only applies to a video; a folder of lake track knows its rate");
  if ((is_design || maker == "lake-compare") && options.movement)
    throw UsageError("--movement is of a trial, a video or a study, and this is none");
  if (is_design) return ReviewDesign(options, page, programs);
  if (maker == "lake-compare") return review::ServeComparison(page, ReadComparedPair(options.subject));
  if (maker == "lake-run") return review::ServeStudy(page, StudyWorkOf(options.subject, options.movement, programs));
  if (is_folder && maker.empty())
    throw Fail("{}: holds no results of lake track, compare, optimize, simulate or run", options.subject.string());
  if (is_folder) return ReviewTrial(options, page);
  ReviewVideo(options, page, programs);
}

}  // namespace lake::reviewing
