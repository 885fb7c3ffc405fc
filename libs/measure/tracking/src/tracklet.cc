#include "lake/tracking/tracklet.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "lake/core/statistics.h"
#include "lake/tracking/assignment.h"
#include "picture_repeat.h"

namespace lake::tracking {
namespace {

// The last three samples that were measured, the last one first; `count`: how many of them there are, at least one.
struct Measured {
  std::array<const TrackletSample*, 3> samples = {};
  std::size_t count = 0;
};

Measured LastMeasured(const std::vector<TrackletSample>& samples) {
  Measured last;
  for (auto sample = samples.rbegin(); sample != samples.rend() && last.count < last.samples.size(); ++sample)
    if (!sample->repeated) last.samples[last.count++] = &*sample;
  return last;
}

// Position by the parabola, velocity by the slope, of the last samples; of what rests, where it was on average, as a
// parabola makes four times the noise of it. An acceleration that no marker has is the frames' times', as a
// converted rate leaves some out: then the last speed goes on.
struct Motion {
  Eigen::Vector2d position, velocity;                      // px, px/s
  Eigen::Vector2d acceleration = Eigen::Vector2d::Zero();  // px/s²
};

Motion Extrapolate(const Measured& measured, double time_s, double most_acceleration_px_s2) {
  const auto& [samples, count] = measured;
  const TrackletSample& last = *samples[0];
  if (count < 2) return {last.position, Eigen::Vector2d::Zero()};
  const TrackletSample& before = *samples[1];
  const Eigen::Vector2d slope = (last.position - before.position) / (last.time_s - before.time_s);
  const double ahead = time_s - last.time_s;
  if (count < 3 || ahead > 2 * (last.time_s - before.time_s)) return {last.position + ahead * slope, slope};
  const TrackletSample& first = *samples[2];
  constexpr double kStillPx = 0.25;  // from the last of three to each of the others; at a turn the first may be near
  if ((last.position - first.position).norm() < kStillPx && (last.position - before.position).norm() < kStillPx)
    return {(first.position + before.position + last.position) / 3, Eigen::Vector2d::Zero()};
  const Eigen::Vector2d first_slope = (before.position - first.position) / (before.time_s - first.time_s);
  const Eigen::Vector2d acceleration = (slope - first_slope) / (0.5 * (last.time_s - first.time_s));
  // A seat that is met takes a hip's speed at once; a picture that was shown twice makes a step of nothing.
  constexpr double kBeyond = 2, kStands = 0.25;
  const bool both_move =
      std::min(slope.norm(), first_slope.norm()) > kStands * std::max(slope.norm(), first_slope.norm());
  if (both_move && acceleration.norm() > kBeyond * most_acceleration_px_s2)
    return {last.position + ahead * slope, slope, acceleration};
  const Eigen::Vector2d velocity = slope + acceleration * 0.5 * (last.time_s - before.time_s);
  return {last.position + ahead * velocity + 0.5 * ahead * ahead * acceleration, velocity + ahead * acceleration,
          acceleration};
}

// Whether a sample is among the three before or after a gap or an end, where something comes before the marker or
// leaves it.
bool IsNearGap(const std::vector<TrackletSample>& samples, std::ptrdiff_t i) {
  constexpr std::ptrdiff_t kNear = 3;
  const auto frame = [&](std::ptrdiff_t k) { return samples[static_cast<std::size_t>(k)].frame; };
  if (i < kNear || i + kNear >= static_cast<std::ptrdiff_t>(samples.size())) return true;
  return frame(i) - frame(i - kNear) > kNear || frame(i + kNear) - frame(i) > kNear;
}

// Where a sample's size differs from its neighbours' in time, coding or a turn of its streak has spread its light,
// which makes its place less sure; where it is smaller by more than all other sizes differ, something hides a part of
// it, and it is displaced by as much as the difference. Its sigma takes that in. What differs by half a marker, or
// beside a gap, where something comes before it, shows less than a whole one, is removed. A tracklet that begins half
// hidden would pass for the marker's look, so this waits until all of it is known.
void JudgeLooks(std::vector<TrackletSample>& samples) {
  constexpr std::ptrdiff_t kNeighbours = 15;
  // Of 28 000 whole markers in 107 coded recordings those whose size differed by 0.1 to 0.8 px were 0.12 px off per
  // axis, others 0.085: the error grows with the difference, to 1.4 times as much from 0.1 px on. The centre of what a
  // straight edge leaves of a disc is off by 1.06 of the difference of the radii of equal area. What the noise makes
  // differ is in the sigma already.
  constexpr double kOfScatter = 4, kDisplacedByCoding = 0.4, kDisplacedByHiding = 1.06;
  struct Tolerance {
    double size, size_slack_px, quality_factor, quality_slack;
  };
  // Of 370 whole markers beside a hand 99 % are within 2.3 % of their size and 1.85 times their residual.
  // A disc half hidden has 0.7 of its size.
  constexpr Tolerance kWithin{0.3, 0, 2.5, 0.01}, kNearGap{0.015, 0.1, 1.6, 0.005};
  std::vector<bool> unlike(samples.size());
  const auto count = static_cast<std::ptrdiff_t>(samples.size());
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    std::vector<double> radii, qualities;
    for (std::ptrdiff_t j = std::max<std::ptrdiff_t>(0, i - kNeighbours); j < std::min(count, i + kNeighbours + 1);
         ++j) {
      radii.push_back(samples[static_cast<std::size_t>(j)].radius_px);
      qualities.push_back(samples[static_cast<std::size_t>(j)].quality);
    }
    TrackletSample& sample = samples[static_cast<std::size_t>(i)];
    const double scatter = RobustDeviation(radii);
    const double radius = Median(std::move(radii)), quality = Median(std::move(qualities)),
                 smaller_px = radius - sample.radius_px, off_px = std::abs(smaller_px);
    const Tolerance& tolerance = IsNearGap(samples, i) ? kNearGap : kWithin;
    // What turns while the shutter is open looks larger than a streak of its length, with nothing before it.
    unlike[static_cast<std::size_t>(i)] = off_px > kWithin.size * radius ||
                                          smaller_px > tolerance.size * radius + tolerance.size_slack_px ||
                                          sample.quality > tolerance.quality_factor * quality + tolerance.quality_slack;
    const double beyond_noise_px = std::sqrt(std::max(0.0, off_px * off_px - sample.sigma_px * sample.sigma_px)),
                 displaced_px = smaller_px > kOfScatter * scatter
                                    ? kDisplacedByHiding * beyond_noise_px
                                    : std::min(kDisplacedByCoding * beyond_noise_px, sample.sigma_px);
    sample.sigma_px = std::hypot(sample.sigma_px, displaced_px);
  }
  std::erase_if(samples, [&, i = std::size_t{0}](const TrackletSample&) mutable { return unlike[i++]; });
}

// The first sample was fitted as if at rest, as nothing was known of its streak yet: in 75 first frames that were off
// by 0.02 to 0.03 of the step to the next, per axis.
void WidenFirst(std::vector<TrackletSample>& samples) {
  constexpr double kOfStep = 0.03;
  if (samples.size() < 2) return;
  const double step_px =
      (samples[1].position - samples[0].position).norm() / static_cast<double>(samples[1].frame - samples[0].frame);
  samples[0].sigma_px = std::hypot(samples[0].sigma_px, kOfStep * step_px);
}

void SortByFirstFrame(std::vector<Tracklet>& tracklets) {
  std::sort(tracklets.begin(), tracklets.end(),
            [](const Tracklet& a, const Tracklet& b) { return a.FirstFrame() < b.FirstFrame(); });
}

// What is found after a gap and not followed for `fewest` samples may be something else; of reversed samples, before
// it.
void CutUnsureEnd(std::vector<TrackletSample>& samples, std::size_t fewest) {
  const auto last_run = [&] {
    std::size_t first = samples.size() - 1;
    while (first > 0 && samples[first].frame - samples[first - 1].frame == 1) --first;
    return first;
  };
  while (!samples.empty()) {
    const std::size_t first = last_run();
    if (first == 0 || samples.size() - first >= fewest) return;
    samples.resize(first);
  }
}

constexpr double kMovedPx = 0.5;  // what has moved so far has left the place where a picture that stands shows it

// Whether an object is where it was at first and half-way.
bool Rests(const std::vector<TrackletSample>& samples) {
  constexpr double kStillRadii = 0.25;
  const TrackletSample& last = samples.back();
  const auto is_there = [&](const TrackletSample& sample) {
    return (sample.position - last.position).norm() < kStillRadii * last.radius_px;
  };
  return is_there(samples.front()) && is_there(samples[samples.size() / 2]);
}

// Grows with the distance in gates and with unlikeness; 1 or more is impossible.
double PairCost(const MarkerPrediction& prediction, const MarkerDetection& detection) {
  if (prediction.identity && detection.identity && *prediction.identity != *detection.identity) return 2;
  double distance = (detection.position - prediction.position).norm() / prediction.gate_px;
  if (prediction.rested_at) {
    constexpr double kBeginsRadii = 2;  // as far as what rested moves at once
    const double reach_px = kBeginsRadii * prediction.appearance.RadiusPx();
    distance = std::min(distance, (detection.position - *prediction.rested_at).norm() / reach_px);
  }
  if (distance > 1) return 2;
  // Half hidden, a disc has 0.7 of its size; the size of one of 2 px is hardly known.
  constexpr double kOtherSize = 3;
  const double size_ratio = detection.appearance.RadiusPx() / prediction.appearance.RadiusPx();
  if (size_ratio > kOtherSize || size_ratio < 1 / kOtherSize) return 2;
  const double size = std::log(size_ratio) / 0.5;
  const double brightness =
      std::log(std::max(detection.appearance.amplitude, 1.0) / std::max(prediction.appearance.amplitude, 1.0));
  return std::min(0.999, 0.5 * (distance * distance + size * size + brightness * brightness));
}

}  // namespace

double Tracklet::RadiusPx() const {
  std::vector<double> radii;
  radii.reserve(samples.size());
  for (const TrackletSample& sample : samples) radii.push_back(sample.radius_px);
  return Median(std::move(radii));
}

const TrackletSample* Tracklet::SampleIn(std::int64_t frame) const {
  const auto found = std::lower_bound(samples.begin(), samples.end(), frame,
                                      [](const TrackletSample& sample, std::int64_t f) { return sample.frame < f; });
  return found != samples.end() && found->frame == frame ? &*found : nullptr;
}

MarkerPrediction TrackletBuilder::Predict(const Live& live, double time_s, double frame_s) const {
  const Measured measured = LastMeasured(live.tracklet.samples);
  const double radius = live.appearance.RadiusPx(), ahead = time_s - measured.samples[0]->time_s,
               most_acceleration_px_s2 = options_.physics.AccelerationRadii() * radius;
  const Motion motion = Extrapolate(measured, time_s, most_acceleration_px_s2);
  MarkerPrediction prediction;
  prediction.position = motion.position;
  prediction.velocity_px = motion.velocity * frame_s;
  // A changed speed displaces what goes on by 2/3 of the change a frame.
  constexpr double kChanged = 1.5;
  if (measured.count > 1) prediction.velocity_by_place = kChanged * frame_s / std::max(ahead, 1e-9);
  prediction.gate_px = std::max(2.0, radius) + 0.5 * most_acceleration_px_s2 * ahead * ahead;
  // A marker of unknown velocity may have any; that of two places is hardly known.
  if (measured.count == 1) prediction.gate_px += options_.physics.SpeedRadii() * radius * ahead;
  if (measured.count == 2) prediction.gate_px += 3 * radius;
  // A converted rate shows pictures up to half a frame early or late, and the parabola takes that for acceleration.
  constexpr double kClock = 0.25, kOfAcceleration = 2;
  prediction.gate_px +=
      frame_s * (kClock * motion.velocity.norm() + kOfAcceleration * motion.acceleration.norm() * frame_s);
  // After repeated frames the time since the last measurement may have passed or not.
  if (live.tracklet.samples.back().repeated) {
    prediction.gate_px += motion.velocity.norm() * std::max(ahead - frame_s, 0.0);
    prediction.rested_at = live.tracklet.samples.back().position;
  }
  // Where identities are certain, association needs no caution.
  prediction.gate_px = detector_.KnowsIdentities() ? 8 * radius : std::min(prediction.gate_px, 8 * radius);
  if (live.tracklet.samples.size() == 1 && live.seeded) prediction.gate_px = options_.physics.FastStartRadii() * radius;
  prediction.appearance = live.appearance;
  prediction.quality = live.quality;
  prediction.identity = live.tracklet.identity;
  prediction.was_missed = live.tracklet.LastFrame() < previous_.index &&
                          static_cast<int>(live.tracklet.samples.size()) >= options_.followed;
  return prediction;
}

bool TrackletBuilder::SearchEverywhere(std::int64_t frame) const {
  const bool at_seed = std::any_of(options_.seeds.begin(), options_.seeds.end(),
                                   [&](const TrackletSeed& seed) { return seed.frame == frame; });
  if (at_seed || std::any_of(live_.begin(), live_.end(), [](const Live& live) { return live.IsFastStart(); }))
    return true;
  const bool urgent = last_loss_s_ && time_s_ - *last_loss_s_ < options_.urgent_s;
  const double interval_s = urgent ? options_.urgent_interval_s : options_.search_interval_s;
  return frames_seen_ % std::max(1L, frame_s_ > 0 ? std::lround(interval_s / frame_s_) : 1L) == 0;
}

bool TrackletBuilder::IsSeed(std::int64_t frame, const MarkerDetection& detection) const {
  return std::any_of(options_.seeds.begin(), options_.seeds.end(), [&](const TrackletSeed& seed) {
    return seed.frame == frame &&
           (seed.position - detection.position).norm() < detection.appearance.RadiusPx() + kSeedSlackPx;
  });
}

void TrackletBuilder::Extend(Live& live, const TrackletSample& when, const MarkerDetection& detection) {
  live.tracklet.samples.push_back({.frame = when.frame,
                                   .time_s = when.time_s,
                                   .position = detection.position,
                                   .sigma_px = detection.sigma_px,
                                   .radius_px = detection.appearance.ApparentRadiusPx(),
                                   .amplitude = detection.appearance.amplitude,
                                   .background = detection.background,
                                   .quality = detection.quality,
                                   .repeated = when.repeated});
  live.seen_s = when.time_s;
  if (!live.tracklet.identity) live.tracklet.identity = detection.identity;
  // The running mean over the last ten or so looks; all of them while there are fewer.
  const double weight = std::max(0.1, 1.0 / static_cast<double>(live.tracklet.samples.size()));
  const Blob& now = detection.appearance;
  live.appearance.unit_circle_from_px += weight * (now.unit_circle_from_px - live.appearance.unit_circle_from_px);
  live.appearance.edge_px += weight * (now.edge_px - live.appearance.edge_px);
  live.appearance.amplitude += weight * (now.amplitude - live.appearance.amplitude);
  live.quality += weight * (detection.quality - live.quality);
}

void TrackletBuilder::Associate(std::int64_t frame, std::span<const MarkerPrediction> predictions,
                                std::vector<MarkerDetection> detections) {
  const TrackletSample now{.frame = frame, .time_s = time_s_, .repeated = is_repeated_};
  Eigen::MatrixXd cost(live_.size(), detections.size());
  for (std::size_t i = 0; i < live_.size(); ++i)
    for (std::size_t j = 0; j < detections.size(); ++j)
      cost(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = PairCost(predictions[i], detections[j]);
  const std::vector<int> assigned = AssignRows(cost, 1.0);
  std::vector<bool> taken(detections.size(), false);
  // What is far from where one leads is neither's if it may be another that is lost in this frame, or if the one was
  // lost for so long, as beside a gap in the time stamps, that it may be anywhere.
  const auto is_anybodys = [&](std::size_t row, int column) {
    constexpr double kNear = 0.05;  // a third of a gate
    if (cost(static_cast<Eigen::Index>(row), column) < kNear) return false;
    if (!detector_.KnowsIdentities() && time_s_ - live_[row].seen_s > CoastS()) return true;
    for (std::size_t i = 0; i < assigned.size(); ++i)
      if (assigned[i] < 0 && cost(static_cast<Eigen::Index>(i), column) < 1 &&
          live_[i].tracklet.LastFrame() == previous_.index &&
          static_cast<int>(live_[i].tracklet.samples.size()) >= options_.followed)
        return true;
    return false;
  };
  for (std::size_t i = 0; i < assigned.size(); ++i) {
    if (assigned[i] < 0 || is_anybodys(i, assigned[i])) continue;
    taken[static_cast<std::size_t>(assigned[i])] = true;
    Extend(live_[i], now, detections[static_cast<std::size_t>(assigned[i])]);
  }
  if (is_repeated_) return;  // nothing new can be seen in it
  for (std::size_t j = 0; j < detections.size(); ++j) {
    if (taken[j]) continue;
    const bool is_seed = IsSeed(frame, detections[j]);
    if (!is_seed && live_.size() >= options_.max_live && !MakePlaceFor(detections[j])) continue;
    live_.push_back({{}, detections[j].appearance, detections[j].quality, time_s_, is_seed, ++last_number_});
    Extend(live_.back(), now, detections[j]);
  }
}

// Gives up what has rested longest, a lamp most likely, so that what moves is never left out; not for another object in
// a place where one was given up before.
bool TrackletBuilder::MakePlaceFor(const MarkerDetection& detection) {
  const double radius = detection.appearance.RadiusPx();
  if (std::any_of(evicted_.begin(), evicted_.end(),
                  [&](const Eigen::Vector2d& place) { return (place - detection.position).norm() < radius; }))
    return false;
  auto longest = live_.end();
  for (auto live = live_.begin(); live != live_.end(); ++live) {
    const std::vector<TrackletSample>& samples = live->tracklet.samples;
    if (live->seeded || static_cast<int>(samples.size()) < options_.established || !Rests(samples)) continue;
    if (longest == live_.end() || samples.size() > longest->tracklet.samples.size()) longest = live;
  }
  if (longest == live_.end()) return false;
  evicted_.push_back(longest->tracklet.samples.back().position);
  Keep(std::move(longest->tracklet));
  live_.erase(longest);
  return true;
}

double TrackletBuilder::CoastS() const {
  return std::max(options_.max_coast_s, (options_.max_coast_frames + 0.5) * frame_s_);
}

void TrackletBuilder::RetireLost() {
  const double coast_s = CoastS();
  std::erase_if(live_, [&](Live& live) {
    const bool young = !live.seeded && static_cast<int>(live.tracklet.samples.size()) < options_.min_samples;
    const bool established = static_cast<int>(live.tracklet.samples.size()) >= options_.established;
    if (established && live.seen_s < time_s_) last_loss_s_ = time_s_;
    if (live.seen_s >= time_s_ || (!young && time_s_ - live.seen_s <= coast_s)) return false;
    Keep(std::move(live.tracklet));
    return true;
  });
}

void TrackletBuilder::Keep(Tracklet tracklet) {
  if (std::optional<Tracklet> judged = Judged(std::move(tracklet))) finished_.push_back(*std::move(judged));
}

// Without what is no measurement of it; nullopt where too little is left.
std::optional<Tracklet> TrackletBuilder::Judged(Tracklet tracklet) const {
  if (!detector_.KnowsIdentities()) {
    WidenFirst(tracklet.samples);
    if (!detector_.NeedsColour()) JudgeLooks(tracklet.samples);  // in the chroma size is too uncertain to tell
    CutUnsureEnd(tracklet.samples, static_cast<std::size_t>(options_.min_samples));
  }
  if (static_cast<int>(tracklet.samples.size()) < options_.min_samples) return std::nullopt;
  return tracklet;
}

std::vector<TrackletBuilder::Followed> TrackletBuilder::AllFollowed() const {
  std::vector<Followed> all;
  all.reserve(live_.size());
  for (const Live& live : live_) all.push_back({live.number, &live.tracklet});
  return all;
}

// Of all that was seen in the frame before and has a certain place, as a face that is followed by its hue has not.
std::vector<ExpectedStep> TrackletBuilder::ExpectedSteps(std::span<const MarkerPrediction> predictions) const {
  constexpr double kVague = 0.5;
  std::vector<ExpectedStep> steps;
  for (std::size_t i = 0; i < predictions.size(); ++i) {
    const TrackletSample& last = live_[i].tracklet.samples.back();
    if (last.frame != previous_.index || live_[i].quality > kVague) continue;
    steps.push_back({last.position, predictions[i].position - last.position, predictions[i].appearance.RadiusPx()});
  }
  return steps;
}

// Whether two objects at least have left the places that they had before a run of repeated frames: the picture is no
// repetition, but its objects move more slowly than was expected, the more so the longer the expectation goes on.
bool TrackletBuilder::HasCrept() const {
  constexpr double kCreptPx = 1;  // coding that refines a copy moves a marker by less
  const auto crept = std::ranges::count_if(live_, [&](const Live& live) {
    const std::vector<TrackletSample>& samples = live.tracklet.samples;
    const auto before =
        std::ranges::find_if(samples.rbegin(), samples.rend(), [](const TrackletSample& s) { return !s.repeated; });
    return before != samples.rend() && (samples.back().position - before->position).norm() > kCreptPx;
  });
  return crept >= 2;
}

// Whether, after repeated frames, everything is where it would be had no time passed during them.
bool TrackletBuilder::StoodStill(const video::VideoFrame& frame, std::span<const MarkerPrediction> predictions) const {
  constexpr double kAlike = 0.35;
  const double repeated_s = previous_.time_s - repeated_since_s_;
  const double without = Mismatch(previous_.luma, frame.luma, ExpectedSteps(PredictAll(time_s_ - repeated_s)));
  return without < kAlike && without < Mismatch(previous_.luma, frame.luma, ExpectedSteps(predictions));
}

// What has come to rest at once looks like a picture that stands still; that it does not move for so long decides.
void TrackletBuilder::NoteRepeated(std::int64_t frame) {
  constexpr double kLongest_s = 0.5;
  if (repeated_.empty() || repeated_.back() != previous_.index) repeated_since_s_ = previous_.time_s;
  repeated_.push_back(frame);
  if (time_s_ + stood_still_s_ - repeated_since_s_ <= kLongest_s) return;
  is_repeated_ = false;
  stands_since_ = TakeBackRepeated();
}

// What came to rest at once has been frozen if it leaves its place at once as well, two objects at least; what begins
// to move, creeps at first.
void TrackletBuilder::JudgeStanding(std::int64_t frame) {
  int jumped = 0, crept = 0;
  for (const Live& live : live_) {
    const TrackletSample *first = live.tracklet.SampleIn(*stands_since_),
                         *before = live.tracklet.SampleIn(previous_.index), *now = live.tracklet.SampleIn(frame);
    if (!first) continue;
    const auto is_away = [&](const TrackletSample* sample) {
      return !sample || (sample->position - first->position).norm() >= kMovedPx;
    };
    if (is_away(now)) ++(is_away(before) ? crept : jumped);
  }
  if (jumped + crept < 2) return;
  if (jumped >= 2 && jumped > crept) {
    while (!repeated_.empty() && repeated_.back() >= *stands_since_) repeated_.pop_back();
    for (std::int64_t frozen = *stands_since_; frozen < frame; ++frozen) repeated_.push_back(frozen);
    for (Live& live : live_)
      for (TrackletSample& sample : live.tracklet.samples)
        if (sample.frame >= *stands_since_ && sample.frame < frame) sample.repeated = true;
    discontinuities_.push_back(frame);
    last_loss_s_ = time_s_;
  }
  stands_since_.reset();
}

// Whether the frames before were repeated: only what has moved on when the picture changes again was hidden from sight;
// where coding leaves objects that come to rest a frame behind, nothing was.
bool TrackletBuilder::IsConfirmed(std::int64_t frame) const {
  const auto moved = std::count_if(live_.begin(), live_.end(), [&](const Live& live) {
    const std::vector<TrackletSample>& samples = live.tracklet.samples;
    return samples.size() > 1 && samples.back().frame == frame && samples[samples.size() - 2].repeated &&
           (samples.back().position - samples[samples.size() - 2].position).norm() >= kMovedPx;
  });
  const auto lost =
      std::count_if(live_.begin(), live_.end(), [](const Live& live) { return live.tracklet.samples.back().repeated; });
  return moved + lost >= 2;
}

// Time went on while the picture was taken for one that stands still.
void TrackletBuilder::SetTimeBack(const video::VideoFrame& frame, double stood_still_s) {
  stood_still_s_ = stood_still_s;
  time_s_ = frame.time_s - stood_still_s_;
  for (Live& live : live_) {
    if (live.tracklet.LastFrame() != frame.index) continue;
    live.tracklet.samples.back().time_s = time_s_;
    live.seen_s = time_s_;
  }
}

// The last run of repeated frames was none; returns its first.
std::int64_t TrackletBuilder::TakeBackRepeated() {
  std::int64_t last = repeated_.back();
  for (; !repeated_.empty() && repeated_.back() == last; --last) repeated_.pop_back();
  for (Live& live : live_)
    for (auto sample = live.tracklet.samples.rbegin(); sample != live.tracklet.samples.rend() && sample->frame > last;
         ++sample)
      sample->repeated = false;
  return last + 1;
}

void TrackletBuilder::NoteBreak(std::int64_t frame, std::span<const MarkerPrediction> predictions) {
  constexpr double kMovingPx = 0.5;
  std::size_t moving = 0;
  std::vector<std::size_t> lost;
  for (std::size_t i = 0; i < predictions.size(); ++i) {
    const std::vector<TrackletSample>& samples = live_[i].tracklet.samples;
    const TrackletSample* before = live_[i].tracklet.SampleIn(previous_.index);
    if (!before || static_cast<int>(samples.size()) < options_.established) continue;
    if ((predictions[i].position - before->position).norm() < kMovingPx) continue;
    ++moving;
    if (samples.back().frame != frame) lost.push_back(i);
  }
  if (lost.size() < 2 || 2 * lost.size() < moving) return;
  discontinuities_.push_back(frame);
  last_loss_s_ = time_s_;
  // Where these lead is wrong: of neighbours each may be found where another is expected. Which goes on as which
  // is for naming to decide.
  const auto has_neighbour = [&](std::size_t i) {
    return std::ranges::any_of(lost, [&](std::size_t k) {
      return k != i && (predictions[k].position - predictions[i].position).norm() <
                           predictions[k].gate_px + predictions[i].gate_px;
    });
  };
  std::for_each(lost.rbegin(), lost.rend(), [&](std::size_t i) {
    if (!has_neighbour(i)) return;
    Keep(std::move(live_[i].tracklet));
    live_.erase(live_.begin() + static_cast<std::ptrdiff_t>(i));
  });
}

void TrackletBuilder::Remember(const video::VideoFrame& frame) {
  constexpr std::size_t kBytes = 48 << 20;
  if (options_.look_back_s == 0) return;
  remembered_.emplace_back(frame, time_s_);
  const std::size_t bytes = 3 * frame.luma.total() / 2 + frame.preview.total();  // the decoder keeps the chroma too
  while (time_s_ - remembered_.front().second > options_.look_back_s || remembered_.size() * bytes > kBytes)
    remembered_.pop_front();
}

bool TrackletBuilder::IsNearAnother(const Live& live, std::int64_t frame, const Eigen::Vector2d& place) const {
  const double near_px = 2 * live.appearance.RadiusPx();
  const auto is_near = [&](const Tracklet& other) {
    const TrackletSample* sample = other.SampleIn(frame);
    return sample && (sample->position - place).norm() < near_px;
  };
  return std::ranges::any_of(finished_, is_near) ||
         std::ranges::any_of(live_, [&](const Live& other) { return is_near(other.tracklet); });
}

// What is found late, as it was a streak or hidden at first, is followed once against the course of time, until it is
// lost or comes near another.
void TrackletBuilder::FollowBack(Live& live) {
  if (live.was_followed_back || static_cast<int>(live.tracklet.samples.size()) < options_.min_samples) return;
  live.was_followed_back = true;
  const auto reversed = [](TrackletSample sample) {
    sample.frame = -sample.frame;
    sample.time_s = -sample.time_s;
    return sample;
  };
  std::vector<TrackletSample>& samples = live.tracklet.samples;
  Live back = live;
  std::ranges::transform(samples.rbegin(), samples.rend(), back.tracklet.samples.begin(), reversed);
  back.seen_s = back.tracklet.samples.back().time_s;
  for (auto seen = remembered_.rbegin(); seen != remembered_.rend(); ++seen) {
    const auto& [frame, time_s] = *seen;
    if (frame.index >= live.tracklet.FirstFrame() || std::ranges::binary_search(repeated_, frame.index)) continue;
    if (-time_s - back.seen_s > CoastS()) break;
    MarkerPrediction prediction = Predict(back, -time_s, frame_s_);
    const std::vector<MarkerDetection> found = detector_.Detect(frame, std::span(&prediction, 1), Look::kNearAgain);
    const auto cost = [&](const MarkerDetection& detection) { return PairCost(prediction, detection); };
    const auto likest = std::ranges::min_element(found, {}, cost);
    if (likest == found.end() || cost(*likest) >= 1) continue;
    if (IsNearAnother(live, frame.index, likest->position)) break;
    Extend(back, {.frame = -frame.index, .time_s = -time_s}, *likest);
  }
  std::vector<TrackletSample> earlier(back.tracklet.samples.begin() + static_cast<std::ptrdiff_t>(samples.size()) - 1,
                                      back.tracklet.samples.end());
  CutUnsureEnd(earlier, static_cast<std::size_t>(options_.min_samples));
  std::ranges::transform(earlier, earlier.begin(), reversed);
  samples.insert(samples.begin(), earlier.rbegin(), earlier.rend() - 1);
}

std::vector<MarkerPrediction> TrackletBuilder::PredictAll(double time_s) const {
  std::vector<MarkerPrediction> predictions;
  for (const Live& live : live_) predictions.push_back(Predict(live, time_s, frame_s_));
  return predictions;
}

// The shutter does not stay open for longer where frames were dropped.
void TrackletBuilder::NoteInterval(double interval_s) {
  constexpr double kAlike = 0.1, kStep = 1.02;
  if (frame_s_ == 0)
    frame_s_ = interval_s;
  else if (std::abs(interval_s / frame_s_ - 1) < kAlike)
    frame_s_ += kAlike * (interval_s - frame_s_);
  else
    frame_s_ *= interval_s > frame_s_ ? kStep : 1 / kStep;  // a running median
}

void TrackletBuilder::Add(const video::VideoFrame& frame) {
  if (frames_seen_ > 0) NoteInterval(frame.time_s - previous_.time_s);
  time_s_ = frame.time_s - stood_still_s_;
  std::vector<MarkerPrediction> predictions = PredictAll(time_s_);
  const bool can_compare = frames_seen_ > 0 && !frame.luma.empty();
  is_repeated_ = can_compare && IsRepeated(previous_.luma, frame.luma, ExpectedSteps(predictions));
  if (is_repeated_) {
    NoteRepeated(frame.index);
    for (std::size_t i = 0; i < predictions.size(); ++i)
      predictions[i].position = live_[i].tracklet.samples.back().position;
  }
  const bool ends_repetition =
      can_compare && !is_repeated_ && !repeated_.empty() && repeated_.back() == previous_.index;
  const double stood_still_before_s = stood_still_s_;
  if (ends_repetition && StoodStill(frame, predictions)) {
    stood_still_s_ += previous_.time_s - repeated_since_s_;
    time_s_ = frame.time_s - stood_still_s_;
    predictions = PredictAll(time_s_);
  }
  Associate(frame.index, predictions,
            detector_.Detect(frame, predictions, SearchEverywhere(frame.index) ? Look::kEverywhere : Look::kNear));
  if (is_repeated_ && HasCrept()) {
    is_repeated_ = false;
    TakeBackRepeated();
  }
  if (ends_repetition && !IsConfirmed(frame.index)) {
    TakeBackRepeated();
    SetTimeBack(frame, stood_still_before_s);
  }
  if (stands_since_ && *stands_since_ < frame.index) JudgeStanding(frame.index);
  NoteBreak(frame.index, predictions);
  RetireLost();
  for (Live& live : live_) FollowBack(live);
  Remember(frame);
  previous_ = frame;
  ++frames_seen_;
}

std::vector<Tracklet> TrackletBuilder::SoFar() const {
  std::vector<Tracklet> all = finished_;
  for (const Live& live : live_)
    if (std::optional<Tracklet> judged = Judged(live.tracklet)) all.push_back(*std::move(judged));
  SortByFirstFrame(all);
  return all;
}

std::vector<Tracklet> TrackletBuilder::Finish() {
  for (Live& live : live_) Keep(std::move(live.tracklet));
  live_.clear();
  SortByFirstFrame(finished_);
  return std::move(finished_);
}

}  // namespace lake::tracking
