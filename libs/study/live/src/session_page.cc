// What the page of a session is sent, and what live.json holds.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "lake/compare/misalignment.h"
#include "lake/core/error.h"
#include "lake/core/json_or_null.h"
#include "lake/core/statistics.h"
#include "session.h"
#include "trial.h"

namespace lake::live {

using Eigen::Vector2d;

namespace {

constexpr int kPictureWidthPx = 1280;  // of what the page shows, at most

Json PointJson(const Vector2d& point) {
  return {point.x(), point.y()};
}

// On the clock that a page on the same machine has, too: ms since 1970.
double WallClockMs(std::chrono::steady_clock::time_point time) {
  const auto ago = std::chrono::steady_clock::now() - time;
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration<double, std::milli>(now - ago).count();
}

Json JointPlaceJson(const JointPlace& place, double tolerance_mm) {
  return {{"rises", place.rises},
          {"offset_mm", PointJson(place.offset_mm)},
          {"half_width_mm", PointJson(place.half_width_mm)},
          {"anatomical_half_width_mm", PointJson(place.anatomical_half_width_mm)},
          {"distance_mm", place.DistanceMm()},
          {"where", compare::DescribeJoint(place.offset_mm)},
          {"do_rises_narrow", place.DoRisesNarrow()},
          {"move", MoveText(place, tolerance_mm)}};
}

}  // namespace

review::LiveWork Session::PageWork() {
  return {.about = [this] { return About(); },
          .state = [this] { return State(); },
          .view = [this](std::int64_t after) { return View(after); },
          .picture = [this](std::int64_t frame) { return Picture(frame); },
          .act = [this](const Json& act) { Act(act); },
          .is_over = [this] { return IsOver(); }};
}

Json Session::About() const {
  const std::lock_guard lock(mutex_);
  return {{"input", options_.input == "-" ? "standard input" : options_.input},
          {"folder", run_.Folder().string()},
          {"width", video_.width},
          {"height", video_.height},
          {"markers", options_.markers},
          {"joint", options_.joint},
          {"joint_at_mm", options_.joint_at_mm},
          {"tolerance_mm", options_.tolerance_mm}};
}

std::string Session::PhaseText() const {
  switch (phase_) {
    case Phase::kWatching:
      return "watching";
    case Phase::kTrial:
      return "trial";
    case Phase::kFinishing:
      return "finishing";
    case Phase::kDone:
      return "done";
    case Phase::kFailed:
      return "failed";
  }
  return "failed";
}

// The place since the last move, what to do, and what the last move did.
Json Session::PlaceJson() const {
  const std::optional<JointPlace> place = Place();
  Json json = place ? JointPlaceJson(*place, options_.tolerance_mm) : Json();
  if (place) json["verdict"] = ToString(JudgeTolerance(*place, options_.tolerance_mm));
  return json;
}

Json Session::State() const {
  const std::lock_guard lock(mutex_);
  Json missing = Json::array(), rises = Json::array();
  const std::vector<tracking::LiveSpot> spots = tracker_->Spots();
  for (const std::string& name : options_.markers)
    if (std::ranges::find(spots, name, &tracking::LiveSpot::name) == spots.end()) missing.push_back(name);
  for (const RiseOffset& rise : rises_)
    rises.push_back({{"standing_s", rise.standing_s},
                     {"offset_mm", PointJson(rise.mean_mm)},
                     {"moves", MovesBefore(rise.onset_s)}});
  std::string change;
  const std::vector<RiseOffset> before =
      moves_s_.empty() ? std::vector<RiseOffset>() : RisesAfterMoves(static_cast<int>(moves_s_.size()) - 1);
  if (const auto now = Place(); now && !before.empty()) change = ChangeText(PlaceOf(before), *now);
  return {{"phase", PhaseText()},
          {"is_held", IsHeld()},
          {"recorded_s", samples_.empty() ? 0 : samples_.back().time_s},
          {"frames", samples_.size()},
          {"moves", moves_s_.size()},
          {"is_named", tracker_->HasAllNames()},
          {"why_not_named", why_not_named_},
          {"missing", missing},
          {"why_no_rise", why_no_rise_},
          {"rises", rises},
          {"place", PlaceJson()},
          {"change", change},
          {"checks", checks_},
          {"progress", progress_},
          {"end", end_ ? Json(end_->why) : Json()},
          {"failed", failure_text_},
          {"has_trial", difference_.has_value()},
          {"difference_px", NumberOrNull(difference_ ? difference_->all.RmsPx() : std::nullopt)}};
}

Json Session::View(std::int64_t after) const {
  std::unique_lock lock(mutex_);
  constexpr std::chrono::milliseconds kWait{500};
  const auto has_later = [&] {
    return !tracker_->Reported().frame.empty() && tracker_->Reported().frame.back() > after;
  };
  changed_.wait_for(lock, kWait, [&] { return has_later() || has_ended_; });
  if (!has_later())
    return {{"frame", after}, {"markers", Json::array()}, {"spots", Json::array()}, {"samples", Json::array()}};
  const motion::MarkerRecording& reported = tracker_->Reported();
  Json markers = Json::array(), spots = Json::array(), samples = Json::array();
  for (const motion::MarkerTrack& track : reported.markers) {
    const motion::MarkerSample& sample = track.samples.back();
    const bool is_known = sample.IsKnown();
    markers.push_back({{"name", track.name},
                       {"x", is_known ? Json(sample.position.x()) : Json()},
                       {"y", is_known ? Json(sample.position.y()) : Json()},
                       {"sigma", is_known ? Json(sample.sigma) : Json()}});
  }
  for (const tracking::LiveSpot& spot : tracker_->Spots())
    spots.push_back(
        {{"x", spot.position.x()}, {"y", spot.position.y()}, {"radius", spot.radius_px}, {"name", spot.name}});
  constexpr std::size_t kMost = 600;
  const auto later = std::ranges::upper_bound(reported.frame, after);
  std::size_t first = static_cast<std::size_t>(later - reported.frame.begin());
  first = std::max(first, samples_.size() > kMost ? samples_.size() - kMost : 0);
  for (std::size_t row = first; row < samples_.size(); ++row) {
    const Sample& sample = samples_[row];
    const auto joint = [&](int axis) { return sample.joint_mm ? Json((*sample.joint_mm)[axis]) : Json(); };
    samples.push_back({sample.time_s, NumberOrNull(sample.knee_deg), joint(0), joint(1)});
  }
  const Sample& now = samples_.back();
  return {{"frame", reported.frame.back()},
          {"time_s", now.time_s},
          {"arrived_ms", WallClockMs(pictures_.back().arrived)},
          {"markers", markers},
          {"spots", spots},
          {"samples", samples},
          {"move", now.to_px && now.from_px ? Json{PointJson(*now.from_px), PointJson(*now.to_px)} : Json()}};
}

cv::Mat Session::Picture(std::int64_t frame) const {
  video::VideoFrame kept;
  {
    const std::lock_guard lock(mutex_);
    const auto found =
        std::ranges::find(pictures_, frame, [](const video::LiveFrame& live) { return live.frame.index; });
    if (found == pictures_.end()) throw Fail("frame {} is not kept any more", frame);
    kept = found->frame;
  }
  // By a whole number: of 1080p that takes 1.0 ms, JPEG included, where a factor of 1.5 takes 5.2.
  const int part = static_cast<int>(std::lround(static_cast<double>(kept.luma.cols) / kPictureWidthPx));
  if (part <= 1) return kept.luma.clone();
  cv::Mat smaller;
  cv::resize(kept.luma, smaller, {}, 1.0 / part, 1.0 / part, cv::INTER_AREA);
  return smaller;
}

void Session::Act(const Json& act) {
  const std::string what = act.at("what");
  const std::lock_guard lock(mutex_);
  if (phase_ != Phase::kWatching && phase_ != Phase::kTrial) throw Error("the recording has ended");
  if (samples_.empty()) throw Error("no frame has come yet");
  const double now_s = samples_.back().time_s;
  if (what == "begin") {
    if (phase_ == Phase::kTrial) throw Error("the trial is under way");
    begin_s_ = now_s;
    phase_ = Phase::kTrial;
    stream_->Release();
  } else if (what == "end") {
    end_s_ = now_s;
    phase_ = Phase::kFinishing;
    stream_->Stop();
  } else if (what == "moved") {
    moves_s_.push_back(now_s);
    track_.others_since = tracker_->Reported().frame.back();
    moves_table_->Row({fmt::format("{}", moves_s_.size()), FormatNumber(now_s),
                       fmt::format("{}", tracker_->Reported().frame.back())});
    moves_table_->Flush();
  } else if (what == "name") {
    const std::string name = act.at("name");
    const Vector2d place(act.at("x").get<double>(), act.at("y").get<double>());
    tracker_->Name(name, place);
    std::erase_if(by_hand_, [&](const tracking::MarkerSeed& seed) { return seed.name == name; });
    by_hand_.push_back({.name = name, .position = place, .frame = tracker_->Reported().frame.back()});
  } else {
    throw Fail("'{}' is nothing that can be done", what);
  }
  SaveLive();
}

void Session::SaveLive() {
  WriteJsonFile(run_.Result(kLive), LiveJsonLocked());
}

LiveFigures Session::Figures() const {
  const std::lock_guard lock(mutex_);
  LiveFigures figures{.frames = std::ssize(samples_),
                      .recorded_s = samples_.empty() ? 0 : samples_.back().time_s,
                      .ended = end_->why,
                      .place = {},
                      .difference_px = difference_->all.RmsPx()};
  if (const auto place = Place())
    figures.place = LiveFigures::Told{.rises = place->rises,
                                      .where = compare::DescribeJoint(place->offset_mm),
                                      .move = MoveText(*place, options_.tolerance_mm)};
  return figures;
}

Json Session::LiveJson() const {
  const std::lock_guard lock(mutex_);
  return LiveJsonLocked();
}

Json Session::LiveJsonLocked() const {
  Json json = run_.Head();
  const bool has_frames = !latencies_ms_.empty();
  Json rises = Json::array();
  for (const RiseOffset& rise : rises_)
    rises.push_back({{"onset_s", rise.onset_s},
                     {"standing_s", rise.standing_s},
                     {"moves", MovesBefore(rise.onset_s)},
                     {"place", JointPlaceJson(PlaceOf(std::vector{rise}), options_.tolerance_mm)}});
  json["recording"] = kVideo;
  json["frames"] = samples_.size();
  json["damaged_frames"] = end_ ? Json(stream_->DamagedFrames()) : Json();
  json["missing_frames"] = stream_ ? Json(stream_->MissingFrames()) : Json();
  json["camera_clock_start_s"] = end_ ? Json(stream_->FirstStampS()) : Json();
  json["recorded_s"] = samples_.empty() ? 0 : samples_.back().time_s;
  json["latency_ms"] = {{"median", has_frames ? Json(Median(latencies_ms_)) : Json()},
                        {"of_95_percent", has_frames ? Json(Quantile(latencies_ms_, 0.95)) : Json()},
                        {"largest", has_frames ? Json(std::ranges::max(latencies_ms_)) : Json()}};
  json["begin_s"] = ValueOrNull(begin_s_);
  json["end_s"] = ValueOrNull(end_s_);
  json["ended"] = end_ ? Json(end_->why) : Json();
  json["moves_s"] = moves_s_;
  json["rises"] = rises;
  json["tolerance_mm"] = options_.tolerance_mm;
  json["place"] = PlaceJson();
  json["track_arguments"] = Arguments();
  json["difference"] = difference_ ? DifferenceJson(*difference_) : Json();
  return json;
}

}  // namespace lake::live
