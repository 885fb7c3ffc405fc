#include "seed_check.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lake/core/error.h"
#include "lake/tracking/candidates.h"

namespace lake::tracking {
namespace {

constexpr int kLeastFrames = 12;

std::string PlaceText(const Tracklet& tracklet) {
  const TrackletSample& first = tracklet.samples.front();
  return fmt::format("({:.1f}, {:.1f}) in frame {}", first.position.x(), first.position.y(), first.frame);
}

// The leg's markers beside one of them.
std::vector<std::size_t> NeighboursOf(std::size_t marker, std::size_t markers) {
  std::vector<std::size_t> neighbours;
  if (marker > 0) neighbours.push_back(marker - 1);
  if (marker + 1 < markers) neighbours.push_back(marker + 1);
  return neighbours;
}

class SeedChecker {
 public:
  SeedChecker(const MetricTracklets& tracklets, const SeededLeg& leg) : tracklets_(tracklets), leg_(leg) {}

  void Run() const {
    for (std::size_t m = 0; m < leg_.names.size(); ++m)
      if (leg_.seeds[m]) CheckMoves(m);
    for (std::size_t m = 0; m < leg_.names.size(); ++m) CheckAgainstOthers(m);
    for (std::size_t m = 0; m < leg_.names.size(); ++m)
      if (leg_.seeds[m]) CheckDistances(m);
  }

 private:
  // All but the ankle are carried along when the leg moves.
  void CheckMoves(std::size_t marker) const {
    if (marker == 0) return;
    double most = 0;
    std::size_t mover = 0;
    for (std::size_t m = 0; m < leg_.tracklets.size(); ++m) {
      const double extent = TrimmedExtentPx(tracklets_[leg_.tracklets[m]]);
      if (m != marker && extent > most) {
        most = extent;
        mover = m;
      }
    }
    const Tracklet& own = tracklets_[leg_.tracklets[marker]];
    const double extent = TrimmedExtentPx(own), radius = own.RadiusPx();
    constexpr double kCarried = 0.02;  // of what the other moves
    if (most < 10 * radius || extent > std::max(kCarried * most, 1.0)) return;
    throw Fail(
        "{}: what is at {} stays where it is (within {:.1f} px) while the {} moves by {:.0f} px: a lamp or a "
        "reflection, no part of the leg; put the seed on the marker, or leave it out",
        SeedText(*leg_.seeds[marker]), PlaceText(own), extent, leg_.names[mover], most);
  }

  // How far more constant the lengths of the leg are with `other` in the marker's place than with what is there: by the
  // logarithms of their relative deviations, over both neighbours. Below a floor, differences say nothing; it is lower
  // where with `other` no length changes at all, which skin's do, and no chance makes.
  double Gain(std::size_t other, std::size_t marker) const {
    constexpr double kRigid = 0.0015, kFloor = 0.004, kFloorOfRigid = 0.001;
    const auto deviation = [&](std::size_t tracklet, std::size_t neighbour) {
      return tracklets_.Distance(leg_.tracklets[neighbour], tracklet).deviation;
    };
    const std::vector<std::size_t> neighbours = NeighboursOf(marker, leg_.tracklets.size());
    const bool is_rigid = std::ranges::all_of(neighbours, [&](std::size_t n) { return deviation(other, n) < kRigid; });
    const double floor = is_rigid ? kFloorOfRigid : kFloor;
    double gain = 0;
    for (const std::size_t n : neighbours)
      gain +=
          std::log(std::hypot(deviation(leg_.tracklets[marker], n), floor) / std::hypot(deviation(other, n), floor));
    return gain;
  }

  std::string Variations(std::size_t tracklet, std::size_t marker) const {
    std::string text;
    for (const std::size_t other : NeighboursOf(marker, leg_.tracklets.size()))
      text += fmt::format("{}{:.1f} % to {}", text.empty() ? "" : " and ",
                          100 * tracklets_.Distance(leg_.tracklets[other], tracklet).deviation, leg_.names[other]);
    return text;
  }

  // Something else in the marker's place would make a leg whose lengths are far more constant. Real skin moves alike
  // under two markers beside each other, so nothing is said of small differences.
  void CheckAgainstOthers(std::size_t marker) const {
    const auto better = BetterInPlaceOf(marker);
    if (!better) return;
    const std::size_t own = leg_.tracklets[marker];
    const std::string contradiction =
        fmt::format("the distances of what is at {} change by {}, those of what is at {} by {}: that is the {}",
                    PlaceText(tracklets_[own]), Variations(own, marker), PlaceText(tracklets_[*better]),
                    Variations(*better, marker), leg_.names[marker]);
    const TrackletSample& first = tracklets_[*better].samples.front();
    const std::string remedy = fmt::format("--seed {}={:.0f},{:.0f}@{}", leg_.names[marker], first.position.x(),
                                           first.position.y(), first.frame);
    if (leg_.seeds[marker])
      throw Fail("{}: {}; say {}, or leave the seed out", SeedText(*leg_.seeds[marker]), contradiction, remedy);
    throw Fail("{}: {}; put the seed on the {}", SeedText(*SeedOfOther(*better)), contradiction,
               SeedOfOther(*better)->name);
  }

  // nullptr for what no other marker's seed leads to.
  const MarkerSeed* SeedOfOther(std::size_t tracklet) const {
    const auto other = std::ranges::find(leg_.others, tracklet, &Seeded::tracklet);
    return other == leg_.others.end() ? nullptr : other->seed;
  }

  // For a marker that was found without a seed only what another's seed took away from it.
  std::optional<std::size_t> BetterInPlaceOf(std::size_t marker) const {
    constexpr double kFarBetter = 1.2;
    if (!leg_.seeds[marker] && leg_.others.empty()) return std::nullopt;
    LegChainOptions options;
    options.markers = leg_.tracklets.size();
    options.up = leg_.up;
    options.fixed.assign(leg_.tracklets.begin(), leg_.tracklets.end());
    options.fixed[marker].reset();
    const std::size_t own = leg_.tracklets[marker];
    std::optional<std::size_t> best;
    double most = kFarBetter;
    for (const LegChain& chain : FindLegChains(tracklets_, options)) {
      const std::size_t other = chain.tracklets[marker];
      if (other == own || CommonFrames(tracklets_[other], tracklets_[own]) < kLeastFrames) continue;
      if (!leg_.seeds[marker] && !SeedOfOther(other)) continue;
      if (const double gain = Gain(other, marker); gain > most) {
        most = gain;
        best = other;
      }
    }
    return best;
  }

  void CheckDistances(std::size_t marker) const {
    constexpr double kMostDeviation = 0.15;  // swapped names and lamps change by a quarter and more, skin by 0.05
    for (const std::size_t other : NeighboursOf(marker, leg_.tracklets.size())) {
      const PairDistance& pair = tracklets_.Distance(leg_.tracklets[other], leg_.tracklets[marker]);
      if (pair.frames < kLeastFrames || pair.deviation < kMostDeviation) continue;
      throw Fail(
          "{}: the distance of what is at {} to the {} changes by {:.0f} % (SD), which no limb's does: put the seed on "
          "the marker, or leave it out",
          SeedText(*leg_.seeds[marker]), PlaceText(tracklets_[leg_.tracklets[marker]]), leg_.names[other],
          100 * pair.deviation);
    }
  }

  const MetricTracklets& tracklets_;
  const SeededLeg& leg_;
};

}  // namespace

std::string SeedText(const MarkerSeed& seed) {
  if (seed.candidate) return fmt::format("--seed {}=#{}", seed.name, *seed.candidate);
  return fmt::format("--seed {}={},{}@{}", seed.name, seed.position.x(), seed.position.y(), seed.frame);
}

void CheckSeededLeg(const MetricTracklets& tracklets, const SeededLeg& leg) {
  SeedChecker(tracklets, leg).Run();
}

void CheckSeededJoint(const MetricTracklets& tracklets, const MarkerSeed& seed, std::size_t joint, std::size_t knee) {
  const double moved = TrimmedExtentPx(tracklets[joint]), knee_moved = TrimmedExtentPx(tracklets[knee]);
  constexpr double kCarried = 0.1;  // of the knee's way; a joint beside the knee goes most of it
  if (knee_moved < 4 * tracklets[knee].RadiusPx() || moved > kCarried * knee_moved) return;
  throw Fail(
      "{}: what is at {} stays where it is (within {:.1f} px) while the knee moves by {:.0f} px: a lamp or a "
      "reflection, no joint on the leg; put the seed on the marker",
      SeedText(seed), PlaceText(tracklets[joint]), moved, knee_moved);
}

}  // namespace lake::tracking
