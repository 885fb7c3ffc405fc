#include "lake/commands/track.h"

#include <malloc.h>

#include <algorithm>
#include <cmath>

#include "lake/commands/check.h"
#include "lake/commands/gait.h"
#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"
#include "lake/exchange/c3d.h"
#include "lake/exchange/formats.h"
#include "lake/exchange/trial.h"
#include "lake/figure/trial_figures.h"
#include "lake/gait/learnt_knee.h"
#include "lake/gait/leg_report.h"
#include "lake/gait/movement.h"
#include "lake/gait/rolling_shutter.h"
#include "lake/gait/sit_to_stand.h"
#include "lake/gait/standing_leg.h"
#include "lake/motion/corrections.h"
#include "lake/overlay/overlay_video.h"
#include "lake/overlay/pictures.h"
#include "lake/tracking/recording_verdicts.h"
#include "lake/video/image.h"
#include "lake/video/video_files.h"
#include "movement_tables.h"
#include "png_and_svg.h"

namespace lake::commands {
namespace {

// Of another size of the same aspect it is scaled, with a warning.
std::optional<camera::CameraProfile> ReadCamera(const TrackRunOptions& options, const video::VideoInfo& video) {
  if (!options.camera) return std::nullopt;
  camera::CameraProfile profile = camera::ReadCameraProfile(*options.camera);
  const camera::Camera as_calibrated = profile.camera;
  if (as_calibrated.image_width == video.width && as_calibrated.image_height == video.height) return profile;
  const std::optional<camera::Camera> scaled = camera::CameraAtSize(as_calibrated, video.width, video.height);
  if (!scaled) camera::CheckResolution(as_calibrated, *options.camera, video.width, video.height, options.video);
  profile.camera = *scaled;
  profile.warnings.push_back(fmt::format(
      "{}: calibrated at {}x{} px and scaled to the video's {}x{}; right if this video mode shows the whole of that "
      "picture, uncropped",
      options.camera->string(), as_calibrated.image_width, as_calibrated.image_height, video.width, video.height));
  return profile;
}

gait::LegView ViewOf(const TrackRunOptions& options, const video::VideoInfo& video,
                     const std::optional<camera::CameraProfile>& profile, const gait::Warn& warn) {
  gait::PictureScale picture = options;
  picture.pixel_aspect = video.pixel_aspect;
  return gait::MakeView(picture, profile, {}, warn);
}

using gait::Warn;

Warn WarnThrough(Run& run) {
  return [&run](const std::string& text) { run.Warn(text); };
}

void WarnOfUnit(const gait::LegView& view, bool has_camera, Run& run) {
  if (gait::PlaneUnit(view) == motion::LengthUnit::kPx)
    run.Warn(has_camera ? "the camera file has no sagittal plane, and neither --scale nor --plane-points is given: "
                          "lengths stay in px (angles need no scale)"
                        : "none of --camera with a plane, --scale and --plane-points is given: lengths stay in px "
                          "(angles need no scale)");
}

// A knee that is hidden in every frame is no marker to track.
bool HasLeg(const TrackRunOptions& options) {
  const auto tracks = [&](const char* name) { return std::ranges::count(options.track.names, name) > 0; };
  return tracks("ankle") && (options.fit.knee_trial || tracks("knee")) && tracks("hip");
}

// The fit's estimates where the recording was made, which is what is smoothed in px.
motion::MarkerRecording EstimatesInPicture(const gait::LegFitResult& fit, const gait::LegView& view) {
  motion::MarkerRecording estimates = fit.tracks;
  for (std::size_t m = 0; m < estimates.markers.size(); ++m) {
    const double depth = view.Depth(estimates.markers[m].name);
    for (std::size_t i = 0; i < estimates.Frames(); ++i) {
      const motion::MarkerSample& fitted = fit.trajectory.markers[m].samples[i];
      if (!fitted.IsKnown()) continue;
      motion::MarkerSample& sample = estimates.markers[m].samples[i];
      sample.position = gait::RecordedFromPlane<double>(view, fitted.position, depth);
      sample.sigma = fitted.sigma / gait::PlaneUnitsPerRecorded(view, fitted.position, depth);
    }
  }
  return estimates;
}

// Under a rolling shutter: what was seen, where it was seen; the fit is at the frames' own times.
void TakeSeenPositions(const motion::MarkerRecording& seen, motion::MarkerRecording& tracks) {
  for (motion::MarkerTrack& marker : tracks.markers)
    for (std::size_t i = 0; i < tracks.Frames(); ++i)
      if (marker.samples[i].status == motion::SampleStatus::kDetected)
        marker.samples[i].position = seen.Find(marker.name)->samples[i].position;
}

Json VideoJson(const tracking::TrackResult& tracked) {
  const video::VideoInfo& video = tracked.video;
  Json jumps = Json::array();
  for (const tracking::TimeJump& jump : tracked.times.jumps)
    jumps.push_back({{"before_frame", jump.before},
                     {"after_frame", jump.after},
                     {"stamped_s", jump.stamped_s},
                     {"moved_s", jump.moved_s},
                     {"moved_sigma_s", jump.sigma_s},
                     {"applied", jump.is_applied}});
  Json position_jumps = Json::array();
  for (const tracking::PositionJump& jump : tracked.times.position_jumps)
    position_jumps.push_back({{"before_frame", jump.before}, {"after_frame", jump.after}, {"jump_mm", jump.jump_mm}});
  return {{"width", video.width},
          {"height", video.height},
          {"pixel_aspect", video.pixel_aspect},
          {"frames", tracked.recording.Frames()},
          {"repeated_frames", tracked.times.repeated.size()},
          {"repeated_frame_numbers", tracked.times.repeated},
          {"captured_rate_hz", tracked.times.captured_hz > 0 ? Json(tracked.times.captured_hz) : Json()},
          {"chosen_from_rate_hz", tracked.times.chosen_from_hz > 0 ? Json(tracked.times.chosen_from_hz) : Json()},
          {"time_jumps", jumps},
          {"position_jumps", position_jumps},
          {"uneven_times_s", tracked.times.uneven_s},
          {"frame_rate_hz", video.frame_rate_hz},
          {"codec", video.codec},
          {"rotation_deg", video.rotation_deg},
          {"irregular_time_stamps", video.irregular_stamps},
          {"start_s", tracked.recording.time_s.front()},
          {"end_s", tracked.recording.time_s.back()}};
}

Json TrackingJson(const tracking::TrackResult& tracked) {
  return {{"things_followed", tracked.tracklets},
          {"median_radius_px", tracked.radius_px},
          {"sigma_of_fits_px", tracked.sigma.fit_px},
          {"scatter_px", tracked.sigma.scatter_px},
          {"compression_px", tracked.sigma.compression_px},
          {"lasting_share", tracked.sigma.lasting_share},
          {"up_px", {tracked.up_px.x(), tracked.up_px.y()}},
          {"quality", tracked.figures ? FiguresJson(*tracked.figures) : Json()}};
}

// The part of the frames with any marker in which each was measured; repeated ones show nothing new. Beside it the part
// of all frames that has any.
using SeenShares = std::vector<std::pair<std::string, double>>;
std::pair<SeenShares, double> SeenSharesOf(const motion::MarkerRecording& tracks, std::size_t repeated) {
  const auto is_seen = [](const motion::MarkerTrack& marker, std::size_t i) {
    return marker.samples[i].status == motion::SampleStatus::kDetected;
  };
  std::vector<int> counts(tracks.markers.size());
  int any = 0;
  for (std::size_t i = 0; i < tracks.Frames(); ++i) {
    for (std::size_t m = 0; m < counts.size(); ++m) counts[m] += is_seen(tracks.markers[m], i) ? 1 : 0;
    any += std::ranges::any_of(tracks.markers, [&](const auto& marker) { return is_seen(marker, i); }) ? 1 : 0;
  }
  SeenShares seen;
  for (std::size_t m = 0; m < counts.size(); ++m)
    seen.emplace_back(tracks.markers[m].name, static_cast<double>(counts[m]) / std::max(any, 1));
  return {seen, any / static_cast<double>(tracks.Frames() - repeated)};
}

void WarnOfHiddenKnee(double share, const gait::LegFitOptions& fit, Run& run) {
  run.Warn(
      "knee hidden in {:.0f} % of the frames: {}", 100 * share,
      fit.technical.empty() ? tracking::kHiddenKneeAdvice : "give --knee-from, the folder of the trial that shows it");
}

void WarnOfUnseen(const SeenShares& seen, double any, const gait::LegFitOptions& fit, Run& run) {
  constexpr double kEnough = 1 - tracking::kOftenHidden;
  if (any < kEnough)
    run.Warn("{:.0f} % of the frames show no marker: the person is out of the picture there, or in the dark",
             100 * (1 - any));
  for (const auto& [name, share] : seen)
    if (share < kEnough && name == fit.markers.knee && !fit.technical.empty() && fit.knee_trial)
      continue;  // the fit says how it was rebuilt
    else if (share < kEnough && name == fit.markers.knee)
      WarnOfHiddenKnee(1 - share, fit, run);
    else if (share < kEnough)
      run.Warn(
          "marker '{}' is seen in {:.0f} % of the frames only: look at the overlay; light, a hidden marker or a wrong "
          "name make gaps",
          name, 100 * share);
}

std::string SeenText(const SeenShares& seen) {
  std::string text;
  for (const auto& [name, share] : seen)
    text += fmt::format("{}{} {:.1f} %", text.empty() ? "seen: " : ", ", name, 100 * share);
  return text + "\n";
}

constexpr const char* kCandidatesPicture = "candidates.png";
constexpr const char* kCandidatesTable = "candidates.csv";

void WriteCandidates(const TrackRunOptions& options, const tracking::CandidateList& list, Run& run) {
  std::vector<overlay::NumberedSpot> spots;
  CsvWriter csv({"id", "frame", "x_px", "y_px", "radius_px", "first_frame", "last_frame", "moves"});
  for (const tracking::Candidate& c : list.candidates) {
    csv.AddRow(c.id, c.frame, c.position.x(), c.position.y(), c.radius_px, c.first_frame, c.last_frame, c.moves);
    spots.push_back({.id = c.id,
                     .position = c.position,
                     .radius_px = c.radius_px,
                     .in_frame = c.frame == list.frame,
                     .moves = c.moves,
                     .path = c.path});
  }
  csv.Write(run.Result(kCandidatesTable));
  cv::Mat luma = video::ReadLuma(options.video, list.frame, options.track.reader);
  if (options.anonymise) overlay::BlurWhole(luma);  // the spots have no names yet
  video::WriteImage(run.Result(kCandidatesPicture), overlay::DrawNumberedSpots(luma, spots));
}

void WarnOfVideo(const video::VideoInfo& video, const gait::LegView& view, Run& run) {
  if (video.irregular_stamps)
    run.Warn("the frames' time stamps are irregular ({} to {} s apart); each frame's own stamp is used",
             SignificantText(video.shortest_interval_s, 4), SignificantText(video.longest_interval_s, 4));
  if (video.repaired_stamps > 0)
    run.Warn("{} frames have no time stamp: each is put one frame's duration after the one before",
             video.repaired_stamps);
  if (video.HasWidePixels())
    run.Warn(
        "the video's pixels are {} times as wide as high, as its file says: positions in px refer to the picture as "
        "stored, lengths and angles {}",
        SignificantText(video.pixel_aspect, 3),
        view.camera_from_plane || view.homography ? "of the plane that was calibrated with such pictures"
                                                  : "of the picture stretched by that");
}

// What is exported: positions in the picture and in the plane.
struct ExportedMarkers {
  motion::MarkerRecording tracks, trajectory;
};

ExportedMarkers MarkersToExport(const TrackRunOptions& options, const gait::LegFitResult& fit,
                                const motion::MarkerRecording& tracks, const gait::LegView& view) {
  if (options.smoothed) return {EstimatesInPicture(fit, view), fit.trajectory};
  return {motion::Measurements(tracks), fit.measured};
}

// In mm where there is a scale; `fit` is null without a leg. Comes last: a format that cannot hold the trial takes
// nothing else with it.
void Export(const TrackRunOptions& options, const video::VideoInfo& video, const gait::LegView& view,
            const ExportedMarkers& markers, const gait::LegFitResult* fit, const Json& results, Run& run) {
  if (options.exports.empty()) return;
  exchange::ExportedTrial trial{
      exchange::PointsFromMarkers(markers.trajectory.unit == motion::LengthUnit::kMm ? markers.trajectory
                                                                                     : markers.tracks),
      exchange::PointsFromMarkers(markers.tracks)};
  if (fit) {
    trial.motion = &fit->motion;
    trial.leg = motion::NearLeg(fit->motion.facing);
    trial.points.events = exchange::PointEvents(fit->events, trial.leg);
  }
  trial.image.video =
      exchange::SourceVideo{std::filesystem::absolute(options.video).string(), video.width, video.height};
  if (!view.camera && !view.homography && !video.HasWidePixels()) trial.image.mm_per_px = view.mm_per_px;
  std::optional<Error> first_error;
  for (const std::string& format : options.exports) {
    try {
      exchange::ExportTrial(format, run.Result(exchange::ExportName(format, options.video.stem().string())), trial);
    } catch (const Error& error) {
      if (!first_error) first_error = error;
    }
  }
  if (!first_error) return;
  run.WriteFailedSummary(results, first_error->what());
  throw *first_error;
}

void WriteOverlay(const TrackRunOptions& options, overlay::OverlayContent content, Run& run) {
  if (!options.overlay) return;
  std::optional<overlay::HeadBlur> blur;
  if (options.anonymise) {
    content.anonymise = &blur.emplace(content.tracks);
    if (!blur->IsKnown())
      run.Warn(
          "the subject never stands in this recording, so the head's position is unknown: overlay.mp4 is blurred as a "
          "whole");
  }
  overlay::OverlayOptions overlay;
  overlay.quiet = run.Quiet();
  overlay.reader = options.track.reader;
  overlay::WriteOverlayVideo(options.video, content, overlay, run.Result("overlay.mp4"));
}

// Where the markers were, and nothing more; returns their positions in the plane.
motion::MarkerRecording WritePoints(const TrackRunOptions& options, const tracking::TrackResult& tracked,
                                    const gait::LegView& view, const gait::RollingShutter& shutter,
                                    const std::string& note, Run& run) {
  motion::MarkerRecording trajectory = gait::InPlane(gait::AtFrameTimes(tracked.recording, shutter), view);
  motion::WriteMarkerCsv(run.Result("tracks.csv"), tracked.recording);
  if (trajectory.unit == motion::LengthUnit::kMm)
    motion::WriteTrajectoryCsv(run.Result("trajectory.csv"), trajectory, motion::Measurements(trajectory));
  const std::string title = options.video.filename().string() + (note.empty() ? "" : ": " + note);
  DrawPngAndSvg("track", run, figure::DrawTracksFigure, trajectory, title);
  WriteOverlay(options, {.tracks = tracked.recording, .note = note}, run);
  return trajectory;
}

// What is up in the plane, where it is not the plane's own y.
std::optional<Eigen::Vector2d> UpInPlane(const TrackRunOptions& options, const tracking::TrackResult& tracked,
                                         const gait::LegView& view, const Warn& warn) {
  if (options.vertical_from_leg) {
    const Eigen::Vector2d up = gait::UpFromStandingLeg(tracked.recording, view);
    warn(fmt::format(
        "the vertical is that of the leg as it stands, {:.1f}° clockwise from the picture's (or the plane's) own; a "
        "leg that stands leans by some 3°, and the segments' angles with it, not the knee's",
        DegreesFromRadians(std::atan2(up.x(), up.y()))));
    return up;
  }
  if (!options.vertical) return std::nullopt;
  const auto [x1, y1, x2, y2] = *options.vertical;
  return gait::UpFromPlumbLine(view, {x1, y1}, {x2, y2}, tracked.up_px);
}

gait::LegFitOptions FitOptions(const TrackRunOptions& options, const tracking::TrackResult& tracked,
                               const gait::LegView& view, bool quiet, const Warn& warn) {
  gait::LegFitOptions fit = options.fit;
  fit.quiet = quiet;
  fit.known_sigmas = true;
  fit.lasting_share = tracked.sigma.lasting_share;
  fit.vertical_option = "--vertical";
  fit.facing_option = "lake gait --facing";
  fit.names_option = "--seed";
  fit.unit_question = [](const std::string& unit) {
    return fmt::format("are --scale, the board or the plane's --points in {}? They are in mm",
                       unit.empty() ? "another unit" : unit);
  };
  fit.ways_out = "leave them out (--start, --end) or say where the markers are (--seed, --corrections)";
  if (const std::optional<Eigen::Vector2d> up = UpInPlane(options, tracked, view, warn)) fit.up = *up;
  gait::ReadKneeFrom(fit);
  return fit;
}

// The fit; where there is none, what was tracked is kept, marked as not fitted, so that one can see why.
gait::LegFitResult FitOrKeep(const TrackRunOptions& options, const tracking::TrackResult& tracked,
                             const gait::LegView& view, const gait::RollingShutter& shutter,
                             const gait::LegFitOptions& fit_options, const Json& results, Run& run) {
  try {
    gait::LegFitResult fit = gait::FitLeg(gait::AtFrameTimes(tracked.recording, shutter), view, fit_options);
    gait::MovementOptions movement = fit_options.movement;
    movement.walking.contacts = ContactsOf(options, {}, run);
    gait::ChooseMovement(movement, fit);
    return fit;
  } catch (const Error& error) {
    WritePoints(options, tracked, view, shutter, "no leg fitted", run);
    const Error failure =
        Fail("{}; what was tracked, without a leg, is in {}", error.what(), run.FolderIfFailed().string());
    run.WriteFailedSummary(results, failure.what());
    throw failure;
  }
}

Json RunLeg(const TrackRunOptions& options, const tracking::TrackResult& tracked, const gait::LegView& view,
            const gait::RollingShutter& shutter, Json results, Run& run) {
  const gait::LegFitOptions fit_options = FitOptions(options, tracked, view, run.Quiet(), WarnThrough(run));
  gait::LegFitResult fit = FitOrKeep(options, tracked, view, shutter, fit_options, results, run);
  if (options.events) results.update(CorrectEventsBy(*options.events, fit));
  SetNeutral(options, {}, {}, fit_options, run, fit);
  WarnOfFit(fit, run);
  motion::MarkerRecording tracks = fit.tracks;
  if (shutter.readout_s != 0) TakeSeenPositions(tracked.recording, tracks);
  motion::WriteMarkerCsv(run.Result("tracks.csv"), tracks);
  if (fit.trajectory.unit == motion::LengthUnit::kMm)
    motion::WriteTrajectoryCsv(run.Result("trajectory.csv"), fit.trajectory, fit.measured);
  run.Report(WriteMovement(fit, fit_options.markers, options.budget, options.person, options.reference, results, run));
  DrawPngAndSvg("track", run, figure::DrawLegFigure, fit, figure::OtherAngle{});
  const motion::MarkerRecording estimates = EstimatesInPicture(fit, view);
  const bool comparable = shutter.readout_s == 0;  // else what was seen is of another time than the estimate
  WriteOverlay(options, {tracks, &fit.motion, &fit.events, comparable ? &estimates : nullptr}, run);
  results.update(gait::LegFitJson(fit));
  results[exchange::kLegKey] = ToString(motion::NearLeg(fit.motion.facing));
  LearnKnee(fit, fit_options, {}, results, run);
  WriteMeasures(fit.measured, options.measures, results, run);
  Export(options, tracked.video, view, MarkersToExport(options, fit, tracks, view), &fit, results, run);
  return results;
}

Json RunPoints(const TrackRunOptions& options, const tracking::TrackResult& tracked, const gait::LegView& view,
               const gait::RollingShutter& shutter, Json results, Run& run) {
  const std::vector<std::string>& names = options.track.names;
  constexpr std::size_t kFew = 3;
  std::vector<gait::MarkerMeasure> measures = options.measures;
  if (measures.empty() && names.size() <= kFew) measures = gait::UsualMeasures(names);
  if (measures.empty()) {
    run.Warn("ankle, knee and hip are not all among the markers: no leg is fitted, gaps are not filled");
    if (std::ranges::count(names, "ankle") > 0 && std::ranges::count(names, "hip") > 0)
      WarnOfHiddenKnee(1, options.fit, run);
  }
  const motion::MarkerRecording trajectory = WritePoints(options, tracked, view, shutter, "", run);
  WriteMeasures(trajectory, measures, results, run);
  Export(options, tracked.video, view, {tracked.recording, trajectory}, nullptr, results, run);
  return results;
}

// The markers with their names; where they cannot be named, what was found is shown to the one who can.
tracking::TrackResult TrackOrShow(const TrackRunOptions& options, const tracking::TrackOptions& track, Run& run) {
  try {
    tracking::TrackResult tracked = tracking::TrackMarkers(options.video, track);
    malloc_trim(0);  // what held pictures and tracklets is free, before the leg fit takes as much
    return tracked;
  } catch (const tracking::NamingError& error) {
    if (error.List().candidates.empty()) throw;
    WriteCandidates(options, error.List(), run);
    const Error failure = Fail("{}; {} shows what was found, numbered: --seed knee=#7 takes number 7", error.what(),
                               (run.FolderIfFailed() / kCandidatesPicture).string());
    run.WriteFailedSummary(Json::object(), failure.what());
    throw failure;
  }
}

Json RunList(const TrackRunOptions& options, const tracking::TrackOptions& track, Run& run) {
  const tracking::CandidateList list = tracking::FindCandidates(options.video, track);
  if (list.candidates.empty())
    throw Fail("{}: nothing like a marker was found; is the detector the right one (--detector, --polarity)?",
               options.video.string());
  WriteCandidates(options, list, run);
  const auto moving =
      std::count_if(list.candidates.begin(), list.candidates.end(), [](const auto& c) { return c.moves; });
  run.Report("{} candidate markers, {} of them moving: candidates.png, candidates.csv\n", list.candidates.size(),
             moving);
  return {{"candidates", {{"found", list.candidates.size()}, {"moving", moving}, {"frame", list.frame}}}};
}

// What can be known to be wrong before the video is read.
void CheckOptions(const TrackRunOptions& options) {
  options.track.Check();
  gait::CheckMarkers(options.measures, options.track.names);
  for (const auto& [name, depth] : options.depths)
    if (std::find(options.track.names.begin(), options.track.names.end(), name) == options.track.names.end())
      throw UsageError("--depth {}: not one of the markers ({})", name, fmt::join(options.track.names, ", "));
  if (options.smoothed && !HasLeg(options))
    throw UsageError("--smoothed: without ankle, knee and hip among the markers nothing is fitted");
  if (const auto& line = options.vertical; line && std::hypot((*line)[0] - (*line)[2], (*line)[1] - (*line)[3]) < 1)
    throw UsageError("--vertical: the ends of a plumb line must be at least 1 px apart");
  const auto tracks = [&](const char* name) {
    return std::find(options.track.names.begin(), options.track.names.end(), name) != options.track.names.end();
  };
  if (options.anonymise && !options.list && (!HasLeg(options) || !(tracks("waist") || tracks("shoulder"))))
    throw UsageError(
        "--anonymise: takes ankle, knee, hip and waist or shoulder among the markers, to know where the head is");
  if (options.events && !HasLeg(options))
    throw UsageError("--events: without ankle, knee and hip among the markers there are no rises");
  for (const auto& file : {options.corrections, options.events})
    if (file && !std::filesystem::exists(*file)) throw Fail("{}: no such file", file->string());
}

// Whether --start and --end leave a frame of this time.
bool IsLookedAt(const video::VideoReaderOptions& reader, double time_s) {
  constexpr double kRounding_s = 1e-6;
  return !(reader.start_s && time_s < *reader.start_s - kRounding_s) &&
         !(reader.end_s && time_s > *reader.end_s + kRounding_s);
}

// Frames that the container knows not to be there, or not to be looked at.
void CheckCorrectedFrames(const std::vector<motion::Correction>& corrections, const video::VideoReaderOptions& reader,
                          const std::vector<double>& time_s) {
  for (const motion::Correction& correction : corrections) {
    const auto frame = static_cast<std::size_t>(correction.frame);
    if (frame >= time_s.size())
      throw Fail("{}: frame {} is not in the recording; its frames are 0 to {}", correction.where, frame,
                 static_cast<std::int64_t>(time_s.size()) - 1);
    const double t = time_s[frame];
    if (!IsLookedAt(reader, t))
      throw Fail("{}: frame {} at {:.3f} s is outside what --start and --end leave", correction.where, frame, t);
  }
}

bool Exports(const TrackRunOptions& options, const char* format) {
  return std::find(options.exports.begin(), options.exports.end(), format) != options.exports.end();
}

// Events beside what the container knows to be there and is looked at.
void CheckEventTimes(const std::vector<motion::EventCorrection>& events, const video::VideoReaderOptions& reader,
                     const std::vector<double>& stamps) {
  std::vector<std::int64_t> frame;
  std::vector<double> time_s;
  for (std::size_t i = 0; i < stamps.size(); ++i)
    if (IsLookedAt(reader, stamps[i])) {
      frame.push_back(static_cast<std::int64_t>(i));
      time_s.push_back(stamps[i]);
    }
  if (!frame.empty()) motion::CheckAreInside(events, frame, time_s);
}

// What the frames' stamps tell before any is decoded.
void CheckStamps(const TrackRunOptions& options, const std::vector<motion::Correction>& corrections,
                 const std::vector<motion::EventCorrection>& events) {
  video::VideoReaderOptions whole = options.track.reader;
  whole.start_s = whole.end_s = std::nullopt;
  if (!corrections.empty() || !events.empty())
    if (const auto time_s = video::StampsInContainer(options.video, whole)) {
      CheckCorrectedFrames(corrections, options.track.reader, *time_s);
      CheckEventTimes(events, options.track.reader, *time_s);
    }
  if (Exports(options, "c3d"))
    if (const auto time_s = video::StampsInContainer(options.video, options.track.reader); time_s && time_s->size() > 1)
      exchange::CheckC3dTimes(options.video, *time_s);
}

// Everything that this run may write; so that nothing of the user's is in the way after minutes of tracking.
std::vector<std::string> ResultNames(const TrackRunOptions& options) {
  if (options.list) return {"summary.json", kCandidatesTable, kCandidatesPicture};
  std::vector<std::string> names = LegResultNames("track");
  names.insert(names.end(), {kCandidatesTable, kCandidatesPicture});
  if (options.overlay) names.push_back("overlay.mp4");
  for (const std::string& format : options.exports)
    names.push_back(exchange::ExportName(format, options.video.stem().string()));
  return names;
}

// A repeated frame shows an earlier time: a position in it would be one of a wrong time.
void CheckNotRepeated(const std::vector<motion::Correction>& corrections, const tracking::FrameTimes& times) {
  for (const motion::Correction& correction : corrections)
    if (correction.sample.IsKnown() &&
        std::binary_search(times.repeated.begin(), times.repeated.end(), correction.frame))
      throw Fail("{}: frame {} repeats the picture before it and is no measurement; correct that one instead",
                 correction.where, correction.frame);
}

// In which directions of the picture up may be. Of a line that lies flatter than it stands, either end may be the upper
// one, by the leg.
void SetUps(const TrackRunOptions& options, tracking::TrackOptions& track) {
  if (options.vertical_from_leg) track.other_ups_px = {{1, 0}, {0, 1}, {-1, 0}};
  if (!options.vertical) return;
  const auto [x1, y1, x2, y2] = *options.vertical;
  const Eigen::Vector2d line(x1 - x2, y1 - y2);
  track.up_px = line.y() < 0 ? line : Eigen::Vector2d(-line);
  if (std::abs(line.x()) > std::abs(line.y())) track.other_ups_px = {-track.up_px};
}

double ReadoutOf(const TrackRunOptions& options, const std::optional<camera::CameraProfile>& profile) {
  if (options.readout_s) return *options.readout_s;
  return profile ? profile->readout_s : 0;
}

}  // namespace

TrackFit FitTracked(const TrackRunOptions& options, const tracking::TrackResult& tracked) {
  TrackFit result;
  const Warn warn = [&result](const std::string& text) { result.warnings.push_back(text); };
  const std::optional<camera::CameraProfile> profile = ReadCamera(options, tracked.video);
  const gait::LegView view = ViewOf(options, tracked.video, profile, warn);
  const gait::RollingShutter shutter =
      gait::ShutterOf(ReadoutOf(options, profile), tracked.video.width, tracked.video.height,
                      tracked.video.rotation_deg, tracked.video.mirrored);
  const motion::MarkerRecording at_frames = gait::AtFrameTimes(tracked.recording, shutter);
  result.tracks = tracked.recording;
  if (!HasLeg(options)) {
    result.in_plane = gait::InPlane(at_frames, view);
    return result;
  }
  result.leg = gait::FitLeg(at_frames, view, FitOptions(options, tracked, view, true, warn));
  gait::ChooseMovement(options.fit.movement, *result.leg);
  result.warnings.insert(result.warnings.end(), result.leg->warnings.begin(), result.leg->warnings.end());
  result.tracks = result.leg->tracks;
  result.in_plane = result.leg->measured;
  result.estimates = EstimatesInPicture(*result.leg, view);
  if (shutter.readout_s != 0) TakeSeenPositions(tracked.recording, result.tracks);
  return result;
}

void Describe(TrackRunOptions& o, OptionList& options) {
  options.AddOperand("video", o.video, "Video, or image sequence as frames/%05d.png")
      .Required()
      .IsPath(Option::Path::kVideo);
  Describe(o.track, options);
  Describe(static_cast<gait::PictureScale&>(o), options);
  const auto set_vertical = [&o](const OptionTexts& texts, const std::string& said) {
    o.vertical_from_leg = texts == OptionTexts{"auto"};
    if (!o.vertical_from_leg) OptionField<decltype(o.vertical)>::Set(texts, said, o.vertical);
  };
  options.AddCustom("vertical", "A plumb line in the picture, in any direction; auto: as the leg stands", set_vertical)
      .Unit("px")
      .Key("vertical")
      .Value("X1,Y1,X2,Y2|auto")
      .SplitAtCommas()
      .Otherwise("the picture's own up, or the plane's y");
  options.Add("readout", o.readout_s, "Time in which a rolling shutter reads the picture from top to bottom")
      .Unit("s")
      .NotNegative()
      .Otherwise("the camera file's, else 0");
  gait::DescribeDepths(o.depths, options);
  Describe(o.fit, options);
  options.Add("corrections", o.corrections,
              "frame,marker,x_px,y_px rows that overrule the detector; empty: not visible");
  gait::DescribeEvents(o.events, options);
  options.Add("overlay", o.overlay, "Write overlay.mp4").WithNegation();
  options.Add("anonymise", o.anonymise,
              "Blur the subject's head in overlay.mp4, and the picture behind candidates.png");
  options
      .Add("export", o.exports, fmt::format("Also write the trial as {}", fmt::join(exchange::ExportFormats(), ", ")))
      .Value("FORMAT,...");
  options.Add("list", o.list,
              "Only find and draw the candidate markers, without naming them: candidates.png, candidates.csv");
  options.Add("smoothed", o.smoothed, "Export the fit's estimates, not the measurements");
  Describe(o.person, options);
  Describe(o.measures, options);
  Describe(o.budget, options);
  options.Check([&o](const OptionList&) { gait::AddTechnical(o.fit.technical, o.track.names); });
  Describe(static_cast<FurtherInputs&>(o), options);
}

std::vector<InputFile> InputsOf(const TrackRunOptions& options) {
  std::vector<InputFile> inputs = {{video::FilesOfVideo(options.video), "video"}};
  if (options.camera) inputs.push_back({*options.camera, "camera"});
  if (options.corrections) inputs.push_back({*options.corrections, "corrections"});
  if (options.events) inputs.push_back({*options.events, "events"});
  if (options.fit.knee_trial) inputs.push_back({gait::LearntKneeFile(*options.fit.knee_trial), "knee from"});
  for (InputFile& input : InputsOf(static_cast<const FurtherInputs&>(options))) inputs.push_back(std::move(input));
  return inputs;
}

Json RunTrack(const TrackRunOptions& options, Run& run) {
  CheckOptions(options);
  CheckFiles(options);
  const video::VideoInfo video = video::VideoReader::Open(options.video, options.track.reader)->Info();
  run.AddInputs(InputsOf(options));
  const std::optional<camera::CameraProfile> profile = ReadCamera(options, video);
  const gait::LegView view = ViewOf(options, video, profile, WarnThrough(run));
  exchange::CheckExportFormats(options.exports, gait::PlaneUnit(view) == motion::LengthUnit::kMm, HasLeg(options));
  std::vector<motion::Correction> corrections;
  if (options.corrections)
    corrections = motion::ReadCorrections(*options.corrections, options.track.names, video.width, video.height);
  std::vector<motion::EventCorrection> events;
  if (options.events) events = motion::ReadEventCorrections(*options.events);
  CheckStamps(options, corrections, events);
  run.Begin(ResultNames(options));

  tracking::TrackOptions track_options = options.track;
  track_options.quiet = run.Quiet();
  track_options.metric_from_px = [&view](const Eigen::Vector2d& px) { return gait::PlaneFromRecorded(view, px, 0); };
  SetUps(options, track_options);
  if (options.list) return RunList(options, track_options, run);
  tracking::TrackResult tracked = TrackOrShow(options, track_options, run);
  // Only now, as a video that cannot be tracked is refused in one line.
  if (profile)
    for (const std::string& warning : profile->warnings) run.Warn(warning);
  WarnOfUnit(view, options.camera.has_value(), run);
  WarnOfVideo(tracked.video, view, run);
  for (const std::string& warning : tracking::Warnings(tracked.times, tracked.recording.frame)) run.Warn(warning);
  CheckNotRepeated(corrections, tracked.times);
  motion::ApplyCorrections(corrections, tracked.recording);
  const double readout_s = ReadoutOf(options, profile);
  const gait::RollingShutter shutter =
      gait::ShutterOf(readout_s, video.width, video.height, video.rotation_deg, video.mirrored);

  const auto [seen, any] = SeenSharesOf(tracked.recording, tracked.times.repeated.size());
  WarnOfUnseen(seen, any, options.fit, run);
  run.Report(SeenText(seen));
  Json results = {{"video", VideoJson(tracked)}, {"tracking", TrackingJson(tracked)}, {"seen", Json::object()}};
  for (const auto& [name, share] : seen) results["seen"][name] = share;
  results["video"]["readout_s"] = readout_s;
  return HasLeg(options) ? RunLeg(options, tracked, view, shutter, results, run)
                         : RunPoints(options, tracked, view, shutter, results, run);
}

}  // namespace lake::commands
