#include "lake/tracking/naming.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <compare>
#include <map>
#include <numbers>
#include <optional>

#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/tracking/candidates.h"
#include "leg_chain.h"
#include "name_together.h"
#include "path_join.h"
#include "rigidity.h"
#include "seed_check.h"
#include "stitch.h"

namespace lake::tracking {
namespace {

constexpr double kToleranceDeviations = 3;  // standard deviations of a distance in its tolerance

// Two names whose distance stays constant.
struct Link {
  std::size_t a, b;  // indices of names
  double length, tolerance;
  Eigen::Vector2d side;  // of a on which b is, unit length; 0: any

  // `way`: from one to the other.
  bool IsTurnedOver(std::size_t from, const Eigen::Vector2d& way) const {
    return (from == a ? 1 : -1) * side.dot(way) < 0;
  }
};

std::string Describe(const Tracklet& tracklet) {
  const TrackletSample& first = tracklet.samples.front();
  return fmt::format("({:.1f}, {:.1f}) in frame {}", first.position.x(), first.position.y(), first.frame);
}

std::string DescribeAll(const MetricTracklets& tracklets, const std::vector<std::size_t>& indices) {
  std::string text;
  for (const std::size_t i : indices) text += (text.empty() ? "" : ", ") + Describe(tracklets[i]);
  return text;
}

// The longest-seen tracklets, for a message.
std::vector<std::size_t> MostSeen(const MetricTracklets& tracklets, std::size_t count) {
  std::vector<std::size_t> order(tracklets.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return tracklets[a].samples.size() > tracklets[b].samples.size();
  });
  order.resize(std::min(order.size(), count));
  return order;
}

// A person may walk in a plane that is turned about the vertical by an angle. What is seen of such a plane, where it
// would be seen of the unturned one. The focal length is taken to be 0.9 widths of the picture, as telephones have it.
Eigen::Vector2d Unturned(const Eigen::Vector2d& px, double turn_rad, const NamingOptions& options) {
  const double distance = 0.9 * options.picture.sizes().maxCoeff(), cosine = std::cos(turn_rad),
               receding = std::sin(turn_rad) / distance;
  const Eigen::Vector2d up = options.up_px.normalized(), right(-up.y(), up.x()), middle = options.picture.center(),
                        way = px - middle;
  // A place (x, y) of the turned plane is seen at (x cos α, y) / (1 + x sin α / d).
  const double x = way.dot(right) / (cosine - receding * way.dot(right)), y = way.dot(up) * (1 + receding * x);
  return middle + x * right + y * up;
}

class Namer {
 public:
  Namer(std::vector<Tracklet> tracklets, const NamingOptions& options, motion::MarkerRecording& recording)
      : options_(options),
        physics_(options.physics),
        recording_(recording),
        tracklets_px_(std::move(tracklets)),
        tracklets_(tracklets_px_, options.metric_from_px),
        owner_(tracklets_px_.size()),
        time_s_(recording.time_s) {
    anchor_.resize(options.names.size());
    recording_.markers.clear();
    for (const std::string& name : options.names)
      recording_.markers.push_back({name, std::vector<motion::MarkerSample>(recording.Frames())});
    for (const Tracklet& tracklet : tracklets_px_) radii_px_.push_back(tracklet.RadiusPx());
    for (std::size_t i = 0; i < recording_.Frames(); ++i) index_of_frame_[recording_.frame[i]] = i;
    for (const Tracklet& tracklet : tracklets_px_)
      for (const TrackletSample& sample : tracklet.samples) time_s_[index_of_frame_.at(sample.frame)] = sample.time_s;
    metric_.assign(options.names.size(), std::vector<std::optional<Eigen::Vector2d>>(recording_.Frames()));
  }

  void Run() {
    if (tracklets_.size() < options_.names.size())
      throw Fail(
          "{} markers are wanted ({}), but only {} were seen; is the detector the right one (--detector, --polarity)?",
          options_.names.size(), fmt::join(options_.names, ", "), tracklets_.size());
    AnchorSeeds();
    AnchorIdentities();
    AnchorLeg();
    RequireAnchors();
    CheckSeeds();
    for (std::size_t n = 0; n < anchor_.size(); ++n) Give(n, *anchor_[n]);
    FindLinks();
    LearnQuickDensity();
    JoinPieces();
    for (const MarkerSeed& seed : options_.seeds) CheckSeen(seed);
  }

 private:
  // The leg's markers that are wanted, from the ground up; empty unless ankle, knee and hip are among them.
  std::vector<std::size_t> LegNames() const {
    std::vector<std::size_t> names;
    for (std::string_view marker : kLegMarkers) {
      const std::size_t name = IndexOf(marker);
      if (name < options_.names.size())
        names.push_back(name);
      else if (marker != kLegMarkers.back())
        return {};
    }
    return names;
  }

  const MarkerSeed* SeedOf(std::size_t name) const {
    const auto seed = std::find_if(options_.seeds.begin(), options_.seeds.end(),
                                   [&](const MarkerSeed& s) { return s.name == options_.names[name]; });
    return seed == options_.seeds.end() ? nullptr : &*seed;
  }

  void CheckSeeds() const {
    const std::vector<std::size_t> names = LegNames();
    if (names.empty()) return;
    SeededLeg leg;
    leg.up = MetricUp(options_.up_px);
    for (const std::size_t name : names) {
      leg.names.push_back(options_.names[name]);
      leg.tracklets.push_back(*anchor_[name]);
      leg.seeds.push_back(SeedOf(name));
    }
    for (const MarkerSeed& seed : options_.seeds)
      if (const std::size_t name = IndexOf(seed.name);
          name < options_.names.size() && std::ranges::find(leg.names, seed.name) == leg.names.end())
        leg.others.push_back({*anchor_[name], &seed});
    CheckSeededLeg(tracklets_, leg);
    constexpr const char* kExoKnee = "exo_knee";
    const std::size_t joint = IndexOf(kExoKnee);
    if (joint < options_.names.size() && SeedOf(joint))
      CheckSeededJoint(tracklets_, *SeedOf(joint), *anchor_[joint], *anchor_[IndexOf("knee")]);
  }

  // A marker is seen as long as the leg's others, but for what hides it; noise and glints come and go.
  void CheckSeen(const MarkerSeed& seed) const {
    constexpr double kLeastShare = 0.2;
    const std::vector<std::size_t> names = LegNames();
    if (names.empty()) return;
    const auto seen = [&](std::size_t name) {
      return std::ranges::count_if(recording_.markers[name].samples, [](const auto& s) { return s.IsKnown(); });
    };
    std::ptrdiff_t most = 0;
    for (const std::size_t name : names) most = std::max(most, seen(name));
    const std::ptrdiff_t own = seen(IndexOf(seed.name));
    if (static_cast<double>(own) >= kLeastShare * static_cast<double>(most)) return;
    throw Fail(
        "{}: the detection there is seen in only {} of the {} frames that show the leg: noise, a glint, or a marker "
        "that is "
        "mostly hidden; put the seed on the marker, or leave it out",
        SeedText(seed), own, most);
  }

  std::size_t IndexOf(std::string_view name) const {
    return static_cast<std::size_t>(std::find(options_.names.begin(), options_.names.end(), name) -
                                    options_.names.begin());
  }

  bool IsAnchor(std::size_t tracklet) const {
    return std::find(anchor_.begin(), anchor_.end(), tracklet) != anchor_.end();
  }

  void AnchorSeeds() {
    for (const MarkerSeed& seed : options_.seeds) {
      const std::size_t name = IndexOf(seed.name);
      if (name >= options_.names.size()) continue;
      double nearest = INFINITY;
      std::size_t best = 0;
      for (std::size_t i = 0; i < tracklets_.size(); ++i) {
        const TrackletSample* sample = tracklets_[i].SampleIn(seed.frame);
        if (!sample) continue;
        const double distance = (sample->position - seed.position).norm() - sample->radius_px;
        if (distance < nearest) {
          nearest = distance;
          best = i;
        }
      }
      if (!(nearest <= kSeedSlackPx))
        throw Fail("{}: no marker is seen there{}", SeedText(seed),
                   std::isfinite(nearest)
                       ? fmt::format("; the nearest one in that frame is at {}", DescribeAt(best, seed.frame))
                       : "");
      if (IsAnchor(best)) throw Fail("{}: that marker has another name already", SeedText(seed));
      anchor_[name] = best;
    }
  }

  std::string DescribeAt(std::size_t tracklet, std::int64_t frame) const {
    const TrackletSample& sample = *tracklets_[tracklet].SampleIn(frame);
    return fmt::format("({:.1f}, {:.1f})", sample.position.x(), sample.position.y());
  }

  void AnchorIdentities() {
    for (std::size_t n = 0; n < options_.identities.size(); ++n)
      if (!anchor_[n]) anchor_[n] = MostSeenOf(n);
  }

  // The tracklet that shows a name's identity longest and most strongly. What is no disc (a face, a wall) is less
  // likely a marker, and what rests (a lamp) is not likely one that moves with the leg.
  std::optional<std::size_t> MostSeenOf(std::size_t name) const {
    constexpr double kNoDisc = 0.25, kRests = 0.01, kMarkerQuality = 0.12;
    const bool stays = options_.names[name] == kLegMarkers[0];
    std::optional<std::size_t> best;
    double most = 0;
    for (std::size_t i = 0; i < tracklets_.size(); ++i) {
      if (tracklets_[i].identity != options_.identities[name] || IsAnchor(i)) continue;
      double seen = 0;
      for (const TrackletSample& sample : tracklets_[i].samples)
        seen += sample.amplitude * sample.amplitude * (sample.quality < kMarkerQuality ? 1 : kNoDisc);
      if (!stays && TrimmedExtentPx(tracklets_[i]) < tracklets_[i].RadiusPx()) seen *= kRests;
      if (seen > most) {
        most = seen;
        best = i;
      }
    }
    return best;
  }

  void AnchorLeg() {
    const std::vector<std::size_t> names = LegNames();
    if (std::all_of(names.begin(), names.end(), [&](std::size_t n) { return anchor_[n].has_value(); })) return;
    LegChainOptions chain_options;
    chain_options.markers = names.size();
    chain_options.up = MetricUp(options_.up_px);
    for (const std::size_t name : names) chain_options.fixed.push_back(anchor_[name]);
    for (const auto& anchor : anchor_)
      if (anchor) chain_options.excluded.push_back(*anchor);
    const double enough = EnoughFrames();
    chain_options.least_frames = enough;
    std::vector<LegChain> chains = FindChains(chain_options);
    chain_options.least_frames = 0;
    if (chains.empty()) chains = FindChains(chain_options);
    if (chains.empty()) BlameSeed(names, chain_options);
    if (chains.empty())
      throw Fail(
          "no leg was found among the {} detections: no {} of them keep their distances while the knee flexes; say "
          "where the markers are with --seed NAME=X,Y (seen longest: {}){}",
          tracklets_.size(), names.size(), DescribeAll(tracklets_, MostSeen(tracklets_, 8)),
          TurnThatHelps(chain_options));
    if (const LegChain* rival = FindRival(tracklets_, chains)) ReportAmbiguity(names, chains.front(), *rival);
    RequireEvidence(names, chains.front(), enough);
    for (std::size_t m = 0; m < names.size(); ++m) anchor_[names[m]] = chains.front().tracklets[m];
  }

  // Over less of the picture than this a plane that is turned by 12° changes lengths by less than 6 %.
  bool TravelsFar() const {
    constexpr double kFar = 0.25;  // of the picture's larger side
    if (options_.picture.isEmpty()) return false;
    return std::ranges::any_of(tracklets_px_, [&](const Tracklet& tracklet) {
      Eigen::AlignedBox2d places;
      for (const TrackletSample& sample : tracklet.samples) places.extend(sample.position);
      return !places.isEmpty() && places.sizes().maxCoeff() > kFar * options_.picture.sizes().maxCoeff();
    });
  }

  // The leg's chains in the calibrated plane, and, at a cost, in planes that are turned about the vertical; distances
  // are those in the plane of the best.
  std::vector<LegChain> FindChains(const LegChainOptions& chain_options) {
    constexpr double kTurned = 6;  // −2 ln (1 / 20): the part of all recordings
    std::vector<LegChain> all = FindLegChains(tracklets_, chain_options);
    double least = all.empty() ? INFINITY : all.front().cost;
    if (!TravelsFar()) return all;
    constexpr int kFirst_deg = 12, kStep_deg = 4, kLast_deg = 44;
    for (int turn_deg = -kLast_deg; turn_deg <= kLast_deg; turn_deg += kStep_deg) {
      if (std::abs(turn_deg) < kFirst_deg) continue;
      MetricTracklets turned(tracklets_px_, [&](const Eigen::Vector2d& px) {
        return options_.metric_from_px(Unturned(px, RadiansFromDegrees(turn_deg), options_));
      });
      std::vector<LegChain> chains = FindLegChains(turned, chain_options);
      for (LegChain& chain : chains) chain.cost += kTurned;
      if (!chains.empty() && chains.front().cost < least) {
        least = chains.front().cost;
        tracklets_ = std::move(turned);
      }
      std::ranges::move(chains, std::back_inserter(all));
    }
    std::ranges::sort(all, {}, &LegChain::cost);
    return all;
  }

  // A few frames, in which a leg hardly moves, do not say which is ankle, knee and hip.
  double EnoughFrames() const {
    constexpr double kEnough_s = 1, kEnoughShare = 0.1;  // of the longest that anything is seen
    const double longest = static_cast<double>(tracklets_[MostSeen(tracklets_, 1).front()].samples.size());
    return std::min(kEnoughShare * longest, kEnough_s / MedianInterval(recording_.time_s));
  }

  void RequireEvidence(const std::vector<std::size_t>& names, const LegChain& chain, double enough) const {
    for (const std::size_t m : {1u, 2u}) {
      const std::size_t lower = chain.tracklets[m - 1], upper = chain.tracklets[m];
      const int together = tracklets_.Distance(lower, upper).frames;
      if (anchor_[names[m - 1]] || anchor_[names[m]] || together >= enough) continue;
      const std::string& name = options_.names[names[m]];
      const TrackletSample& first = tracklets_[upper].samples.front();
      throw Fail(
          "the markers cannot be named with certainty: the candidates for {} and {} are seen together in only {} "
          "frames, {} and {}; say where they are, for example --seed {}={:.0f},{:.0f}@{}",
          options_.names[names[m - 1]], name, together, Describe(tracklets_[lower]), Describe(tracklets_[upper]), name,
          first.position.x(), first.position.y(), first.frame);
    }
  }

  // Where no leg holds all seeds, but one without one of them does: throws Error naming that seed.
  void BlameSeed(const std::vector<std::size_t>& names, const LegChainOptions& all) const {
    for (std::size_t m = 0; m < names.size(); ++m) {
      const MarkerSeed* seed = SeedOf(names[m]);
      if (!seed) continue;
      LegChainOptions without = all;
      without.fixed[m].reset();
      if (FindLegChains(tracklets_, without).empty()) continue;
      const Tracklet& own = tracklets_[*anchor_[names[m]]];
      const bool rests = TrimmedExtentPx(own) < own.RadiusPx();
      throw Fail("{}: what is at {} makes no leg with the other markers{}; put the seed on the {}, or leave it out",
                 SeedText(*seed), Describe(own),
                 rests ? ", as it stays where it is while they move: a lamp or a reflection"
                       : ", as its distances to them do not stay what they are",
                 seed->name);
    }
  }

  [[noreturn]] void ReportAmbiguity(const std::vector<std::size_t>& names, const LegChain& best,
                                    const LegChain& rival) const {
    std::string text, seeds;
    for (std::size_t m = 0; m < names.size(); ++m) {
      if (best.tracklets[m] == rival.tracklets[m]) continue;
      const std::string& name = options_.names[names[m]];
      const Tracklet& tracklet = tracklets_[best.tracklets[m]];
      text += fmt::format("{}the {} is at {} or at {}", text.empty() ? "" : ", ", name, Describe(tracklet),
                          Describe(tracklets_[rival.tracklets[m]]));
      seeds += fmt::format(" --seed {}={:.0f},{:.0f}@{}", name, tracklet.samples.front().position.x(),
                           tracklet.samples.front().position.y(), tracklet.FirstFrame());
    }
    throw Fail("the markers cannot be named with certainty: {}; say which, for example{}", text, seeds);
  }

  Eigen::Vector2d MetricUp(const Eigen::Vector2d& up_px) const {
    const Eigen::Vector2d middle = tracklets_[0].samples.front().position;
    return (options_.metric_from_px(middle + up_px) - options_.metric_from_px(middle - up_px)).normalized();
  }

  // For a message: how to turn the pictures so that a leg stands upright in them; empty where no turn does that.
  std::string TurnThatHelps(LegChainOptions options) const {
    const std::array<std::pair<int, Eigen::Vector2d>, 3> turns = {{{90, {-1, 0}}, {180, {0, 1}}, {270, {1, 0}}}};
    for (const auto& [clockwise_deg, up_px] : turns) {
      options.up = MetricUp(up_px);
      if (FindLegChains(tracklets_, options).empty()) continue;
      const int in_all_deg = (options_.rotate_deg + clockwise_deg) % 360;
      return fmt::format("; turned by {}° clockwise{}, a leg stands upright: {}", clockwise_deg,
                         options_.rotate_deg > 0 ? fmt::format(" beyond --rotate {}", options_.rotate_deg) : "",
                         in_all_deg > 0 ? fmt::format("--rotate {}", in_all_deg) : "leave --rotate out");
    }
    return "";
  }

  // A leg's marker whose name has capitals is none of the leg's.
  void CheckCase() const {
    for (const std::string& name : options_.names) {
      std::string lower = name;
      std::ranges::transform(lower, lower.begin(), [](unsigned char c) { return std::tolower(c); });
      if (lower != name && std::ranges::find(kLegMarkers, lower) != kLegMarkers.end())
        throw Fail("marker '{}' cannot be found by itself: names are lower case: {}", name, lower);
    }
  }

  void RequireAnchors() const {
    for (std::size_t n = 0; n < anchor_.size(); ++n) {
      if (anchor_[n]) continue;
      CheckCase();
      std::vector<std::size_t> unnamed = MostSeen(tracklets_, tracklets_.size());
      std::erase_if(unnamed, [&](std::size_t i) { return IsAnchor(i); });
      unnamed.resize(std::min<std::size_t>(unnamed.size(), 8));
      throw Fail("marker '{}' cannot be found by itself; say where it is with --seed {}=X,Y (seen and not named: {})",
                 options_.names[n], options_.names[n], unnamed.empty() ? "nothing" : DescribeAll(tracklets_, unnamed));
    }
  }

  void Give(std::size_t name, std::size_t tracklet) {
    owner_[tracklet] = name;
    for (std::size_t s = 0; s < tracklets_[tracklet].samples.size(); ++s) {
      const TrackletSample& sample = tracklets_[tracklet].samples[s];
      const std::size_t frame = index_of_frame_.at(sample.frame);
      motion::MarkerSample& own = recording_.markers[name].samples[frame];
      if (own.IsKnown()) continue;
      own = {sample.position, sample.sigma_px, motion::SampleStatus::kDetected};
      metric_[name][frame] = tracklets_.Metric(tracklet)[s];
    }
  }

  // A foot swings more quickly than anybody rises: what the anchors show is believed of their continuations.
  void LearnQuickDensity() {
    std::vector<std::vector<dynamics::PathSample>> paths;
    std::vector<double> radii_px;
    for (const auto& anchor : anchor_) {
      const Tracklet& tracklet = tracklets_[*anchor];
      std::vector<dynamics::PathSample>& path = paths.emplace_back();
      for (const TrackletSample& sample : tracklet.samples)
        if (!sample.repeated) path.push_back({sample.time_s, sample.position, sample.sigma_px});
      radii_px.push_back(radii_px_[*anchor]);
    }
    const double mm_per_px = physics_.radius_mm / Median(std::move(radii_px));
    physics_.quick_mm2_s5 =
        std::max(physics_.quick_mm2_s5, mm_per_px * mm_per_px * dynamics::LearnMotion(paths, mm_per_px).density);
  }

  // Neighbours in the leg; for other names whatever anchors keep their distance to theirs.
  void FindLinks() {
    // Skin and perspective change a length by more than the anchors may have shown.
    constexpr double kMaxDeviation = 0.06, kLeastTolerance = 0.05, kDeviations = 4;
    const auto leg_rank = [&](std::size_t n) {
      return std::find(kLegMarkers.begin(), kLegMarkers.end(), options_.names[n]) - kLegMarkers.begin();
    };
    for (std::size_t a = 0; a < anchor_.size(); ++a)
      for (std::size_t b = 0; b < a; ++b) {
        const PairDistance& pair = tracklets_.Distance(*anchor_[a], *anchor_[b]);
        const bool both_leg = leg_rank(a) < 4 && leg_rank(b) < 4;
        if (pair.frames < 5 || (both_leg ? std::abs(leg_rank(a) - leg_rank(b)) != 1 : pair.deviation > kMaxDeviation))
          continue;
        // The waist is above the hip, also where a tracklet that takes its place is as far from it.
        Eigen::Vector2d side = Eigen::Vector2d::Zero();
        if (both_leg && std::max(leg_rank(a), leg_rank(b)) == 3)
          side = (leg_rank(b) == 3 ? 1 : -1) * MetricUp(options_.up_px);
        links_.push_back({a, b, pair.mean, pair.mean * std::max(kLeastTolerance, kDeviations * pair.deviation), side});
      }
  }

  // How badly a tracklet fits a name, best first: tracklets whose neighbours are known go before those without.
  struct FitToName {
    bool without_neighbours = false;
    double misfit = 0;  // minus the logarithm of the odds

    auto operator<=>(const FitToName&) const = default;
  };

  // nullopt if the tracklet cannot be it.
  std::optional<FitToName> Misfit(std::size_t tracklet, std::size_t name) const {
    if (!options_.identities.empty() && tracklets_[tracklet].identity != options_.identities[name]) return std::nullopt;
    const auto continuity = ContinuityMisfit(tracklet, name);
    if (!continuity) return std::nullopt;
    // What says itself which marker it is may move as skin does: four times 19 mm (SD) of a shank of 420 mm.
    constexpr double kSkin = 0.18;
    const double least_tolerance = options_.identities.empty() ? 0 : kSkin;
    double squares = 0;
    int count = 0, bad = 0;
    bool leg_moves = true;  // all that is linked to it and known meanwhile
    for (const Link& link : links_) {
      if (link.a != name && link.b != name) continue;
      const std::size_t other = link.a == name ? link.b : link.a;
      Eigen::AlignedBox2d reach;
      for (std::size_t s = 0; s < tracklets_[tracklet].samples.size(); ++s) {
        const auto& neighbour = metric_[other][index_of_frame_.at(tracklets_[tracklet].samples[s].frame)];
        if (!neighbour) continue;
        const Eigen::Vector2d way = *neighbour - tracklets_.Metric(tracklet)[s];
        const double off = std::abs(way.norm() - link.length) / std::max(link.tolerance, least_tolerance * link.length);
        squares += off * off;
        ++count;
        bad += off > 1 || link.IsTurnedOver(name, way);
        reach.extend(*neighbour);
      }
      constexpr double kMoves = 0.1;  // of the link's length
      leg_moves = leg_moves && (reach.isEmpty() || reach.diagonal().norm() > kMoves * link.length);
    }
    if (count > 0 && bad > 0.2 * count) return std::nullopt;
    if (leg_moves && RestsElsewhere(tracklet, name)) return std::nullopt;
    if (count > 0)
      return FitToName{false, *continuity + 0.5 * kToleranceDeviations * kToleranceDeviations * squares / count};
    return *continuity > 0 ? std::nullopt : std::optional(FitToName{true, *continuity});
  }

  // Whether an object rests where the marker was neither before nor after: a lamp that it passes by.
  bool RestsElsewhere(std::size_t tracklet, std::size_t name) const {
    const auto& samples = recording_.markers[name].samples;
    const double radius = radii_px_[tracklet];
    if (TrimmedExtentPx(tracklets_[tracklet]) > 0.5 * radius) return false;
    const auto is_there = [&](std::size_t frame, const TrackletSample& end) {
      constexpr double kSamePlace = 2;  // radii
      return (samples[frame].position - end.position).norm() < kSamePlace * radius;
    };
    for (std::size_t f = index_of_frame_.at(tracklets_[tracklet].FirstFrame()); f-- > 0;)
      if (samples[f].IsKnown()) {
        if (is_there(f, tracklets_[tracklet].samples.front())) return false;
        break;
      }
    for (std::size_t f = index_of_frame_.at(tracklets_[tracklet].LastFrame()) + 1; f < samples.size(); ++f)
      if (samples[f].IsKnown()) return !is_there(f, tracklets_[tracklet].samples.back());
    return true;
  }

  // A name's known samples beside a frame, but for repeated pictures: those before it (step −1) or after it (1).
  PathEnd KnownBeside(std::size_t name, std::size_t frame, int step) const {
    const auto& samples = recording_.markers[name].samples;
    PathEnd end;
    for (auto f = static_cast<std::ptrdiff_t>(frame) + step; f >= 0 && f < std::ssize(samples); f += step) {
      const auto i = static_cast<std::size_t>(f);
      if (samples[i].IsKnown() && !std::ranges::binary_search(options_.repeated, recording_.frame[i]))
        end.push_back({.time_s = time_s_[i], .position = samples[i].position});
      if (end.size() == kPathEndSamples) break;
    }
    std::ranges::reverse(end);
    return end;
  }

  // The time in which a marker can have moved on; after a discontinuity it can be anywhere.
  double TimeToMoveOn(const PathEnd& before, const PathEnd& after) const {
    const double from_s = before.back().time_s, to_s = after.back().time_s;
    const bool has_discontinuity = std::ranges::any_of(options_.discontinuities, [&](std::int64_t frame) {
      const double at_s = time_s_[index_of_frame_.at(frame)];
      return at_s > from_s && at_s <= to_s;
    });
    return has_discontinuity ? options_.physics.turns_after_s : GapBetween(before, after);
  }

  bool IsAbsence(const PathEnd& before, const PathEnd& after) const {
    return GapBetween(before, after) > options_.physics.turns_after_s && IsAtBorder(before, 1) && IsAtBorder(after, -1);
  }

  // Whether another of the names was beyond the border for most of the time between; a marker that stands where it was
  // lost is carried out later.
  bool WasLegAbsent(const PathEnd& before, const PathEnd& after) const {
    constexpr double kMost = 0.5;
    return std::ranges::any_of(absences_, [&](const auto& absence) {
      const double common_s =
          std::min(absence.second, after.back().time_s) - std::max(absence.first, before.back().time_s);
      return common_s > kMost * (absence.second - absence.first);
    });
  }

  // Where a tracklet is beyond the border before or after what is known of its name.
  void NoteAbsences(std::size_t name, std::size_t tracklet) {
    const auto [first, last] = SpanOf(tracklet);
    for (const auto& [before, after] : {std::pair(KnownBeside(name, first, -1), FirstSamples(tracklets_[tracklet])),
                                        std::pair(LastSamples(tracklets_[tracklet]), KnownBeside(name, last, 1))})
      if (!before.empty() && !after.empty() && IsAbsence(before, after))
        absences_.emplace_back(before.back().time_s, after.back().time_s);
  }

  // Whether the path goes on beyond the picture's border soon after (sign 1) or came from there soon before (−1).
  bool IsAtBorder(const PathEnd& end, double sign) const {
    constexpr double kSoon_s = 0.25;  // the whole picture is searched ten times a second at 60 Hz
    const double elapsed_s = end.back().time_s - end.front().time_s;
    if (options_.picture.isEmpty() || elapsed_s == 0) return false;
    return !options_.picture.contains(end.back().position +
                                      sign * kSoon_s / elapsed_s * (end.back().position - end.front().position));
  }

  // The logarithm of the odds against one path with what is known of the name before and after; nullopt where none is
  // possible, or nothing is known.
  std::optional<double> ContinuityMisfit(std::size_t tracklet, std::size_t name) const {
    const Tracklet& whole = tracklets_[tracklet];
    const auto& samples = recording_.markers[name].samples;
    const auto [first, last] = SpanOf(tracklet);
    constexpr std::size_t kOverlap = 1;
    std::size_t overlap = 0;
    for (std::size_t f = first; f <= last; ++f) overlap += samples[f].IsKnown();
    if (overlap > kOverlap) return std::nullopt;
    const double size = radii_px_[tracklet] / radii_px_[*anchor_[name]];
    if (size < 0.6 || size > 1.7) return std::nullopt;
    std::optional<double> misfit;
    for (const auto& [before, after] : {std::pair(KnownBeside(name, first, -1), FirstSamples(whole)),
                                        std::pair(LastSamples(whole), KnownBeside(name, last, 1))}) {
      if (before.empty() || after.empty()) continue;
      // Who left the picture comes back anywhere: only distances tell the markers.
      if (IsAbsence(before, after) || WasLegAbsent(before, after)) {
        misfit = misfit.value_or(0);
        continue;
      }
      const PathJoin join = JoinPaths(before, after, TimeToMoveOn(before, after), radii_px_[tracklet], physics_);
      constexpr double kFarthest = 30;
      if (join.squares > kFarthest) return std::nullopt;
      misfit = misfit.value_or(0) - join.log_odds;
    }
    return misfit;
  }

  // Frames by their place in the recording, both ends included.
  struct Span {
    std::size_t first = 0, last = 0;

    bool Meets(const Span& other) const { return last >= other.first && first <= other.last; }
  };

  Span SpanOf(std::size_t tracklet) const {
    return {index_of_frame_.at(tracklets_[tracklet].FirstFrame()),
            index_of_frame_.at(tracklets_[tracklet].LastFrame())};
  }

  // The span widened to the nearest known samples of a name beside it.
  Span Widened(Span span, std::size_t name) const {
    const auto& samples = recording_.markers[name].samples;
    while (span.first > 0 && !samples[--span.first].IsKnown()) {
    }
    while (span.last + 1 < samples.size() && !samples[++span.last].IsKnown()) {
    }
    return span;
  }

  // nullptr if there is none.
  const Link* LinkBetween(std::size_t one, std::size_t other) const {
    const auto found = std::ranges::find_if(links_, [&](const Link& link) {
      return (link.a == one && link.b == other) || (link.a == other && link.b == one);
    });
    return found == links_.end() ? nullptr : &*found;
  }

  using Fits = std::vector<std::optional<FitToName>>;  // by tracklet and name

  // By the distance of two tracklets whose names are linked, against two objects that are up to twice as far apart.
  std::optional<double> DistanceMisfit(const NamedTracklet& one, const NamedTracklet& other) const {
    const Link* link = LinkBetween(one.name, other.name);
    if (!link) return 0;
    const PairDistance& pair = tracklets_.Distance(one.tracklet, other.tracklet);
    if (pair.frames == 0) return 0;
    const double off = std::hypot(pair.mean - link->length, pair.mean * pair.deviation) / link->tolerance;
    if (off > 1 || link->IsTurnedOver(one.name, tracklets_.MeanWay(one.tracklet, other.tracklet))) return std::nullopt;
    const double sigma = link->tolerance / kToleranceDeviations, range = 2 * link->length;
    return 0.5 * std::pow(kToleranceDeviations * off, 2) + std::log(std::sqrt(2 * std::numbers::pi) * sigma / range);
  }

  // What is joined next: the best-fitting tracklet or, where its neighbours are not known or something that is seen
  // with it fits its name too, all that is seen with it. Nothing where nothing speaks for it.
  std::vector<NamedTracklet> Next(const NamedTracklet& best, const Fits& fits, const std::vector<Span>& spans) const {
    constexpr std::size_t kMostNames = 8;
    constexpr double kMostChoices = 65536;  // of each name the best-fitting tracklets, or none of them
    const std::size_t names = anchor_.size();
    bool is_certain = !fits[best.tracklet * names + best.name]->without_neighbours;
    for (std::size_t t = 0; t < tracklets_.size(); ++t)
      is_certain &= t == best.tracklet || !fits[t * names + best.name] || !spans[t].Meets(spans[best.tracklet]);
    if (is_certain || names > kMostNames || !options_.identities.empty()) return {best};
    const auto most_tracklets =
        static_cast<std::size_t>(std::pow(kMostChoices, 1 / static_cast<double>(names)) + 1e-9) - 1;
    std::vector<std::vector<NamedTracklet>> choices(names);
    for (std::size_t n = 0; n < names; ++n) {
      std::vector<NamedTracklet>& tracklets = choices[n];
      for (std::size_t t = 0; t < tracklets_.size(); ++t)
        if (const auto& fit = fits[t * names + n]; fit && spans[t].Meets(spans[best.tracklet]))
          tracklets.push_back({t, n, fit->misfit});
      std::ranges::stable_sort(tracklets, {}, &NamedTracklet::misfit);
      tracklets.resize(std::min(tracklets.size(), most_tracklets));
    }
    std::vector<NamedTracklet> together =
        LikeliestTogether(choices, [&](const auto& one, const auto& other) { return DistanceMisfit(one, other); });
    if (together.empty() && best.misfit < 0) return {best};
    return together;
  }

  // What a tracklet changes is how those fit that lie beside it, in its own name and in those linked to it: all others'
  // fits are kept.
  void Join(std::size_t joined, std::size_t name, const std::vector<Span>& spans, Fits& fits) {
    const std::size_t names = anchor_.size();
    const Span own = spans[joined], beside = Widened(own, name);
    NoteAbsences(name, joined);
    Give(name, joined);
    std::fill_n(fits.begin() + static_cast<std::ptrdiff_t>(joined * names), names, std::nullopt);
    for (std::size_t t = 0; t < tracklets_.size(); ++t) {
      if (owner_[t]) continue;
      for (std::size_t n = 0; n < names; ++n)
        if (n == name ? spans[t].Meets(beside) : spans[t].Meets(own) && LinkBetween(n, name))
          fits[t * names + n] = Misfit(t, n);
    }
  }

  // Joins the best-fitting tracklet that is left to its name until none fits.
  void JoinPieces() {
    const std::size_t names = anchor_.size();
    Fits fits(tracklets_.size() * names);
    std::vector<Span> spans;
    // Who left the picture has left it with all markers, whichever tracklet shows it.
    for (std::size_t t = 0; t < tracklets_.size(); ++t)
      for (std::size_t n = 0; n < names && !owner_[t]; ++n) NoteAbsences(n, t);
    for (std::size_t t = 0; t < tracklets_.size(); ++t) {
      spans.push_back(SpanOf(t));
      for (std::size_t n = 0; n < names && !owner_[t]; ++n) fits[t * names + n] = Misfit(t, n);
    }
    while (true) {
      std::optional<FitToName> least;
      std::size_t best = 0;
      for (std::size_t i = 0; i < fits.size(); ++i)
        if (fits[i] && (!least || *fits[i] < *least)) {
          least = fits[i];
          best = i;
        }
      if (!least) return;
      const std::vector<NamedTracklet> joined = Next({best / names, best % names, least->misfit}, fits, spans);
      if (joined.empty()) fits[best].reset();
      for (const NamedTracklet& next : joined) Join(next.tracklet, next.name, spans, fits);
    }
  }

  const NamingOptions& options_;
  MarkerPhysics physics_;
  motion::MarkerRecording& recording_;
  std::vector<Tracklet> tracklets_px_;
  MetricTracklets tracklets_;
  std::vector<double> radii_px_;                    // of each tracklet
  std::vector<std::optional<std::size_t>> owner_;   // name of each tracklet
  std::vector<std::optional<std::size_t>> anchor_;  // tracklet of each name
  std::map<std::int64_t, std::size_t> index_of_frame_;
  std::vector<double> time_s_;                                       // of frames, as in TrackletSample
  std::vector<std::vector<std::optional<Eigen::Vector2d>>> metric_;  // by name and frame
  std::vector<Link> links_;
  std::vector<std::pair<double, double>> absences_;  // of a name from the picture, s
};

// Puts the seeds that name a candidate by its number where it is.
void PlaceCandidates(const std::vector<Tracklet>& tracklets, std::vector<MarkerSeed>& seeds) {
  if (std::ranges::none_of(seeds, [](const MarkerSeed& seed) { return seed.candidate.has_value(); })) return;
  const CandidateList list = ListCandidates(tracklets);
  for (MarkerSeed& seed : seeds) {
    if (!seed.candidate) continue;
    const auto found = std::ranges::find(list.candidates, *seed.candidate, &Candidate::id);
    if (found == list.candidates.end())
      throw Fail("{}: the candidate markers have the numbers 1 to {}", SeedText(seed), list.candidates.size());
    seed.position = found->position;
    seed.frame = found->frame;
  }
}

// Without what is seen where no ray meets the plane, such as a reflection above the horizon of an oblique one.
std::vector<Tracklet> ThatMeetThePlane(std::vector<Tracklet> tracklets,
                                       const std::function<Eigen::Vector2d(const Eigen::Vector2d&)>& metric_from_px) {
  const auto misses = [&](const TrackletSample& sample) {
    try {
      return !metric_from_px(sample.position).allFinite();
    } catch (const Error&) {
      return true;
    }
  };
  for (Tracklet& tracklet : tracklets) std::erase_if(tracklet.samples, misses);
  std::erase_if(tracklets, [](const Tracklet& tracklet) { return tracklet.samples.empty(); });
  return tracklets;
}

}  // namespace

void NameTracklets(const std::vector<Tracklet>& tracklets, const NamingOptions& options,
                   motion::MarkerRecording& recording) {
  NamingOptions placed = options;
  PlaceCandidates(tracklets, placed.seeds);
  Namer(StitchPieces(ThatMeetThePlane(tracklets, options.metric_from_px), options.physics), placed, recording).Run();
}

}  // namespace lake::tracking
