#include "lake/tracking/frame_times.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "lake/core/error.h"
#include "lake/core/frames_where.h"
#include "lake/core/statistics.h"
#include "leg_scale.h"
#include "local_path.h"

namespace lake::tracking {
namespace {

// Root mean square over the markers: smaller steps are no motion to speak of, paths less apart than that are one.
constexpr double kLeastStepPx = 0.3, kLeastOffPx = 0.7;

// How all markers moved from one frame to another: two numbers for each marker that is seen in both.
struct JointStep {
  std::vector<std::optional<Eigen::Vector2d>> markers;
  int seen = 0;
  double rms_px = 0;
};

JointStep StepBetween(const motion::MarkerRecording& recording, std::size_t from, std::size_t to) {
  JointStep step;
  double squares = 0;
  for (const motion::MarkerTrack& marker : recording.markers) {
    step.markers.emplace_back();
    if (!marker.samples[from].IsKnown() || !marker.samples[to].IsKnown()) continue;
    step.markers.back() = marker.samples[to].position - marker.samples[from].position;
    squares += step.markers.back()->squaredNorm();
    ++step.seen;
  }
  if (step.seen > 0) step.rms_px = std::sqrt(squares / step.seen);
  return step;
}

// Whether a step knows of every marker that another one knows of.
bool SeesAll(const JointStep& step, const JointStep& other) {
  for (std::size_t m = 0; m < step.markers.size(); ++m)
    if (other.markers[m] && !step.markers[m]) return false;
  return true;
}

bool IsSameWay(const JointStep& a, const JointStep& b) {
  constexpr double kCosine = 0.7;
  double product = 0, a_square = 0, b_square = 0;
  for (std::size_t m = 0; m < a.markers.size(); ++m) {
    if (!a.markers[m] || !b.markers[m]) continue;
    product += a.markers[m]->dot(*b.markers[m]);
    a_square += a.markers[m]->squaredNorm(), b_square += b.markers[m]->squaredNorm();
  }
  return product > kCosine * std::sqrt(a_square * b_square);
}

// Frames by their place in the recording.
class FrameTimeFinder {
 public:
  FrameTimeFinder(const std::vector<std::int64_t>& known, motion::MarkerRecording& recording)
      : recording_(recording), frame_s_(MedianInterval(recording.time_s)), repeated_(recording.Frames(), 0) {
    for (std::size_t i = 0; i < repeated_.size(); ++i)
      repeated_[i] = std::binary_search(known.begin(), known.end(), recording.frame[i]);
  }

  FrameTimes Run() {
    FrameTimes times;
    for (std::size_t i = 2; i < repeated_.size(); ++i)
      if (!repeated_[i]) MarkStandstillFrom(i);
    if (const auto rate = FindLowerRate()) times.captured_hz = TakeLowerRate(*rate);
    has_lower_rate_ = times.captured_hz > 0;
    FindJumps(times.jumps);
    CheckTimes();
    RemoveRepeated();
    for (std::size_t i = 0; i < repeated_.size(); ++i)
      if (repeated_[i]) times.repeated.push_back(recording_.frame[i]);
    return times;
  }

 private:
  // Frames that show something new.
  std::vector<std::size_t> Fresh() const {
    std::vector<std::size_t> fresh;
    for (std::size_t i = 0; i < repeated_.size(); ++i)
      if (!repeated_[i]) fresh.push_back(i);
    return fresh;
  }

  std::optional<std::size_t> NewBefore(std::size_t i) const {
    while (i-- > 0)
      if (!repeated_[i]) return i;
    return std::nullopt;
  }

  // Marks the frames from `first` on in which nothing moves, if everything moves before and after them alike.
  void MarkStandstillFrom(std::size_t first) {
    constexpr double kStill = 0.2;  // of what a step would be
    const auto last_new = NewBefore(first);
    const auto one_before = last_new ? NewBefore(*last_new) : std::nullopt;
    if (!one_before) return;
    const JointStep before = StepBetween(recording_, *one_before, *last_new);
    const double elapsed_s = recording_.time_s[*last_new] - recording_.time_s[*one_before];
    const double usual_px = before.rms_px / elapsed_s * frame_s_;
    if (before.seen < 2 || usual_px < kLeastStepPx) return;
    const auto is_still = [&](std::size_t from, std::size_t to) {
      const JointStep step = StepBetween(recording_, from, to);
      return SeesAll(step, before) && step.rms_px < kStill * usual_px;
    };
    std::size_t resumed = first;
    while (resumed < repeated_.size() && (repeated_[resumed] || is_still(*last_new, resumed))) ++resumed;
    if (resumed == first || resumed >= repeated_.size()) return;
    std::size_t next = resumed + 1;
    while (next < repeated_.size() && (repeated_[next] || is_still(resumed, next))) ++next;
    if (next >= repeated_.size()) return;
    const JointStep over = StepBetween(recording_, *last_new, resumed), after = StepBetween(recording_, resumed, next);
    const double after_s = recording_.time_s[next] - recording_.time_s[resumed];
    if (after.seen < 2 || after.rms_px / after_s * frame_s_ < kLeastStepPx) return;
    if (!IsSameWay(before, over) || !IsSameWay(over, after)) return;
    for (std::size_t i = first; i < resumed; ++i) repeated_[i] = 1;
  }

  // A lower rate: source frame floor(ratio · i + phase) is shown in frame i.
  struct LowerRate {
    double ratio = 1, phase = 0;

    double Source(std::size_t i) const { return std::floor(ratio * static_cast<double>(i) + phase); }
    bool Repeats(std::size_t i) const { return i > 0 && Source(i) == Source(i - 1); }
  };

  // Frames of which it can be told whether they are new.
  std::vector<std::size_t> TellingFrames() const {
    std::vector<std::size_t> telling;
    for (std::size_t i = 1; i < repeated_.size(); ++i) {
      const JointStep step = StepBetween(recording_, NewBefore(i).value_or(i), i);
      if (repeated_[i] || (step.seen >= 2 && step.rms_px >= kLeastStepPx)) telling.push_back(i);
    }
    return telling;
  }

  // The rate whose repetitions are those that were found; of all that agree, the simplest ratio.
  std::optional<LowerRate> FindLowerRate() const {
    constexpr std::size_t kFewest = 6;
    constexpr double kMayDisagree = 0.03, kReach = 0.04;
    constexpr int kLargestDenominator = 60, kPhases = 24;
    const std::vector<std::size_t> telling = TellingFrames();
    const auto found = static_cast<std::size_t>(
        std::count_if(telling.begin(), telling.end(), [&](std::size_t i) { return repeated_[i]; }));
    if (found < kFewest || 25 * found < telling.size()) return std::nullopt;
    const double about = 1 - static_cast<double>(found) / static_cast<double>(telling.size());
    const auto most = static_cast<std::size_t>(kMayDisagree * static_cast<double>(telling.size()));
    for (int denominator = 2; denominator <= kLargestDenominator; ++denominator)
      for (int numerator = 1; numerator < denominator; ++numerator) {
        if (std::gcd(numerator, denominator) != 1) continue;
        LowerRate rate{static_cast<double>(numerator) / denominator};
        if (std::abs(rate.ratio - about) > kReach) continue;
        std::size_t least = telling.size();
        double best_phase = 0;
        for (int step = 0; step < kPhases * denominator; ++step) {
          // Halfway between the phases at which the pattern changes, so that rounding decides nothing.
          rate.phase = (step + 0.5) / (kPhases * denominator);
          std::size_t disagree = 0;
          for (const std::size_t i : telling)
            if ((disagree += rate.Repeats(i) != static_cast<bool>(repeated_[i])) >= least) break;
          if (disagree < least) least = disagree, best_phase = rate.phase;
        }
        rate.phase = best_phase;
        if (least <= most) return rate;
      }
    return std::nullopt;
  }

  // How far the new frames' positions are from smooth paths at these times.
  double Roughness(const std::vector<double>& time_s) const {
    constexpr int kDegree = 3;
    constexpr std::size_t kReach = 3;
    const std::vector<std::size_t> fresh = Fresh();
    std::vector<double> off;
    for (const motion::MarkerTrack& marker : recording_.markers)
      for (std::size_t k = kReach; k + kReach < fresh.size(); ++k) {
        LocalPath path(kDegree, time_s[fresh[k]]);
        bool whole = true;
        for (std::size_t j = k - kReach; j <= k + kReach && whole; ++j) {
          const motion::MarkerSample& sample = marker.samples[fresh[j]];
          whole = sample.IsKnown();
          if (whole) path.Add(time_s[fresh[j]], sample.position);
        }
        const Eigen::Vector2d moved = marker.samples[fresh[k]].position - marker.samples[fresh[k - 1]].position;
        if (!whole || moved.norm() < kLeastStepPx) continue;
        off.push_back((marker.samples[fresh[k]].position - path.Fit().position).norm());
      }
    return off.empty() ? INFINITY : Median(std::move(off));
  }

  // Every repetition of the rate is one, also where nothing moves that would tell. Returns the rate if its frames are
  // equally far apart, with their times corrected, else 0.
  double TakeLowerRate(const LowerRate& rate) {
    constexpr double kClearlySmoother = 0.7;
    for (std::size_t i = 0; i < repeated_.size(); ++i) repeated_[i] |= static_cast<char>(rate.Repeats(i));
    std::vector<double> captured = recording_.time_s;
    double shift = 0;
    int fresh = 0;
    for (std::size_t i = 0; i < captured.size(); ++i) {
      captured[i] = recording_.time_s.front() + (rate.Source(i) - rate.phase) / rate.ratio * frame_s_;
      if (!repeated_[i]) shift += recording_.time_s[i] - captured[i], ++fresh;
    }
    for (double& time : captured) time += shift / fresh;
    if (Roughness(captured) > kClearlySmoother * Roughness(recording_.time_s)) return 0;
    recording_.time_s = std::move(captured);
    SpreadRepeated();
    return rate.ratio / frame_s_;
  }

  // Repeated frames have no time of their own: evenly between the new ones on either side.
  void SpreadRepeated() {
    std::vector<double>& time_s = recording_.time_s;
    for (std::size_t i = 1; i < time_s.size(); ++i) {
      if (!repeated_[i]) continue;
      std::size_t end = i;
      while (end < time_s.size() && repeated_[end]) ++end;
      const double from = time_s[i - 1],
                   step = end < time_s.size() ? (time_s[end] - from) / static_cast<double>(end - i + 1) : frame_s_;
      for (std::size_t k = i; k < end; ++k) time_s[k] = from + static_cast<double>(k - i + 1) * step;
      i = end;
    }
  }

  void RemoveRepeated() {
    for (motion::MarkerTrack& marker : recording_.markers)
      for (std::size_t i = 0; i < repeated_.size(); ++i)
        if (repeated_[i]) marker.samples[i] = {};
  }

  // The markers on both sides of a pair of new frames.
  struct Sides {
    std::vector<PathPoint> before, after;
    std::vector<Eigen::Vector2d> apart;
  };

  bool IsBarrier(std::size_t frame) const {
    return std::find(barriers_.begin(), barriers_.end(), frame) != barriers_.end();
  }

  std::optional<PathPoint> OneSide(const motion::MarkerTrack& marker, const std::vector<std::size_t>& fresh,
                                   std::size_t at, int direction) const {
    // A marker that has come far may be lost for some frames before it is followed again.
    constexpr int kFewest = 4, kMayBeLost = 4;
    constexpr double kReach_s = 0.11;  // a leg's path is a parabola for about as long
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
    const double frames = has_lower_rate_ ? 2 : 0.75;
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
    for (const std::size_t i : still) repeated_[i] = 1;
    fresh = std::move(others);
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

  // The largest first, as it spoils the paths on which the neighbours are judged.
  void FindJumps(std::vector<TimeJump>& jumps) {
    constexpr std::size_t kMost = 20;
    std::vector<std::size_t> fresh = Fresh();
    std::vector<double> fresh_time_s;
    fresh_time_s.reserve(fresh.size());
    for (const std::size_t i : fresh) fresh_time_s.push_back(recording_.time_s[i]);
    fresh_s_ = MedianInterval(fresh_time_s);
    mm_per_px_ = MillimetresPerPx(recording_);
    std::vector<Cut> cuts;
    const std::vector<double> stamps_s = recording_.time_s;
    while (true) {
      std::optional<FoundJump> largest;
      for (std::size_t at = 1; at < fresh.size(); ++at) {
        if (IsBarrier(fresh[at])) continue;
        const auto jump = JumpAt(fresh, at);
        if (jump && (!largest || jump->off_px > largest->off_px)) largest = jump;
      }
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
        continue;
      }
      const double stamped_s = recording_.time_s[after] - recording_.time_s[before];
      jumps.push_back(
          {recording_.frame[before], recording_.frame[after], stamped_s, largest->moved_s, largest->sigma_s});
      for (std::size_t i = after; i < repeated_.size(); ++i) recording_.time_s[i] += largest->moved_s - stamped_s;
    }
    if (!cuts.empty()) ThrowCuts(cuts, stamps_s);
    if (!jumps.empty()) SpreadRepeated();
    std::sort(jumps.begin(), jumps.end(), [](const TimeJump& a, const TimeJump& b) { return a.before < b.before; });
  }

  // How late (negative: early) a new frame's time is, by the paths of all markers through its neighbours.
  struct Lateness {
    double late_s = 0, explained_px2 = 0, off_px2 = 0;  // of what the markers are off their paths, squares
  };

  // nullopt where less than two markers are seen or all are slow.
  std::optional<Lateness> LatenessOf(const std::vector<std::size_t>& fresh, std::size_t at) const {
    constexpr int kDegree = 3;
    constexpr double kLeastPx = 3;  // root mean square way to the next frame
    const std::size_t i = fresh[at];
    double along = 0, speeds = 0;
    Lateness found;
    int seen = 0;
    for (const motion::MarkerTrack& marker : recording_.markers) {
      LocalPath path(kDegree, recording_.time_s[i]);
      std::size_t beside = 0;
      for (std::size_t k = at - kBeside; k <= at + kBeside; ++k) {
        if (k == at || !marker.samples[fresh[k]].IsKnown()) continue;
        path.Add(recording_.time_s[fresh[k]], marker.samples[fresh[k]].position), ++beside;
      }
      if (!marker.samples[i].IsKnown() || beside + 1 < 2 * kBeside) continue;
      const PathPoint smooth = path.Fit();
      const Eigen::Vector2d off = marker.samples[i].position - smooth.position;
      along += off.dot(smooth.velocity), speeds += smooth.velocity.squaredNorm(), found.off_px2 += off.squaredNorm();
      ++seen;
    }
    if (seen < 2 || std::sqrt(speeds / seen) * fresh_s_ < kLeastPx) return std::nullopt;
    found.late_s = -along / speeds, found.explained_px2 = along * along / speeds;
    return found;
  }

  // Times that neither repetitions nor jumps explain: of frames taken at one rate, some left out and some repeated to
  // make a second one, and a third. Then all markers are off their paths at once, by a common time.
  void CheckTimes() const {
    constexpr std::size_t kFewest = 20;  // frames in which the leg moves
    constexpr double kCommon = 0.6;      // of the squares; noise of four markers has 1/8 in common
    constexpr double kMost = 0.08;       // of the time between frames
    const std::vector<std::size_t> fresh = Fresh();
    std::vector<double> late_s;
    double explained = 0, off = 0, most_s = 0;
    std::size_t worst = 0;
    for (std::size_t k = kBeside; k + kBeside < fresh.size(); ++k) {
      const double span_s = recording_.time_s[fresh[k + kBeside]] - recording_.time_s[fresh[k - kBeside]];
      if (span_s > 4 * kBeside * fresh_s_) continue;
      const auto found = LatenessOf(fresh, k);
      if (!found) continue;
      late_s.push_back(std::abs(found->late_s));
      explained += found->explained_px2, off += found->off_px2;
      if (late_s.back() > most_s) most_s = late_s.back(), worst = fresh[k];
    }
    if (late_s.size() < kFewest || explained < kCommon * off) return;
    const double typical_s = Median(std::move(late_s));
    if (typical_s < kMost * fresh_s_) return;
    throw Fail(
        "the frames' times are not those at which they were taken: all markers are off their paths at once, as if by "
        "{:.1f} ms (median; {:.1f} ms in frame {}); record at a fixed frame rate, and track the camera's own file",
        1e3 * typical_s, 1e3 * most_s, recording_.frame[worst]);
  }

  static constexpr std::size_t kBeside = 3;  // new frames on either side that a path goes through

  motion::MarkerRecording& recording_;
  double frame_s_ = 0, fresh_s_ = 0;   // between frames, between new ones; usually
  double mm_per_px_ = 0;               // of a leg; 0: unknown
  std::vector<char> repeated_;         // 0 or 1 per frame
  bool has_lower_rate_ = false;        // and times of ours, from which frames may be off by a part of their interval
  std::vector<std::size_t> barriers_;  // jumps that were found, by the frame after them
};

}  // namespace

FrameTimes CorrectFrameTimes(const std::vector<std::int64_t>& known, motion::MarkerRecording& recording) {
  return FrameTimeFinder(known, recording).Run();
}

std::vector<std::string> Warnings(const FrameTimes& times, const std::vector<std::int64_t>& frame) {
  constexpr int kShown = 12;  // runs of frames
  const auto is_repeated = [&](std::size_t i) {
    return std::binary_search(times.repeated.begin(), times.repeated.end(), frame[i]);
  };
  std::vector<std::string> warnings;
  if (!times.repeated.empty())
    warnings.push_back(
        fmt::format("repeated frames ({} in all, the picture before them once more, no measurements): {}{}",
                    times.repeated.size(), FramesWhere(frame, is_repeated, kShown),
                    times.captured_hz > 0 ? fmt::format("; the recording was made with {:.4g} frames per second, at "
                                                        "whose times the motion is smooth: these times are used",
                                                        times.captured_hz)
                                          : "; more light or a fixed frame rate avoids them"));
  for (const TimeJump& jump : times.jumps)
    warnings.push_back(
        fmt::format("between frames {} and {} the motion took {:.4f} ± {:.4f} s where the time stamps say {:.4f} s: "
                    "{}; the times of all later frames are set {:.4f} s {}",
                    jump.before, jump.after, jump.moved_s, jump.sigma_s, jump.stamped_s,
                    jump.moved_s > jump.stamped_s ? "frames are missing" : "time stands still",
                    std::abs(jump.moved_s - jump.stamped_s), jump.moved_s > jump.stamped_s ? "later" : "earlier"));
  return warnings;
}

}  // namespace lake::tracking
