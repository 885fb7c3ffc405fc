#include "lake/tracking/live_tracker.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lake/core/error.h"
#include "lake/tracking/naming.h"
#include "lake/tracking/sigma_calibration.h"

namespace lake::tracking {

using Eigen::Vector2d;

namespace {

constexpr double kForetold_s = 0.1;        // as long as a tracklet goes on unseen
constexpr double kForgotten_s = 0.25;      // a filter that saw nothing for longer begins anew
constexpr double kLengthTolerance = 0.05;  // of a distance that stays, as in naming

motion::MarkerRecording EmptyRecording(const std::vector<std::string>& names) {
  motion::MarkerRecording recording;
  recording.unit = motion::LengthUnit::kPx;
  for (const std::string& name : names) recording.markers.push_back({name, {}});
  return recording;
}

motion::MarkerSample Detected(const Vector2d& position, double sigma) {
  return {position, sigma, motion::SampleStatus::kDetected};
}

}  // namespace

bool LiveTracker::Distance::IsRigid() const {
  constexpr int kEnough = 15;          // frames
  constexpr double kVariation = 0.03;  // skin's, over the length
  return count >= kEnough && std::sqrt(squares / count) <= kVariation * mean;
}

LiveTracker::LiveTracker(LiveTrackOptions options, const video::VideoInfo& video)
    : options_(std::move(options)),
      sigma_factor_(UsualErrorOverFit(video)),
      detector_(MakeReflectiveDetector(options_.polarity, DetectorRegion{options_.crop})),
      number_(options_.names.size()),
      why_no_seed_(options_.names.size()),
      last_place_px_(options_.names.size()),
      filters_(options_.names.size()),
      reported_(EmptyRecording(options_.names)),
      measured_(EmptyRecording(options_.names)) {
  TrackletOptions following;
  following.physics = options_.physics;
  // Half as often as in a file: what else is found makes names less certain while little has moved.
  following.search_interval_s = 0.2;
  following.urgent_interval_s = 1.0 / 15;
  for (const MarkerSeed& seed : options_.seeds) following.seeds.push_back({seed.frame, seed.position});
  builder_ = std::make_unique<TrackletBuilder>(*detector_, following);
}

void LiveTracker::Add(const video::VideoFrame& frame) {
  builder_->Add(frame);
  for (motion::MarkerRecording* recording : {&reported_, &measured_}) {
    recording->frame.push_back(frame.index);
    recording->time_s.push_back(frame.time_s);
    for (motion::MarkerTrack& track : recording->markers) track.samples.emplace_back();
  }
  TakeSeeds(frame.index);
  Rejoin();
  for (std::size_t n = 0; n < number_.size(); ++n)
    if (const TrackletSample* sample = SeenNow(n)) {
      measured_.markers[n].samples.back() = Detected(sample->position, sample->sigma_px);
      last_place_px_[n] = sample->position;
    }
  LearnDistances();
  FilterAll(frame.time_s);
}

const Tracklet* LiveTracker::TrackletOf(std::size_t name) const {
  if (!number_[name]) return nullptr;
  for (const TrackletBuilder::Followed& followed : builder_->AllFollowed())
    if (followed.number == *number_[name]) return followed.tracklet;
  return nullptr;
}

// Not in a picture that repeats the one before.
const TrackletSample* LiveTracker::SeenNow(std::size_t name) const {
  const Tracklet* tracklet = TrackletOf(name);
  if (!tracklet || measured_.frame.empty()) return nullptr;
  const TrackletSample& last = tracklet->samples.back();
  return last.frame == measured_.frame.back() && !last.repeated ? &last : nullptr;
}

std::size_t LiveTracker::IndexOf(std::string_view name) const {
  const auto found = std::ranges::find(options_.names, name);
  if (found == options_.names.end())
    throw Fail("'{}' is not one of the markers ({})", name, fmt::join(options_.names, ", "));
  return static_cast<std::size_t>(found - options_.names.begin());
}

// With all that was measured of it before.
void LiveTracker::Give(std::size_t name, const TrackletBuilder::Followed& followed) {
  for (std::optional<std::int64_t>& other : number_)
    if (other == followed.number) other.reset();
  number_[name] = followed.number;
  filters_[name] = {};
  last_place_px_[name] = followed.tracklet->samples.back().position;
  for (const TrackletSample& sample : followed.tracklet->samples) {
    const auto found = std::ranges::lower_bound(measured_.frame, sample.frame);
    if (found == measured_.frame.end() || *found != sample.frame || sample.repeated) continue;
    const auto row = static_cast<std::size_t>(found - measured_.frame.begin());
    measured_.markers[name].samples[row] = Detected(sample.position, sample.sigma_px);
  }
}

void LiveTracker::TakeSeeds(std::int64_t frame) {
  for (const MarkerSeed& seed : options_.seeds) {
    if (seed.frame != frame) continue;
    try {
      Name(seed.name, seed.position);
    } catch (const Error& error) {
      why_no_seed_[IndexOf(seed.name)] = fmt::format("seed {}", error.what());
    }
  }
}

std::string LiveTracker::WhyNoSeed() const {
  for (std::size_t n = 0; n < number_.size(); ++n)
    if (!number_[n] && !why_no_seed_[n].empty()) return why_no_seed_[n];
  return "";
}

std::optional<Vector2d> LiveTracker::MetricOf(const Vector2d& px) const {
  try {
    return options_.metric_from_px(px);
  } catch (const Error&) {
    return std::nullopt;
  }
}

void LiveTracker::Name(std::string_view name, const Vector2d& place_px) {
  const std::size_t index = IndexOf(name);
  std::optional<TrackletBuilder::Followed> nearest;
  double least_px = std::numeric_limits<double>::infinity();
  for (const TrackletBuilder::Followed& followed : builder_->AllFollowed()) {
    const TrackletSample& last = followed.tracklet->samples.back();
    const double away_px = (last.position - place_px).norm() - last.radius_px;
    if (last.frame != measured_.frame.back() || away_px > kSeedSlackPx || away_px >= least_px) continue;
    nearest = followed;
    least_px = away_px;
  }
  if (!nearest) throw Fail("{}: there is no marker at {:.0f},{:.0f}", name, place_px.x(), place_px.y());
  ForgetDistances(index);
  Give(index, *nearest);
}

void LiveTracker::TakeNames(const std::vector<MarkerSeed>& found) {
  for (const MarkerSeed& seed : found) {
    const std::size_t name = IndexOf(seed.name);
    if (TrackletOf(name)) continue;
    const std::optional<TrackletBuilder::Followed> followed = FollowedAt(seed, !number_[name]);
    if (!followed) continue;
    ForgetDistances(name);
    Give(name, *followed);
  }
}

std::optional<TrackletBuilder::Followed> LiveTracker::FollowedAt(const MarkerSeed& place, bool may_have_ended) const {
  const auto is_it = [&](const Tracklet& tracklet) {
    constexpr double kSamePx = 0.5;
    const TrackletSample* sample = tracklet.SampleIn(place.frame);
    return sample && (sample->position - place.position).norm() < kSamePx;
  };
  for (const TrackletBuilder::Followed& followed : builder_->AllFollowed())
    if (is_it(*followed.tracklet)) return followed;
  if (!may_have_ended) return std::nullopt;
  const auto number =
      -1 - static_cast<std::int64_t>(IndexOf(place.name));  // those of what is followed are not negative
  for (const Tracklet& ended : builder_->Ended())
    if (is_it(ended)) return TrackletBuilder::Followed{number, &ended};
  return std::nullopt;
}

// It may be elsewhere now, as a joint that was moved.
void LiveTracker::ForgetDistances(std::size_t name) {
  std::erase_if(distances_, [&](const auto& one) { return one.first.first == name || one.first.second == name; });
}

bool LiveTracker::IsAnyLost() const {
  constexpr double kLost_s = 1;
  for (std::size_t n = 0; n < number_.size(); ++n)
    if (!number_[n] || (!TrackletOf(n) && measured_.time_s.back() - filters_[n].seen_s > kLost_s)) return true;
  return false;
}

bool LiveTracker::HasAllNames() const {
  return std::ranges::all_of(number_, [](const auto& number) { return number.has_value(); });
}

std::vector<LiveSpot> LiveTracker::Spots() const {
  std::vector<LiveSpot> spots;
  for (const TrackletBuilder::Followed& followed : builder_->AllFollowed()) {
    const TrackletSample& last = followed.tracklet->samples.back();
    if (measured_.frame.empty() || last.frame != measured_.frame.back()) continue;
    const auto named = std::ranges::find(number_, std::optional(followed.number));
    spots.push_back(
        {.number = followed.number,
         .position = last.position,
         .radius_px = last.radius_px,
         .name = named == number_.end() ? "" : options_.names[static_cast<std::size_t>(named - number_.begin())]});
  }
  return spots;
}

void LiveTracker::LearnDistances() {
  std::vector<std::optional<Vector2d>> places(number_.size());
  for (std::size_t n = 0; n < places.size(); ++n)
    if (const TrackletSample* sample = SeenNow(n)) places[n] = MetricOf(sample->position);
  for (std::size_t a = 0; a < places.size(); ++a)
    for (std::size_t b = a + 1; b < places.size(); ++b) {
      if (!places[a] || !places[b]) continue;
      Distance& distance = distances_[{a, b}];
      const double off = (*places[a] - *places[b]).norm() - distance.mean;
      ++distance.count;
      distance.mean += off / distance.count;
      distance.squares += off * ((*places[a] - *places[b]).norm() - distance.mean);
    }
}

void LiveTracker::FilterAll(double time_s) {
  // A filter that expects a quick rise leans on the measurement more than most need, and never lags.
  const double density_px = options_.physics.quick_mm2_s5 / (options_.mm_per_px * options_.mm_per_px);
  const dynamics::MotionPrior prior = dynamics::PersonPrior(options_.mm_per_px);
  for (std::size_t n = 0; n < filters_.size(); ++n) {
    Filter& filter = filters_[n];
    const TrackletSample* seen = SeenNow(n);
    if (filter.state && time_s - filter.seen_s > kForgotten_s) filter.state.reset();
    if (filter.state) filter.state = dynamics::Moved(*filter.state, time_s - filter.time_s, density_px);
    if (seen) {
      const dynamics::PathSample sample{time_s, seen->position, seen->sigma_px * sigma_factor_};
      if (filter.state)
        dynamics::Observe(sample, *filter.state);
      else
        filter.state = dynamics::StartAt(sample, prior);
      filter.seen_s = time_s;
    }
    filter.time_s = time_s;
    if (!filter.state || time_s - filter.seen_s > kForetold_s) continue;
    reported_.markers[n].samples.back() = {filter.state->Position(), std::sqrt(filter.state->covariance(0, 0)),
                                           seen ? motion::SampleStatus::kDetected : motion::SampleStatus::kFilled};
  }
}

// Names that have lost their tracklets, and unnamed tracklets that may continue them. The assignment of least cost is
// taken where no other is nearly as good.
struct LiveTracker::Rejoining {
  static constexpr double kUnassigned = 3;  // costs more than any candidate that fits
  static constexpr double kClear = 0.5;     // between the best and the next
  static constexpr std::size_t kMostCandidates = 12;

  const LiveTracker& tracker;
  std::vector<std::size_t> lost;
  std::vector<TrackletBuilder::Followed> candidates;
  std::vector<Vector2d> candidate_metric;
  std::vector<std::optional<Vector2d>> name_metric;  // of names that are seen
  std::vector<int> chosen, best;                     // candidate by lost name, -1: none
  double best_cost = std::numeric_limits<double>::infinity(), next_cost = best_cost;

  // Squared, in units of what may be; nullopt for more than that.
  std::optional<double> Cost(std::size_t lost_index, std::size_t candidate) const {
    const std::size_t name = lost[lost_index];
    const TrackletSample& last = candidates[candidate].tracklet->samples.back();
    constexpr double kReachMm = 500;  // as far as a marker of a person ever goes (MotionPrior)
    const double reach_px = kReachMm / tracker.options_.physics.radius_mm * last.radius_px;
    const double away_px = (last.position - *tracker.last_place_px_[name]).norm();
    double cost = std::pow(away_px / reach_px, 2);
    if (cost > 1) return std::nullopt;
    constexpr double kSamePlaceRadii = 3;
    bool has_partner = away_px < kSamePlaceRadii * last.radius_px;
    const auto compare = [&](std::size_t other, const Vector2d& place) {
      const auto found = tracker.distances_.find(std::minmax(name, other));
      if (found == tracker.distances_.end() || !found->second.IsRigid()) return true;
      const double off = (place - candidate_metric[candidate]).norm() / found->second.mean - 1;
      cost += std::pow(off / kLengthTolerance, 2);
      has_partner = true;
      return std::abs(off) <= kLengthTolerance;
    };
    for (std::size_t other = 0; other < name_metric.size(); ++other)
      if (name_metric[other] && !compare(other, *name_metric[other])) return std::nullopt;
    for (std::size_t before = 0; before < lost_index; ++before)
      if (chosen[before] >= 0 && !compare(lost[before], candidate_metric[static_cast<std::size_t>(chosen[before])]))
        return std::nullopt;
    return has_partner ? std::optional(cost) : std::nullopt;
  }

  void Try(std::size_t lost_index, double cost) {
    if (cost >= next_cost) return;
    if (lost_index == lost.size()) {
      next_cost = cost < best_cost ? best_cost : cost;
      if (cost < best_cost) {
        best_cost = cost;
        best = chosen;
      }
      return;
    }
    for (std::size_t candidate = 0; candidate < candidates.size(); ++candidate) {
      if (std::ranges::find(chosen, static_cast<int>(candidate)) != chosen.end()) continue;
      const std::optional<double> more = Cost(lost_index, candidate);
      if (!more) continue;
      chosen[lost_index] = static_cast<int>(candidate);
      Try(lost_index + 1, cost + *more);
      chosen[lost_index] = -1;
    }
    Try(lost_index + 1, cost + kUnassigned);
  }
};

void LiveTracker::Rejoin() {
  Rejoining join{.tracker = *this,
                 .lost = {},
                 .candidates = {},
                 .candidate_metric = {},
                 .name_metric = {},
                 .chosen = {},
                 .best = {}};
  for (std::size_t n = 0; n < number_.size(); ++n)
    if (number_[n] && last_place_px_[n] && !TrackletOf(n)) join.lost.push_back(n);
  if (join.lost.empty()) return;
  constexpr std::size_t kFollowed = 4;  // frames: shorter is chance
  for (const TrackletBuilder::Followed& followed : builder_->AllFollowed()) {
    const TrackletSample& last = followed.tracklet->samples.back();
    const bool is_named = std::ranges::find(number_, std::optional(followed.number)) != number_.end();
    if (is_named || followed.tracklet->samples.size() < kFollowed || last.frame != measured_.frame.back()) continue;
    if (join.candidates.size() == Rejoining::kMostCandidates) break;
    const std::optional<Vector2d> metric = MetricOf(last.position);
    if (!metric) continue;
    join.candidates.push_back(followed);
    join.candidate_metric.push_back(*metric);
  }
  if (join.candidates.empty()) return;
  for (std::size_t n = 0; n < number_.size(); ++n) {
    const TrackletSample* sample = SeenNow(n);
    join.name_metric.push_back(sample ? MetricOf(sample->position) : std::nullopt);
  }
  join.chosen.assign(join.lost.size(), -1);
  join.Try(0, 0);
  if (join.best.empty() || join.next_cost - join.best_cost < Rejoining::kClear) return;
  for (std::size_t i = 0; i < join.lost.size(); ++i)
    if (join.best[i] >= 0) Give(join.lost[i], join.candidates[static_cast<std::size_t>(join.best[i])]);
}

LiveSnapshot LiveTracker::Snapshot() const {
  LiveSnapshot snapshot{.tracklets = builder_->SoFar(),
                        .frames = EmptyRecording({}),
                        .discontinuities = builder_->Discontinuities(),
                        .repeated = builder_->RepeatedFrames()};
  snapshot.frames.frame = measured_.frame;
  snapshot.frames.time_s = measured_.time_s;
  return snapshot;
}

std::vector<Tracklet> LiveTracker::Named(std::size_t samples) const {
  std::vector<Tracklet> named;
  for (std::size_t n = 0; n < number_.size(); ++n) {
    const Tracklet* tracklet = TrackletOf(n);
    if (!tracklet) continue;
    const std::size_t count = std::min(samples, tracklet->samples.size());
    named.push_back({{tracklet->samples.end() - static_cast<std::ptrdiff_t>(count), tracklet->samples.end()}, {}});
  }
  return named;
}

}  // namespace lake::tracking
