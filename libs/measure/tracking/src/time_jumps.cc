#include "time_jumps.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "leg_scale.h"
#include "local_path.h"

namespace lake::tracking {
namespace {

constexpr double kLeastOffPx = 0.7;  // root mean square over the markers: paths less apart than that are one

// Frames by their place in the recording.
class TimeJumpFinder {
 public:
  TimeJumpFinder(bool at_lower_rate, RepeatedFrames& frames, motion::MarkerRecording& recording)
      : recording_(recording),
        frames_(frames),
        at_lower_rate_(at_lower_rate),
        fresh_s_(UsualInterval(recording, frames.Fresh())),
        mm_per_px_(MillimetresPerPx(recording)) {}

  // The largest first, as it spoils the paths on which the neighbours are judged.
  std::vector<TimeJump> Take() {
    constexpr std::size_t kMost = 20;
    std::vector<TimeJump> jumps;
    std::vector<std::size_t> fresh = frames_.Fresh();
    std::vector<Cut> cuts;
    const std::vector<double> stamps_s = recording_.time_s;
    FindJumps(fresh);
    while (true) {
      std::optional<FoundJump> largest;
      for (const auto& jump : found_)
        if (jump && (!largest || jump->off_px > largest->off_px)) largest = jump;
      if (!largest) break;
      if (IsMadeByRepeats(*largest, fresh)) continue;
      if (jumps.size() + cuts.size() == kMost)
        throw Fail(
            "the motion jumps in more than {} places (frames {} and {} are one of them): the frames' times are not "
            "those at which they were taken; record at a fixed frame rate, and track the camera's own file",
            kMost, recording_.frame[fresh[largest->at - 1]], recording_.frame[fresh[largest->at]]);
      const std::size_t before = fresh[largest->at - 1], after = fresh[largest->at];
      barriers_.push_back(after);
      if (largest->is_cut) {
        cuts.push_back(CutAt(fresh, largest->at));
        FindJumps(fresh);
        continue;
      }
      const double stamped_s = recording_.time_s[after] - recording_.time_s[before];
      jumps.push_back(
          {recording_.frame[before], recording_.frame[after], stamped_s, largest->moved_s, largest->sigma_s});
      for (std::size_t i = after; i < recording_.Frames(); ++i) recording_.time_s[i] += largest->moved_s - stamped_s;
      FindJumps(fresh);
    }
    if (!cuts.empty()) ThrowCuts(cuts, stamps_s);
    if (!jumps.empty()) frames_.SpreadTimes();
    std::sort(jumps.begin(), jumps.end(), [](const TimeJump& a, const TimeJump& b) { return a.before < b.before; });
    return jumps;
  }

 private:
  // The markers on both sides of a pair of new frames.
  struct Sides {
    std::vector<PathPoint> before, after;
    std::vector<Eigen::Vector2d> apart;
  };

  bool IsBarrier(std::size_t frame) const {
    return std::find(barriers_.begin(), barriers_.end(), frame) != barriers_.end();
  }

  // A marker that has come far may be lost for some frames before it is followed again.
  static constexpr int kFewest = 4, kMayBeLost = 4;  // frames of a side
  static constexpr double kReach_s = 0.11;           // a leg's path is a parabola for about as long

  std::optional<PathPoint> OneSide(const motion::MarkerTrack& marker, const std::vector<std::size_t>& fresh,
                                   std::size_t at, int direction) const {
    LocalPath path(2, recording_.time_s[fresh[at]]);
    int count = 0, lost = 0;
    for (auto k = static_cast<std::ptrdiff_t>(at); k >= 0 && k < static_cast<std::ptrdiff_t>(fresh.size());
         k += direction) {
      const std::size_t i = fresh[static_cast<std::size_t>(k)];
      const bool is_far = std::abs(recording_.time_s[i] - recording_.time_s[fresh[at]]) > kReach_s;
      if (is_far && count >= kFewest) break;
      if (marker.samples[i].IsKnown())
        path.Add(recording_.time_s[i], marker.samples[i].position), ++count;
      else if (++lost > kMayBeLost)
        break;
      const std::size_t edge = direction > 0 ? static_cast<std::size_t>(k) + 1 : static_cast<std::size_t>(k);
      if (edge < fresh.size() && IsBarrier(fresh[edge])) break;
    }
    return count >= kFewest ? std::optional(path.Fit()) : std::nullopt;
  }

  struct FoundJump {
    std::size_t at = 0;  // of the fresh frames, the one after
    double moved_s = 0, sigma_s = 0, off_px = 0;
    bool is_cut = false;  // no time explains it
  };

  // Whether what lies between both sides is more than a leg can do in that time: two markers at least are elsewhere,
  // though their speed may have changed at once. What impacts and an encoder's frozen blocks do, bends the paths before
  // or after as well.
  bool IsCut(const Sides& sides, double elapsed_s) const {
    constexpr double kLeast_mm = 6, kLeastPx = 2;
    constexpr double kMost_mm_s2 = 50e3;   // standing up 5e3
    constexpr double kOfSpeedStep = 0.65;  // 0.5 if at either end of the interval, and what parabolas know of speeds
    constexpr double kTimesScatter = 8;
    if (!(mm_per_px_ > 0)) return false;
    const double least_px =
        std::max({kLeastPx, kLeast_mm / mm_per_px_, kMost_mm_s2 / mm_per_px_ * elapsed_s * elapsed_s / 4});
    int beyond = 0;
    for (std::size_t m = 0; m < sides.apart.size(); ++m) {
      const PathPoint &a = sides.before[m], &b = sides.after[m];
      const double may_be_px = least_px + kOfSpeedStep * elapsed_s * (b.velocity - a.velocity).norm() +
                               kTimesScatter * std::hypot(a.off_px, b.off_px);
      beyond += Off(sides, m, elapsed_s).norm() > may_be_px;
    }
    return beyond >= 2;
  }

  // Time is all markers' own: of one that moves alone, as the trunk's where a movement begins, what an encoder leaves
  // behind for some frames passes for it. A marker counts that went farther in that time than its paths scatter.
  static bool IsOfSeveral(const Sides& sides, double stamped_s, double moved_s) {
    constexpr double kTimesScatter = 4, kLeastPx = kLeastOffPx / 2;
    int farther = 0;
    for (std::size_t m = 0; m < sides.apart.size(); ++m)
      farther += (Off(sides, m, stamped_s) - Off(sides, m, moved_s)).norm() >
                 std::max(kLeastPx, kTimesScatter * std::hypot(sides.before[m].off_px, sides.after[m].off_px));
    return farther >= 2;
  }

  // Whether the way between both sides can be made in this time at a speed between theirs: an actuator starts and stops
  // at once.
  static bool IsWithinItsSpeeds(const Sides& sides, double elapsed_s) {
    constexpr double kTolerance =
        0.3;  // of what a parabola knows of a speed; one frame more or less is a factor of two
    double way = 0, before = 0, after = 0;
    for (std::size_t m = 0; m < sides.apart.size(); ++m) {
      way += sides.apart[m].squaredNorm();
      before += sides.before[m].velocity.squaredNorm(), after += sides.after[m].velocity.squaredNorm();
    }
    const double speed = std::sqrt(way) / elapsed_s, slow = std::sqrt(std::min(before, after)),
                 fast = std::sqrt(std::max(before, after));
    return speed > (1 - kTolerance) * slow && speed < (1 + kTolerance) * fast;
  }

  // Of what is seen well enough on both sides.
  Sides SidesOf(const std::vector<std::size_t>& fresh, std::size_t at) const {
    Sides sides;
    for (const motion::MarkerTrack& marker : recording_.markers) {
      const auto before = OneSide(marker, fresh, at - 1, -1), after = OneSide(marker, fresh, at, 1);
      if (!before || !after) continue;
      sides.before.push_back(*before), sides.after.push_back(*after);
      sides.apart.push_back(after->position - before->position);
    }
    return sides;
  }

  // Whether more or less time than stamped lies between two new frames.
  std::optional<FoundJump> JumpAt(const std::vector<std::size_t>& fresh, std::size_t at) const {
    const double stamped_s = recording_.time_s[fresh[at]] - recording_.time_s[fresh[at - 1]];
    const Sides sides = SidesOf(fresh, at);
    if (sides.apart.size() < 2) return std::nullopt;
    const double stamped_off = SquareOff(sides, stamped_s), count = static_cast<double>(sides.apart.size());
    constexpr double kExplained = 0.1, kDeviations = 6;
    const double frames = at_lower_rate_ ? 2 : 0.75;
    if (stamped_off < kLeastOffPx * kLeastOffPx * count || IsWithinItsSpeeds(sides, stamped_s)) return std::nullopt;
    FoundJump jump{at, stamped_s, 0, std::sqrt(stamped_off / count)};
    double slopes = 0;
    for (int round = 0; round < 12; ++round) {
      double along = 0;
      slopes = 0;
      for (std::size_t m = 0; m < sides.apart.size(); ++m) {
        const Eigen::Vector2d slope = 0.5 * (sides.before[m].velocity + sides.after[m].velocity) +
                                      jump.moved_s / 6 * (sides.before[m].acceleration - sides.after[m].acceleration);
        along += slope.dot(Off(sides, m, jump.moved_s)), slopes += slope.squaredNorm();
      }
      if (!(slopes > 0)) break;
      jump.moved_s += along / slopes;
    }
    constexpr double kLongest_s = 1;
    const bool is_a_time = slopes > 0 && jump.moved_s > 0 && jump.moved_s < kLongest_s;
    const double off = is_a_time ? SquareOff(sides, jump.moved_s) : INFINITY;
    if (off > kExplained * stamped_off) {
      jump.is_cut = IsCut(sides, stamped_s);
      return jump.is_cut ? std::optional(jump) : std::nullopt;
    }
    if (!IsOfSeveral(sides, stamped_s, jump.moved_s)) return std::nullopt;
    // Two numbers for each marker, one of all fitted; half of what the accelerations contribute may be wrong, and some
    // hundredths of a frame are what a parabola does not follow.
    constexpr double kAccelerationsWrong = 0.5, kParabolaWrong = 0.03;
    const double by_accelerations = ByAccelerations(sides, jump.moved_s) / std::sqrt(slopes),
                 by_scatter = std::sqrt(off / (2 * count - 1) / slopes);
    jump.sigma_s =
        std::hypot(by_scatter, std::hypot(kAccelerationsWrong * by_accelerations, kParabolaWrong * fresh_s_));
    constexpr double kDeviationsInAll = 3;
    const double least_s = std::max({frames * fresh_s_, kDeviations * by_scatter, kDeviationsInAll * jump.sigma_s});
    return std::abs(jump.moved_s - stamped_s) > least_s ? std::optional(jump) : std::nullopt;
  }

  // The jumps before each of the new frames.
  void FindJumps(const std::vector<std::size_t>& fresh) {
    found_.assign(fresh.size(), std::nullopt);
    for (std::size_t at = 1; at < fresh.size(); ++at) FindJump(fresh, at);
  }

  void FindJump(const std::vector<std::size_t>& fresh, std::size_t at) {
    found_[at] = IsBarrier(fresh[at]) ? std::nullopt : JumpAt(fresh, at);
  }

  // The same where some of the new frames have turned out to be none: found anew are those whose sides reach them.
  void FindJumpsWithout(const std::vector<std::size_t>& gone, std::vector<std::size_t>& fresh) {
    constexpr std::size_t kBeyond = kFewest + kMayBeLost + 2;  // frames of a side that may lie beyond its reach
    const auto place = [&fresh](std::size_t frame) {
      return static_cast<std::size_t>(std::lower_bound(fresh.begin(), fresh.end(), frame) - fresh.begin());
    };
    const auto time = [&](std::size_t k) { return recording_.time_s[fresh[k]]; };
    const std::size_t first_gone = place(gone.front()), last_gone = place(gone.back());
    const double from_s = time(first_gone > kBeyond ? first_gone - kBeyond : 0) - kReach_s,
                 to_s = time(std::min(last_gone + kBeyond, fresh.size() - 1)) + kReach_s;
    std::vector<std::size_t> kept;
    std::vector<std::optional<FoundJump>> found;
    std::vector<std::size_t> anew;
    for (std::size_t k = 0; k < fresh.size(); ++k) {
      if (std::binary_search(gone.begin(), gone.end(), fresh[k])) continue;
      if (time(k) >= from_s && time(k > 0 ? k - 1 : 0) <= to_s) anew.push_back(kept.size());
      found.push_back(found_[k]);
      if (found.back()) found.back()->at = kept.size();
      kept.push_back(fresh[k]);
    }
    fresh = std::move(kept), found_ = std::move(found);
    for (const std::size_t at : anew)
      if (at > 0) FindJump(fresh, at);
  }

  static Eigen::Vector2d Off(const Sides& sides, std::size_t m, double elapsed_s) {
    const PathPoint &a = sides.before[m], &b = sides.after[m];
    return sides.apart[m] - 0.5 * elapsed_s * (a.velocity + b.velocity) -
           elapsed_s * elapsed_s / 12 * (a.acceleration - b.acceleration);
  }

  static double SquareOff(const Sides& sides, double elapsed_s) {
    double sum = 0;
    for (std::size_t m = 0; m < sides.apart.size(); ++m) sum += Off(sides, m, elapsed_s).squaredNorm();
    return sum;
  }

  static double ByAccelerations(const Sides& sides, double elapsed_s) {
    double sum = 0;
    for (std::size_t m = 0; m < sides.apart.size(); ++m)
      sum += (elapsed_s * elapsed_s / 12 * (sides.before[m].acceleration - sides.after[m].acceleration)).squaredNorm();
    return std::sqrt(sum);
  }

  // New frames about a jump in which nothing moves, though something does on one of its sides. Too slow to be told for
  // repeated by themselves, they bend the paths that the jump was found with.
  std::vector<std::size_t> StillAbout(const std::vector<std::size_t>& fresh, std::size_t at) const {
    constexpr std::size_t kReach = 8;  // frames: what the paths on either side rest on
    constexpr double kStill = 0.2;     // of what a step would be
    double squares = 0;
    const Sides sides = SidesOf(fresh, at);
    for (std::size_t m = 0; m < sides.apart.size(); ++m)
      squares += std::max(sides.before[m].velocity.squaredNorm(), sides.after[m].velocity.squaredNorm());
    const double usual_px = std::sqrt(squares / static_cast<double>(sides.apart.size())) * fresh_s_;
    std::vector<std::size_t> still;
    for (std::size_t k = at > kReach ? at - kReach : 1; k < std::min(at + kReach, fresh.size()); ++k)
      if (StepBetween(recording_, fresh[k - 1], fresh[k]).rms_px < kStill * usual_px) still.push_back(fresh[k]);
    return still;
  }

  // Whether the paths on both sides of a jump meet at their stamps once the frames that stand still are taken for
  // repeated ones; then they are. Time that is missing leaves no picture twice.
  bool IsMadeByRepeats(const FoundJump& jump, std::vector<std::size_t>& fresh) {
    const std::vector<std::size_t> still = StillAbout(fresh, jump.at);
    if (still.empty()) return false;
    std::vector<std::size_t> others;
    std::set_difference(fresh.begin(), fresh.end(), still.begin(), still.end(), std::back_inserter(others));
    const auto after = std::lower_bound(others.begin(), others.end(), fresh[jump.at]);
    if (after == others.begin() || after == others.end()) return false;
    const double stamped_s = recording_.time_s[*after] - recording_.time_s[*(after - 1)];
    const Sides sides = SidesOf(others, static_cast<std::size_t>(after - others.begin()));
    const auto count = static_cast<double>(sides.apart.size());
    if (count < 2 || SquareOff(sides, stamped_s) > kLeastOffPx * kLeastOffPx * count) return false;
    for (const std::size_t i : still) frames_.Mark(i);
    FindJumpsWithout(still, fresh);
    return true;
  }

  // The frames on both sides of a cut in which the markers that jump are seen: a tracklet may be lost for some.
  struct Cut {
    std::size_t before = 0, after = 0;
  };

  Cut CutAt(const std::vector<std::size_t>& fresh, std::size_t at) const {
    const auto jumping = static_cast<std::ptrdiff_t>(SidesOf(fresh, at).apart.size());
    const auto sees_them = [&](std::size_t k) {
      return std::count_if(recording_.markers.begin(), recording_.markers.end(),
                           [&](const motion::MarkerTrack& marker) { return marker.samples[fresh[k]].IsKnown(); }) >=
             jumping;
    };
    std::size_t before = at - 1, after = at;
    while (before > 0 && !sees_them(before)) --before;
    while (after + 1 < fresh.size() && !sees_them(after)) ++after;
    return {fresh[before], fresh[after]};
  }

  // A fit through a cut would bend the leg's paths towards each other, so each part is to be tracked by itself.
  [[noreturn]] void ThrowCuts(std::vector<Cut> cuts, const std::vector<double>& stamps_s) const {
    constexpr std::size_t kShown = 6;
    std::sort(cuts.begin(), cuts.end(), [](const Cut& a, const Cut& b) { return a.after < b.after; });
    std::string frames;
    for (std::size_t k = 0; k < std::min(cuts.size(), kShown); ++k)
      frames += fmt::format("{}{} and {}", k > 0 ? ", " : "", recording_.frame[cuts[k].before],
                            recording_.frame[cuts[k].after]);
    throw Fail(
        "between frames {}{} the markers jump farther than a person can move, and no missing time explains it: the "
        "recording is cut there, or put together from several, or the camera was pushed; track each part by itself "
        "(here --end {:.3f}, then --start {:.3f})",
        frames, cuts.size() > kShown ? ", …" : "", stamps_s[cuts.front().before], stamps_s[cuts.front().after]);
  }

  motion::MarkerRecording& recording_;
  RepeatedFrames& frames_;
  const bool at_lower_rate_;
  const double fresh_s_;                         // between new frames, usually
  const double mm_per_px_;                       // of a leg; 0: unknown
  std::vector<std::size_t> barriers_;            // jumps that were found, by the frame after them
  std::vector<std::optional<FoundJump>> found_;  // before each of the new frames
};

}  // namespace

std::vector<TimeJump> TakeTimeJumps(bool at_lower_rate, RepeatedFrames& frames, motion::MarkerRecording& recording) {
  return TimeJumpFinder(at_lower_rate, frames, recording).Take();
}

}  // namespace lake::tracking
