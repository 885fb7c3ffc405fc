#include "session.h"

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "lake/compare/registration.h"
#include "lake/core/error.h"
#include "lake/core/fault_text.h"
#include "lake/core/interrupt.h"
#include "lake/tracking/naming.h"
#include "lake/tracking/recording_quality.h"
#include "lake/tracking/recording_verdicts.h"
#include "trial.h"

namespace lake::live {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Eigen::Vector2d;

namespace {

const Vector2d kUpInPlane = Vector2d::UnitY();

std::vector<std::string> TrackHeader(const std::vector<std::string>& names) {
  std::vector<std::string> header = {"frame", "time_s"};
  for (const std::string& name : names)
    for (const char* column : {"_x_px", "_y_px", "_sigma_px", "_status"}) header.push_back(name + column);
  return header;
}

std::optional<Vector2d> PlaceIn(const motion::MarkerRecording& reported, std::string_view name) {
  const motion::MarkerTrack* track = reported.Find(name);
  if (!track || track->samples.empty() || !track->samples.back().IsKnown()) return std::nullopt;
  return track->samples.back().position;
}

// From one row on, to another.
motion::MarkerRecording Rows(const motion::MarkerRecording& all, std::size_t first, std::size_t last) {
  const auto cut = [&](const auto& column) {
    return std::decay_t<decltype(column)>(column.begin() + static_cast<std::ptrdiff_t>(first),
                                          column.begin() + static_cast<std::ptrdiff_t>(last));
  };
  motion::MarkerRecording part;
  part.unit = all.unit;
  part.frame = cut(all.frame);
  part.time_s = cut(all.time_s);
  part.markers.reserve(all.markers.size());
  for (const motion::MarkerTrack& track : all.markers) part.markers.push_back({track.name, cut(track.samples)});
  return part;
}

// A leg fit takes a core for some tenths of a second: the frames that come meanwhile, and the browser that shows them,
// come first. Linux does this to the calling thread alone, and to those that it starts.
void GiveWay() {
  constexpr int kNiceness = 10;
  setpriority(PRIO_PROCESS, 0, kNiceness);
}

}  // namespace

bool RiseWatch::Add(double time_s, double knee_deg) {
  constexpr double kStill_s = 0.5, kStill_deg = 3;
  constexpr double kExtension_deg = 30;  // the least of a rise, as the events have it
  constexpr double kAgain_s = 0.5;       // a rest that was too short is longer then
  constexpr int kMostLooks = 8;
  last_.emplace_back(time_s, knee_deg);
  while (last_.front().first < time_s - kStill_s) last_.pop_front();
  most_deg_ = std::max(most_deg_, knee_deg);
  least_deg_ = std::min(least_deg_, knee_deg);
  const bool sits_down = knee_deg > least_deg_ + kExtension_deg;
  if (looks_ > 0 && sits_down) {
    looks_ = 0;
    most_deg_ = least_deg_ = knee_deg;
  }
  const auto [least, most] = std::ranges::minmax(last_, {}, &std::pair<double, double>::second);
  const bool is_still = most.second - least.second < kStill_deg && time_s - last_.front().first > 0.8 * kStill_s;
  if (!is_still || knee_deg > most_deg_ - kExtension_deg || looks_ == kMostLooks) return false;
  if (looks_ > 0 && time_s - looked_s_ < kAgain_s) return false;
  if (looks_ == 0) least_deg_ = knee_deg;
  ++looks_, looked_s_ = time_s;
  return true;
}

Session::Session(const LiveRunOptions& options, fs::path programs, Run& run)
    : options_(options), programs_(std::move(programs)), run_(run), by_hand_(options.seeds) {
  gait::ReadKneeFrom(options_.fit);
  if (const auto& learnt = options_.fit.knee_from)
    gait::AddTechnical({{learnt->segment, learnt->markers}}, options_.markers);
  CheckMarkers();
  const fs::path recording = run.Folder() / kVideo;
  for (const fs::path& file : {recording, video::UnfinishedRecording(recording)})
    if (fs::exists(file))
      throw Fail("{}: holds a recording; choose another folder with -o, or finish that one: lake live {}",
                 run.Folder().string(), run.Folder().string());
  run.Begin({kVideo, kTracks, kRises, kMoves, kLive});
  run.Publish();  // what is recorded lies in its place from the first frame on
  options_.stream.is_held = IsHeld();
  stream_ = std::make_unique<video::LiveStream>(options_.input, options_.stream, recording);
  video_ = stream_->Info();
  ReadPlane();
  WarnOfTolerance();
  track_.names = options_.markers;
  track_.seeds = options_.seeds;
  track_.polarity = options_.polarity;
  track_.crop = options_.crop;
  track_.metric_from_px = [this](const Vector2d& px) { return gait::PlaneFromRecorded(view_, px, 0); };
  const Vector2d middle(0.5 * video_.width, 0.5 * video_.height);
  track_.mm_per_px = gait::PlaneUnitsPerRecorded(view_, track_.metric_from_px(middle), 0);
  tracker_.emplace(track_, video_);
  tracks_table_.emplace(run.Result(kTracks), TrackHeader(options_.markers));
  rises_table_.emplace(run.Result(kRises),
                       std::vector<std::string>{"rise", "onset_s", "standing_s", "moves", "joint_x_mm", "joint_y_mm",
                                                "noise_sd_x_mm", "noise_sd_y_mm", "remainder_mm"});
  moves_table_.emplace(run.Result(kMoves), std::vector<std::string>{"move", "time_s", "frame"});
  SaveLive();
}

Session::~Session() {
  Abandon();
  if (tracker_thread_.joinable()) tracker_thread_.join();
  if (analyst_thread_.joinable()) analyst_thread_.join();
}

void Session::CheckMarkers() const {
  const auto has = [&](std::string_view name) {
    return std::ranges::find(options_.markers, name) != options_.markers.end();
  };
  for (const std::string_view name : {"ankle", "knee", "hip"})
    if (!has(name) && !(options_.fit.knee_from && name == "knee"))
      throw UsageError("--markers: '{}' is missing; the leg's own knee must be seen, or rebuilt (--knee-from)", name);
  if (!has(options_.joint))
    throw UsageError("--joint {}: is not one of the markers ({})", options_.joint, fmt::join(options_.markers, ", "));
  for (const char* of_leg : {"ankle", "knee", "hip", "waist"})
    if (options_.joint == of_leg)
      throw UsageError("--joint {}: is the leg's own marker; name that at the exoskeleton's joint", of_leg);
  for (const tracking::MarkerSeed& seed : options_.seeds) {
    if (!has(seed.name)) throw UsageError("--seed {}: not one of the markers", seed.name);
    if (seed.candidate) throw UsageError("--seed {}: give its place, X,Y@FRAME", seed.name);
  }
}

void Session::ReadPlane() {
  std::optional<camera::CameraProfile> profile;
  if (options_.camera) {
    profile = camera::ReadCameraProfile(*options_.camera);
    for (const std::string& warning : profile->warnings) run_.Warn(warning);
    const auto scaled = camera::CameraAtSize(profile->camera, video_.width, video_.height);
    if (!scaled)
      camera::CheckResolution(profile->camera, *options_.camera, video_.width, video_.height, options_.input);
    profile->camera = *scaled;
    readout_s_ = profile->readout_s;
  }
  gait::PictureScale picture = options_;
  picture.pixel_aspect = video_.pixel_aspect;
  view_ = gait::MakeView(picture, profile, {}, [this](const std::string& text) { run_.Warn(text); });
  if (gait::PlaneUnit(view_) == motion::LengthUnit::kPx)
    throw Fail("no lengths in mm: give a camera file with a sagittal plane (--camera), --scale or --plane-points");
}

// Where the joint is seen is not known yet: as if a quarter of the picture off its middle.
void Session::WarnOfTolerance() {
  RiseOffset at_knee;
  const Vector2d aside(0.25 * video_.width, 0.5 * video_.height);
  if (const auto sight = gait::SightOf(view_))
    at_knee.parallax_sd_mm = compare::JointDepthDeviationMm(gait::DepthOf(*sight, options_.joint), {}) *
                             sight->Slope(gait::PlaneFromRecorded(view_, aside, 0)).cwiseAbs();
  const double least_mm = LeastUncertaintyMm(at_knee);
  if (options_.tolerance_mm >= least_mm) return;
  run_.Warn(fmt::format(
      "--tolerance {:g} mm: after however many rises the joint's place is known to ± {:.1f} mm at best where "
      "it is seen a quarter of the picture off the middle; how far its marker stands proud of the knee's "
      "would narrow that: --depth {}=MM±SD",
      options_.tolerance_mm, least_mm, options_.joint));
}

void Session::Start() {
  analyst_thread_ = std::thread([this] { Analyse(); });
  tracker_thread_ = std::thread([this] { Work(); });
}

void Session::Abandon() {
  is_abandoned_ = true;
  if (stream_) stream_->Stop();
  changed_.notify_all();
}

void Session::Finish() {
  if (tracker_thread_.joinable()) tracker_thread_.join();
  if (failure_) std::rethrow_exception(failure_);
}

void Session::Work() {
  try {
    TrackAll();
    if (analyst_thread_.joinable()) analyst_thread_.join();  // looks once more, now at all of it
    FinishTrial();
  } catch (...) {
    failure_ = std::current_exception();
  }
  {
    const std::lock_guard lock(mutex_);
    has_ended_ = true;  // also where the frames ended in a failure
    phase_ = failure_ ? Phase::kFailed : Phase::kDone;
    if (failure_) try {
        std::rethrow_exception(failure_);
      } catch (const std::exception& error) {
        failure_text_ = FaultText(error);
      }
  }
  changed_.notify_all();
  is_over_ = true;
}

void Session::TrackAll() {
  try {
    for (video::LiveFrame live; stream_->Read(live);) {
      AddFrame(live);
      changed_.notify_all();
    }
  } catch (const std::exception& error) {
    BreakOff(FaultText(error));
  }
  stream_->Finish();
  const std::lock_guard lock(mutex_);
  end_ = stream_->End();
  phase_ = Phase::kFinishing;
  has_ended_ = true;
  tracks_table_->Flush();
  SaveLive();
}

// What ends the tracking does not cost the recording.
void Session::BreakOff(const std::string& why) {
  stream_->Stop();
  stream_->Finish();
  throw Fail("{}; the recording is whole: lake live {}", why, run_.Folder().string());
}

void Session::AddFrame(const video::LiveFrame& live) {
  const std::lock_guard lock(mutex_);
  video_ = stream_->Info();
  tracker_->Add(live.frame);
  samples_.push_back(MeasureFrame());
  if (watch_.Add(live.frame.time_s, std::abs(samples_.back().knee_deg))) is_rise_due_ = true;
  WriteTrackRow();
  constexpr std::size_t kKept = 16;  // more than a page is ever behind
  pictures_.push_back(live);
  if (pictures_.size() > kKept) pictures_.pop_front();
  latencies_ms_.push_back(std::chrono::duration<double, std::milli>(Clock::now() - live.arrived).count());
}

std::optional<Vector2d> Session::InPlane(std::string_view marker, const Vector2d& px) const {
  try {
    return gait::PlaneFromRecorded(view_, px, view_.Depth(std::string(marker)));
  } catch (const Error&) {
    return std::nullopt;
  }
}

Session::Sample Session::MeasureFrame() const {
  const motion::MarkerRecording& reported = tracker_->Reported();
  Sample sample{.time_s = reported.time_s.back()};
  gait::LegPoints points;
  std::optional<Vector2d> joint;
  const auto in_plane = [&](std::string_view name) -> std::optional<Vector2d> {
    const std::optional<Vector2d> px = PlaceIn(reported, name);
    return px ? InPlane(name, *px) : std::nullopt;
  };
  points.ankle = in_plane("ankle");
  points.knee = in_plane("knee");
  points.hip = in_plane("hip");
  if (!points.knee && options_.fit.knee_from)
    if (const auto carried = CarriedKnee(reported)) points.knee = carried->in_plane;
  if (!points.ankle || !points.knee) return sample;
  const motion::Facing facing = facing_.value_or(motion::Facing::kRight);
  const motion::LegSample leg = gait::MakeLegSample(points, facing, kUpInPlane);
  sample.knee_deg = facing_ ? leg.knee_deg : std::abs(leg.knee_deg);
  if (!facing_ || !(joint = in_plane(options_.joint))) return sample;
  const Eigen::Matrix2d shank = compare::AxesAlong(leg.ak);
  sample.joint_mm = shank.transpose() * gait::LegFromPlane(*joint - *points.knee, facing, kUpInPlane) - MarkerAt();
  if (const std::optional<JointPlace> place = Place()) {
    const Vector2d target = *joint - gait::PlaneFromLeg(shank * place->offset_mm, facing, kUpInPlane);
    sample.from_px = PlaceIn(reported, options_.joint);
    sample.to_px = gait::RecordedFromPlane<double>(view_, target, view_.Depth(options_.joint));
  }
  return sample;
}

std::optional<gait::CarriedKnee> Session::CarriedKnee(const motion::MarkerRecording& frames) const {
  const motion::MarkerRecording last = Rows(frames, frames.Frames() - 1, frames.Frames());
  return gait::CarriedKneeIn(last, view_, *options_.fit.knee_from, facing_);
}

void Session::WriteTrackRow() {
  const motion::MarkerRecording& reported = tracker_->Reported();
  std::vector<std::string> cells = {fmt::format("{}", reported.frame.back()), FormatNumber(reported.time_s.back())};
  for (const motion::MarkerTrack& track : reported.markers) {
    const motion::MarkerSample& sample = track.samples.back();
    if (sample.IsKnown())
      for (const double value : {sample.position.x(), sample.position.y(), sample.sigma})
        cells.push_back(FormatNumber(value));
    else
      cells.insert(cells.end(), 3, "");
    cells.emplace_back(motion::ToString(sample.status));
  }
  tracks_table_->Row(cells);
  constexpr std::chrono::milliseconds kFlush{300};
  if (Clock::now() - flushed_ < kFlush) return;
  flushed_ = Clock::now();
  try {
    tracks_table_->Flush();
  } catch (const Error&) {
    stream_->Stop();  // its own recording will say so, too, or this at the end
  }
}

TrialPart Session::Trial() const {
  std::vector<double> onsets_s;
  onsets_s.reserve(rises_.size());
  for (const RiseOffset& rise : rises_) onsets_s.push_back(rise.onset_s);
  return PartOfTrial({.begin_s = begin_s_, .end_s = end_s_}, moves_s_, onsets_s);
}

// Of markers that lake-track cannot name by itself: where they were first measured in that part.
std::vector<std::string> Session::SeedsFrom(double start_s) const {
  std::vector<std::string> seeds;
  const motion::MarkerRecording& measured = tracker_->Measured();
  for (const motion::MarkerTrack& track : measured.markers) {
    const bool is_leg =
        measured.Find("knee") && std::ranges::find(tracking::kLegMarkers, track.name) != tracking::kLegMarkers.end();
    if (is_leg && std::ranges::find(by_hand_, track.name, &tracking::MarkerSeed::name) == by_hand_.end()) continue;
    const auto is_seen = [&](std::size_t row) {
      return track.samples[row].IsKnown() && measured.time_s[row] >= start_s;
    };
    for (std::size_t row = 0; row < measured.Frames(); ++row) {
      if (!is_seen(row)) continue;
      const Vector2d& place = track.samples[row].position;
      seeds.push_back(fmt::format("--seed={}={:.2f},{:.2f}@{}", track.name, place.x(), place.y(), measured.frame[row]));
      break;
    }
  }
  return seeds;
}

std::vector<std::string> Session::Arguments() const {
  const TrialPart part = Trial();
  std::vector<std::string> more = SeedsFrom(part.begin_s.value_or(0));
  // The recording keeps its stamps to the millisecond.
  const auto rounded = [](double time_s) { return fmt::format("{:.3f}", time_s); };
  if (part.begin_s) more.push_back("--start=" + rounded(*part.begin_s));
  if (part.end_s) more.push_back("--end=" + rounded(*part.end_s));
  return TrackArguments(options_, more);
}

void Session::FinishTrial() {
  std::vector<std::string> arguments;
  {
    const std::lock_guard lock(mutex_);
    if (tracker_->Measured().Frames() == 0) throw Fail("{}: not one frame came: {}", options_.input, end_->why);
    arguments = Arguments();
  }
  run_.ReleaseFolder();
  const auto say = [this](const std::string& line) {
    const std::lock_guard lock(mutex_);
    progress_ = line;
  };
  const auto check = [this] {
    ThrowIfInterrupted();
    if (is_abandoned_) throw Error("the trial was left as it was recorded");
  };
  check();
  TrackTrial(programs_, run_.Folder(), arguments, say, check);
  LiveDifference difference = FindDifference(tracker_->Reported(), run_.Folder());
  const std::lock_guard lock(mutex_);
  difference_ = std::move(difference);
  SaveLive();
  using Kind = video::StreamEnd::Kind;
  if (end_->kind == Kind::kDiskFull || end_->kind == Kind::kUnrecorded)
    throw Fail("{}; what was recorded until then is a trial in {}", end_->why, run_.Folder().string());
}

// ---- the analyst

void Session::Analyse() {
  GiveWay();
  constexpr std::chrono::milliseconds kPause{500};
  std::optional<Clock::time_point> named_last;
  Clock::duration naming_took{};
  while (true) {
    bool is_rise_due = false, is_naming_due = false, is_last = false;
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, kPause, [this] { return has_ended_ || is_rise_due_; });
      if (is_abandoned_) return;
      is_last = has_ended_;
      is_rise_due = std::exchange(is_rise_due_, false) || is_last;
      const bool has_rested =
          is_last || !named_last || Clock::now() - *named_last > std::max<Clock::duration>(kPause, 3 * naming_took);
      is_naming_due = tracker_->Measured().Frames() > 1 && has_rested && tracker_->IsAnyLost();
    }
    try {
      if (is_naming_due) {
        const Clock::time_point began = Clock::now();
        FindTheNames();
        named_last = Clock::now();
        naming_took = *named_last - began;
      }
      FindFacing();
      if (is_rise_due) FindTheRises();
      JudgePictures();
    } catch (const std::exception& error) {
      const std::lock_guard lock(mutex_);
      why_no_rise_ = FaultText(error);
    }
    if (is_last) return;
  }
}

void Session::FindTheNames() {
  tracking::LiveSnapshot snapshot;
  tracking::LiveTrackOptions track = track_;
  {
    const std::lock_guard lock(mutex_);
    snapshot = tracker_->Snapshot();
    track.seeds = by_hand_;
  }
  std::string why_not;
  std::vector<tracking::MarkerSeed> found;
  try {
    found = tracking::FindNames(snapshot, track);
  } catch (const Error& error) {
    why_not = error.what();
  }
  const std::lock_guard lock(mutex_);
  tracker_->TakeNames(found);
  why_not_named_ = why_not.empty() ? tracker_->WhyNoSeed() : why_not;
  if (tracker_->HasAllNames()) SaveLive();
}

void Session::FindFacing() {
  std::vector<gait::LegPoints> legs;
  {
    const std::lock_guard lock(mutex_);
    if (facing_) return;
    const motion::MarkerRecording& measured = tracker_->Measured();
    if (!measured.Find("knee")) {
      const bool is_named = tracker_->HasAllNames() && measured.Frames() > 0;
      if (const auto carried = is_named ? CarriedKnee(measured) : std::nullopt) facing_ = carried->facing;
      return;
    }
    const motion::MarkerTrack &ankle = *measured.Find("ankle"), &knee = *measured.Find("knee"),
                              &hip = *measured.Find("hip");
    for (std::size_t row = 0; row < measured.Frames(); ++row) {
      const auto place = [&](const motion::MarkerTrack& track) {
        const motion::MarkerSample& sample = track.samples[row];
        return sample.IsKnown() ? InPlane(track.name, sample.position) : std::nullopt;
      };
      const gait::LegPoints leg{.ankle = place(ankle), .knee = place(knee), .hip = place(hip), .waist = {}};
      if (leg.ankle && leg.knee && leg.hip) legs.push_back(leg);
    }
  }
  if (legs.empty()) return;
  const gait::FacingFound found = gait::FindFacing(legs);
  const std::lock_guard lock(mutex_);
  if (found.IsCertain()) facing_ = found.facing;
}

// From three seconds before the last rise that is known: what the leg fit needs of a rest.
motion::MarkerRecording Session::Window() const {
  constexpr double kBefore_s = 3, kLongest_s = 40;
  const motion::MarkerRecording& measured = tracker_->Measured();
  double from_s = rises_.empty() ? 0 : rises_.back().onset_s - kBefore_s;
  from_s = std::max(from_s, measured.time_s.back() - kLongest_s);
  std::size_t first = 0;
  const auto shows_leg = [&](std::size_t row) {
    return std::ranges::all_of(measured.markers, [&](const auto& track) { return track.samples[row].IsKnown(); });
  };
  while (first < measured.Frames() && (measured.time_s[first] < from_s || !shows_leg(first))) ++first;
  return Rows(measured, first, measured.Frames());
}

void Session::FindTheRises() {
  RiseFinding finding{.view = view_,
                      .shutter = {},
                      .video = {},
                      .joint = options_.joint,
                      .knee_from = options_.fit.knee_from,
                      .marker_at_mm = MarkerAt()};
  motion::MarkerRecording window;
  {
    const std::lock_guard lock(mutex_);
    if (!tracker_->HasAllNames()) return;
    window = Window();
    finding.video = video_;
  }
  constexpr std::size_t kFewest = 60;  // frames, from which sigmas can be calibrated
  if (window.Frames() < kFewest) return;
  finding.shutter =
      gait::ShutterOf(readout_s_, finding.video.width, finding.video.height, finding.video.rotation_deg, false);
  FoundRises found;
  try {
    found = FindRiseOffsets(std::move(window), finding);
  } catch (const Error& error) {
    found.why_last_is_left_out = error.what();
  }
  const std::lock_guard lock(mutex_);
  why_no_rise_ = found.why_last_is_left_out;
  for (const RiseOffset& rise : found.rises) {
    constexpr double kSame_s = 0.3;  // the same one, measured again
    if (!rises_.empty() && rise.standing_s < rises_.back().standing_s + kSame_s) continue;
    rises_.push_back(rise);
    rises_table_->Row({fmt::format("{}", rises_.size()), FormatNumber(rise.onset_s), FormatNumber(rise.standing_s),
                       fmt::format("{}", MovesBefore(rise.onset_s)), FormatNumber(rise.mean_mm.x()),
                       FormatNumber(rise.mean_mm.y()), FormatNumber(rise.noise_sd_mm.x()),
                       FormatNumber(rise.noise_sd_mm.y()), FormatNumber(rise.remainder_mm)});
    rises_table_->Flush();
    SaveLive();
  }
}

// Of what lake check judges: that which a recording under way shows.
void Session::JudgePictures() {
  constexpr std::array kJudged = {"all_seen_share",      "knee_hidden_share", "radius_px",
                                  "contrast_over_noise", "saturated_share",   "blur_px",
                                  "frame_rate_hz",       "repeated_frames",   "dropped_frames"};
  constexpr std::array kOfMarkers = {"radius_px", "contrast_over_noise", "saturated_share", "blur_px"};
  tracking::RecordingCheck check;
  std::vector<tracking::Tracklet> named;
  std::optional<tracking::ImageFigures> image;
  {
    const std::lock_guard lock(mutex_);
    const motion::MarkerRecording& measured = tracker_->Measured();
    constexpr std::size_t kLooked = 300;  // frames
    const std::size_t frames = measured.Frames(), looked = std::min(frames, kLooked);
    if (looked < 2) return;
    check.video = video_;
    std::vector<double> time_s(measured.time_s.end() - static_cast<std::ptrdiff_t>(looked), measured.time_s.end());
    check.frames_seen = static_cast<int>(frames);
    check.frames_in_file = static_cast<std::int64_t>(looked);
    check.dropped_frames = tracking::DroppedFrames(time_s);
    check.video.frame_rate_hz = static_cast<double>(check.frames_in_file - 1 + check.dropped_frames) /
                                (time_s.back() - time_s.front());  // stamps may be in whole ms
    check.repeated_frames = static_cast<int>(tracker_->RepeatedFrames());
    if (tracker_->HasAllNames()) check.why_not_named.clear();
    std::size_t all = 0, hidden = 0;
    const motion::MarkerTrack* knee = options_.fit.knee_from ? nullptr : measured.Find("knee");
    for (std::size_t row = frames - looked; row < frames; ++row) {
      all += std::ranges::all_of(measured.markers, [&](const auto& track) { return track.samples[row].IsKnown(); });
      hidden += knee && !knee->samples[row].IsKnown();
    }
    check.all_seen_share = static_cast<double>(all) / static_cast<double>(looked);
    check.knee_hidden_share = static_cast<double>(hidden) / static_cast<double>(looked);
    named = tracker_->Named(looked);
    image = tracker_->Figures();
  }
  const bool has_markers = check.IsNamed() && image && !named.empty();
  if (has_markers) {
    std::vector<const tracking::Tracklet*> pointers;
    pointers.reserve(named.size());
    for (const tracking::Tracklet& tracklet : named) pointers.push_back(&tracklet);
    check.markers = tracking::FiguresOf(pointers, *image, check.video);
  }
  Json checks = Json::array();
  for (const tracking::CheckItem& item : tracking::JudgeRecording(check, static_cast<int>(options_.markers.size()))) {
    if (std::ranges::find(kJudged, item.name) == kJudged.end()) continue;
    if (!check.IsNamed() && item.name == "all_seen_share") continue;
    if (!has_markers && std::ranges::find(kOfMarkers, item.name) != kOfMarkers.end()) continue;
    checks.push_back({{"shown", item.shown},
                      {"verdict", tracking::ToString(item.verdict)},
                      {"advice", item.verdict == tracking::Verdict::kGood ? "" : item.advice}});
  }
  const std::lock_guard lock(mutex_);
  checks_ = std::move(checks);
}

// ---- what has been found

int Session::MovesBefore(double time_s) const {
  return static_cast<int>(std::ranges::count_if(moves_s_, [&](double moved_s) { return moved_s <= time_s; }));
}

std::vector<RiseOffset> Session::RisesAfterMoves(int moves) const {
  std::vector<RiseOffset> rises;
  for (const RiseOffset& rise : rises_)
    if (MovesBefore(rise.onset_s) == moves) rises.push_back(rise);
  return rises;
}

std::optional<JointPlace> Session::Place() const {
  const std::vector<RiseOffset> rises = RisesAfterMoves(static_cast<int>(moves_s_.size()));
  return rises.empty() ? std::nullopt : std::optional(PlaceOf(rises));
}

}  // namespace lake::live
