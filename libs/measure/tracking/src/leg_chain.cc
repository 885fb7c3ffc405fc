#include "leg_chain.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

#include "lake/core/statistics.h"

namespace lake::tracking {
namespace {

constexpr int kMinCommonFrames = 12;
// Skin, perspective and a plane that is not parallel to the image change a segment's apparent length by a few per cent.
constexpr double kMaxDeviation = 0.10;
// Below this, differences in how constant a length is say nothing.
constexpr double kDeviationFloor = 0.004;
// Chains whose costs differ by less are not distinguished: a factor of 1.8 in the deviation of one segment.
constexpr double kAmbiguousCost = 1.2;

// What is carried along by the leg moves by this share of the thigh's length at least; what rests while the hip moves
// is a lamp, where there is more than the leg to be seen. A prototype on a bench has its shank clamped.
constexpr double kCarried = 0.04;

// Of the logarithm: markers of one set are alike, but one is seen more obliquely or lit less than another.
constexpr double kBrightnessDeviation = 0.7;

double Squared(double x) {
  return x * x;
}

double LogAmplitude(const Tracklet& tracklet) {
  std::vector<double> amplitudes;
  amplitudes.reserve(tracklet.samples.size());
  for (const TrackletSample& sample : tracklet.samples) amplitudes.push_back(sample.amplitude);
  return std::log(std::max(Median(std::move(amplitudes)), 1.0));
}

class ChainSearch {
 public:
  ChainSearch(const MetricTracklets& tracklets, const LegChainOptions& options)
      : tracklets_(tracklets), options_(options) {
    for (std::size_t i = 0; i < tracklets.size(); ++i) {
      extent_.push_back(tracklets.Extent(i));
      brightness_.push_back(LogAmplitude(tracklets[i]));
      detected_ += IsLongEnough(i) ? 1 : 0;
      longest_ = std::max(longest_, tracklets[i].samples.size());
    }
  }

  std::vector<LegChain> Run() {
    Extend({}, 0);
    std::sort(chains_.begin(), chains_.end(), [](const LegChain& a, const LegChain& b) { return a.cost < b.cost; });
    return std::move(chains_);
  }

 private:
  bool MayBe(std::size_t tracklet, std::size_t marker) const {
    if (marker < options_.fixed.size() && options_.fixed[marker]) return *options_.fixed[marker] == tracklet;
    return std::find(options_.excluded.begin(), options_.excluded.end(), tracklet) == options_.excluded.end() &&
           IsLongEnough(tracklet);
  }

  bool IsLongEnough(std::size_t tracklet) const { return tracklets_[tracklet].samples.size() >= kMinCommonFrames; }

  bool IsCarried(std::size_t tracklet, double thigh) const { return extent_[tracklet] >= kCarried * thigh; }

  // On a bench, with nothing else in sight.
  bool IsClamped(std::size_t ankle, std::size_t knee, double thigh) const {
    return detected_ <= options_.markers && !IsCarried(ankle, thigh) && !IsCarried(knee, thigh);
  }

  // Whether two segments turn against each other in a joint: three markers of one segment keep all of their distances.
  bool Bends(std::size_t lower, std::size_t joint, std::size_t upper) const {
    constexpr double kLeast = 0.02, kStiffer = 1.5;
    const PairDistance& ends = tracklets_.Distance(lower, upper);
    const double stiffness =
        std::max(tracklets_.Distance(lower, joint).deviation, tracklets_.Distance(joint, upper).deviation);
    return ends.frames >= kMinCommonFrames && ends.deviation >= std::max(kLeast, kStiffer * stiffness);
  }

  bool IsFixed(std::size_t marker) const {
    return marker < options_.fixed.size() && options_.fixed[marker].has_value();
  }

  // `marker`: the upper one.
  bool IsSegment(std::size_t lower, std::size_t upper, std::size_t marker) const {
    const PairDistance& pair = tracklets_.Distance(lower, upper);
    const bool is_evident =
        marker > 2 || IsFixed(marker - 1) || IsFixed(marker) || pair.frames >= options_.least_frames;
    return is_evident && pair.frames >= kMinCommonFrames && pair.deviation < kMaxDeviation && pair.mean > 0;
  }

  void Extend(std::vector<std::size_t> chain, double cost) {
    const std::size_t marker = chain.size();
    if (marker == options_.markers) {
      chains_.push_back({chain, cost});
      return;
    }
    for (std::size_t i = 0; i < tracklets_.size(); ++i) {
      if (!MayBe(i, marker) || std::find(chain.begin(), chain.end(), i) != chain.end()) continue;
      if (marker > 0 && !IsSegment(chain.back(), i, marker)) continue;
      chain.push_back(i);
      if (const auto added = CostOfLast(chain)) Extend(chain, cost + *added);
      chain.pop_back();
    }
  }

  // What the last marker of a chain adds; nullopt if it cannot be there.
  std::optional<double> CostOfLast(const std::vector<std::size_t>& chain) const {
    const std::size_t last = chain.back();
    if (chain.size() == 1) return 0;
    const std::size_t before = chain[chain.size() - 2];
    const PairDistance& segment = tracklets_.Distance(before, last);
    // Against two objects that have nothing to do with each other: their distance changes as they move. What neither
    // end's movement tests, as between two lamps, says nothing.
    constexpr double kTested = 0.2;  // of the length: more movement is no more evidence, as the body moves as a whole
    const double moved = std::min(kTested, std::hypot(extent_[before], extent_[last]) / segment.mean);
    double cost = std::log(Squared(segment.deviation) + Squared(kDeviationFloor)) -
                  std::log(Squared(moved) + Squared(kDeviationFloor)) - 2 * std::log(CommonShare(before, last)) +
                  Squared((brightness_[last] - brightness_[before]) / kBrightnessDeviation);
    // While both are seen: a seated person's waist is lower than a standing one's hip.
    const double rise = options_.up.dot(tracklets_.MeanWay(before, last));
    if (chain.size() == 2) return rise > 0.3 * segment.mean ? std::optional(cost) : std::nullopt;
    if (chain.size() == 3) {
      const auto knee = CostOfKnee(chain);
      return knee ? std::optional(cost + *knee) : std::nullopt;
    }
    // The waist is above the hip, from the pelvis (0.28 thighs away) up to the shoulder (1.5, where a squat turns the
    // thigh aside 1.7).
    constexpr double kWaist = 0.65, kWaistDeviation = 0.6, kFarthestWaist = 2;
    const double thigh = tracklets_.Distance(chain[1], chain[2]).mean;
    if (rise < 0.3 * segment.mean || segment.mean > kFarthestWaist * thigh || !IsCarried(last, thigh))
      return std::nullopt;
    // A hip that keeps still while the knee flexes is one person's in twenty; three markers of a thigh always do.
    constexpr double kStill = 6;  // −2 ln (1 / 20)
    if (!Bends(chain[1], chain[2], last)) cost += kStill;
    return cost + Squared(std::log(segment.mean / (kWaist * thigh)) / kWaistDeviation);
  }

  // Ankle, knee and hip: the knee flexes; the hip moves, the ankle hardly, or the person walks; shank and thigh are
  // about as long.
  std::optional<double> CostOfKnee(const std::vector<std::size_t>& chain) const {
    const auto [ankle, knee, hip] = std::tuple(chain[0], chain[1], chain[2]);
    const double shank = tracklets_.Distance(ankle, knee).mean, thigh = tracklets_.Distance(knee, hip).mean;
    if (!Bends(ankle, knee, hip)) return std::nullopt;
    const bool walks = Walks(ankle, knee, hip, thigh);
    // Nobody's hip is as low as the ankle; two feet are.
    constexpr double kLeastHeight = 0.2;  // of the shank's length; in a deep squat it is half of it
    if (extent_[hip] < (walks ? kCarried : 0.2) * thigh ||
        options_.up.dot(tracklets_.MeanWay(ankle, hip)) < kLeastHeight * shank)
      return std::nullopt;
    if (!IsCarried(knee, thigh) && !IsClamped(ankle, knee, thigh)) return std::nullopt;
    constexpr double kRatioDeviation = 0.15;  // of log(shank / thigh); anatomically 0.1, as much again by the markers
    constexpr double kAnkleMotion = 0.15;     // ankle's extent over hip's
    constexpr double kWalks = 6;              // −2 ln (1 / 20): the part of all recordings
    const double stands = Squared(AnkleOverHip(ankle, hip, thigh) / kAnkleMotion);
    return Squared(std::log(shank / thigh) / kRatioDeviation) + (walks ? std::min(kWalks, stands) : stands);
  }

  // Whether the ankle swings before and behind the hip, farther than the knee does, while the hip keeps its height.
  bool Walks(std::size_t ankle, std::size_t knee, std::size_t hip, double thigh) const {
    constexpr double kLeastSwing = 0.5, kMostRise = 0.3;  // of the thigh's length
    const Eigen::Vector2d forward(options_.up.y(), -options_.up.x());
    const double swing = tracklets_.WayRange(hip, ankle, forward);
    return swing > kLeastSwing * thigh && swing > tracklets_.WayRange(hip, knee, forward) &&
           tracklets_.Range(hip, options_.up) < kMostRise * thigh;
  }

  // The ankle's extent over the hip's while the hip moves as in a sit-to-stand, in the three seconds in which it is
  // least: who walks in first sits down later.
  double AnkleOverHip(std::size_t ankle, std::size_t hip, double thigh) const {
    const auto [found, is_new] = ankle_over_hip_.try_emplace({ankle, hip}, extent_[ankle] / extent_[hip]);
    if (!is_new) return found->second;
    constexpr double kWindow_s = 3, kStep_s = 0.5, kMoved = 0.5;  // of the thigh's length
    const Tracklet &a = tracklets_[ankle], &h = tracklets_[hip];
    const double begin_s = std::max(a.samples.front().time_s, h.samples.front().time_s),
                 end_s = std::min(a.samples.back().time_s, h.samples.back().time_s);
    for (double from_s = begin_s; from_s + 0.5 * kWindow_s < end_s; from_s += kStep_s) {
      const double moved = tracklets_.ExtentIn(hip, from_s, from_s + kWindow_s);
      if (moved < kMoved * thigh) continue;
      found->second = std::min(found->second, tracklets_.ExtentIn(ankle, from_s, from_s + kWindow_s) / moved);
    }
    return found->second;
  }

  // Longer evidence is better evidence.
  double CommonShare(std::size_t a, std::size_t b) const {
    return std::min(1.0, tracklets_.Distance(a, b).frames / static_cast<double>(longest_));
  }

  const MetricTracklets& tracklets_;
  const LegChainOptions& options_;
  std::vector<double> extent_;
  std::vector<double> brightness_;
  std::size_t longest_ = 1;   // samples
  std::size_t detected_ = 0;  // that were seen for long enough to be a marker
  mutable std::map<std::pair<std::size_t, std::size_t>, double> ankle_over_hip_;
  std::vector<LegChain> chains_;
};

bool Contradict(const MetricTracklets& tracklets, const LegChain& a, const LegChain& b) {
  constexpr int kFrames = 5;
  for (std::size_t m = 0; m < a.tracklets.size(); ++m)
    if (a.tracklets[m] != b.tracklets[m] &&
        CommonFrames(tracklets[a.tracklets[m]], tracklets[b.tracklets[m]]) >= kFrames)
      return true;
  return false;
}

}  // namespace

std::vector<LegChain> FindLegChains(const MetricTracklets& tracklets, const LegChainOptions& options) {
  return ChainSearch(tracklets, options).Run();
}

const LegChain* FindRival(const MetricTracklets& tracklets, const std::vector<LegChain>& chains) {
  for (std::size_t i = 1; i < chains.size() && chains[i].cost < chains.front().cost + kAmbiguousCost; ++i)
    if (Contradict(tracklets, chains.front(), chains[i])) return &chains[i];
  return nullptr;
}

}  // namespace lake::tracking
