#include "lake/tracking/frame_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "lake/core/error.h"
#include "lake/core/frames_where.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "lower_rate.h"
#include "timed_paths.h"

namespace lake::tracking {
namespace {

// Prior odds, of a recording.
constexpr double kCutOdds = 1e-3, kJumpOdds = 1e-2, kConvertedOdds = 0.1;
constexpr double kDoubt = 1e-3;      // what the evidence must leave less of before a time is changed, …
constexpr double kWorthAWord = 2.3;  // … and the logarithm of odds of 10, from which it is said

constexpr double kLeastStepPx = 0.3;  // smaller steps are no motion to speak of: measured well enough, new or not

// How all markers that are seen in both moved from one frame to another, root mean square, px; nullopt of fewer than
// two.
std::optional<double> StepPx(const motion::MarkerRecording& recording, std::size_t from, std::size_t to) {
  double squares = 0;
  int seen = 0;
  for (const motion::MarkerTrack& marker : recording.markers) {
    if (!marker.samples[from].IsKnown() || !marker.samples[to].IsKnown()) continue;
    squares += (marker.samples[to].position - marker.samples[from].position).squaredNorm();
    ++seen;
  }
  return seen < 2 ? std::nullopt : std::optional(std::sqrt(squares / seen));
}

// Between frames: the mean of the intervals, each a whole number of the usual one. The usual one itself may be rounded,
// as to milliseconds.
double FrameInterval(const std::vector<double>& time_s) {
  const double usual_s = MedianInterval(time_s);
  double count = 0;
  for (std::size_t i = 1; i < time_s.size(); ++i)
    count += std::max(1.0, std::round((time_s[i] - time_s[i - 1]) / usual_s));
  return (time_s.back() - time_s.front()) / count;
}

// Frames by their place in the recording.
class FrameClock {
 public:
  explicit FrameClock(motion::MarkerRecording& recording)
      : recording_(recording),
        stamps_s_(recording.time_s),
        frame_s_(FrameInterval(recording.time_s)),
        is_repeated_(recording.Frames(), false) {}

  FrameTimes Correct(const std::vector<std::int64_t>& same_picture) {
    FrameTimes times;
    MarkRepeats(same_picture);
    if (const std::optional<LowerRate> rate = FindLowerRate(JudgedFrames(), 1 / frame_s_)) {
      times.captured_hz = TakeLowerRate(*rate);
      MarkRepeats(same_picture);
    }
    const TimedPaths paths(recording_, NewFrames());
    uneven_s_ = Unevenness(paths);
    if (times.captured_hz == 0) times.chosen_from_hz = TakeHigherRate(paths);
    times.uneven_s = uneven_s_;
    TakeJumps(times);
    SpreadTimes();
    times.repeated = RemoveRepeated();
    return times;
  }

 private:
  std::vector<std::size_t> NewFrames() const {
    std::vector<std::size_t> frames;
    for (std::size_t i = 0; i < is_repeated_.size(); ++i)
      if (!is_repeated_[i]) frames.push_back(i);
    return frames;
  }

  double UsualInterval(const std::vector<std::size_t>& frames) const {
    std::vector<double> time_s;
    for (const std::size_t i : frames) time_s.push_back(recording_.time_s[i]);
    return MedianInterval(time_s);
  }

  // Runs of frames whose picture is the one before, or nothing of it has moved, are judged by the paths, as a whole.
  // Those that are found bend the paths no longer by which the others are judged.
  void MarkRepeats(const std::vector<std::int64_t>& same_picture) {
    while (MarkMoreRepeats(same_picture)) {
    }
  }

  bool MarkMoreRepeats(const std::vector<std::int64_t>& same_picture) {
    constexpr double kCopyPx = 0.01;
    const std::vector<std::size_t> frames = NewFrames();
    const auto step_px = [&](std::size_t k) { return StepPx(recording_, frames[k - 1], frames[k]); };
    const auto looks_the_same = [&](std::size_t k) {
      return std::ranges::binary_search(same_picture, recording_.frame[frames[k]]) ||
             step_px(k).value_or(INFINITY) < kCopyPx;
    };
    std::optional<TimedPaths> paths;
    bool found = false;
    for (std::size_t k = 1, free = 1; k < frames.size(); free = ++k) {
      const bool is_same = looks_the_same(k);
      const auto [first, end] = is_same ? Standing(frames, k, free) : Copies(frames, k);
      if (first == end) continue;
      k = end - 1;
      if (StepBehind(frames, first - 1, end) < kLeastStepPx) continue;
      if (!paths) paths.emplace(recording_, frames);
      if (paths->LogOddsOfRepeat(frames, first, end, frame_s_) <= (is_same ? 0 : -std::log(kDoubt))) continue;
      for (std::size_t run = first; run < end; ++run) is_repeated_[frames[run]] = true;
      found = true;
    }
    return found;
  }

  // How far the markers come from one frame to another, or to the first behind it in which two are seen again, px.
  double StepBehind(const std::vector<std::size_t>& frames, std::size_t from, std::size_t to) const {
    constexpr std::size_t kFarthest = 8;
    for (const std::size_t end = std::min(frames.size(), to + kFarthest); to < end; ++to)
      if (const auto step_px = StepPx(recording_, frames[from], frames[to])) return *step_px;
    return 0;
  }

  static constexpr double kOfNeighbours = 0.25;  // what a copy moves at most, of the new pictures beside it

  // Strong coding changes a copy; a marker that turns round stands as still, so other evidence must leave no doubt.
  bool MayBeCopy(const std::vector<std::size_t>& frames, std::size_t k, double of_neighbours) const {
    const auto step_px = [&](std::size_t at) { return StepPx(recording_, frames[at - 1], frames[at]); };
    return k >= 2 && k + 1 < frames.size() &&
           step_px(k).value_or(INFINITY) <
               of_neighbours * std::min(step_px(k - 1).value_or(0), step_px(k + 1).value_or(0));
  }

  struct Run {
    std::size_t first, end;
  };

  // The frames from k on, 0.15 s of them at most, that may be copies of the one before them, between quick
  // movements; none if they move on.
  Run Copies(const std::vector<std::size_t>& frames, std::size_t k) const {
    constexpr double kLongest_s = 0.15;
    const auto step_px = [&](std::size_t from, std::size_t to) { return StepPx(recording_, frames[from], frames[to]); };
    const double into_px = k >= 2 ? kOfNeighbours * step_px(k - 2, k - 1).value_or(0) : 0;
    for (std::size_t end = k + 1; end < frames.size(); ++end) {
      const double changed_px = step_px(k - 1, end - 1).value_or(INFINITY);
      const double elapsed_s = recording_.time_s[frames[end - 1]] - recording_.time_s[frames[k - 1]];
      if (!(changed_px < into_px) || elapsed_s > kLongest_s) break;
      if (changed_px < kOfNeighbours * step_px(end - 1, end).value_or(0)) return {k, end};
    }
    return {k, k};
  }

  // The frames beside one that shows the picture before once more, from `free` on, that may do so as well: an encoder
  // goes on refining a picture that stands, which moves its markers a little. The first that shows it is not among
  // them.
  Run Standing(const std::vector<std::size_t>& frames, std::size_t copy, std::size_t free) const {
    constexpr double kRefinedPx = 0.15;
    const auto stands = [&](std::size_t k) {
      return StepPx(recording_, frames[k], frames[copy]).value_or(INFINITY) < kRefinedPx;
    };
    Run run{copy, copy + 1};
    while (run.first > free && stands(run.first - 2)) --run.first;
    while (run.end < frames.size() && stands(run.end)) ++run.end;
    return run;
  }

  // Frames that show the picture before them once more, or look like it, and those that surely are new. A copy moves by
  // what coding changes: strong coding by up to a pixel, and half as far as the new pictures beside it.
  std::vector<JudgedFrame> JudgedFrames() const {
    constexpr double kLeastOfCopyPx = 0.05, kMostOfCopyPx = 1, kOfKnownCopies = 2, kUnsure = 0.5;  // of its neighbours
    double known_px = 0;
    for (std::size_t i = 1; i < is_repeated_.size(); ++i)
      if (is_repeated_[i]) known_px = std::max(known_px, StepPx(recording_, i - 1, i).value_or(0));
    const double copy_px = std::clamp(kOfKnownCopies * known_px, kLeastOfCopyPx, kMostOfCopyPx);
    std::vector<JudgedFrame> judged;
    const std::vector<std::size_t> frames = NewFrames();
    for (std::size_t k = 1; k < frames.size(); ++k) {
      const bool looks_repeated = MayBeCopy(frames, k, kOfNeighbours) &&
                                  StepPx(recording_, frames[k - 1], frames[k + 1]).value_or(0) > kMostOfCopyPx;
      if (!looks_repeated &&
          (StepPx(recording_, frames[k - 1], frames[k]).value_or(0) < copy_px || MayBeCopy(frames, k, kUnsure)))
        continue;
      for (std::size_t i = frames[k - 1] + 1; i <= frames[k]; ++i)
        judged.push_back({i, is_repeated_[i] || looks_repeated});
    }
    return judged;
  }

  // Every repetition of a lower rate is one, also where nothing moves that would tell. Whether the others were lost,
  // with the stamps right, or were taken more seldom, equally far apart, the paths decide. Returns that rate, Hz, or 0.
  double TakeLowerRate(const LowerRate& rate) {
    for (std::size_t i = 0; i < is_repeated_.size(); ++i) is_repeated_[i] = rate.Repeats(i);
    std::vector<double> captured = recording_.time_s;
    double shift = 0;
    const std::vector<std::size_t> frames = NewFrames();
    for (std::size_t i = 0; i < captured.size(); ++i)
      captured[i] = recording_.time_s.front() + (rate.Source(i) - rate.phase) / rate.ratio * frame_s_;
    for (const std::size_t i : frames) shift += recording_.time_s[i] - captured[i];
    for (double& time : captured) time += shift / static_cast<double>(frames.size());
    const TimedPaths paths(recording_, frames);
    const double log_odds = std::log(kConvertedOdds) + paths.LogLikelihood(frames, captured) - paths.LogLikelihood();
    if (log_odds < -std::log(kDoubt)) return 0;
    recording_.time_s = std::move(captured);
    SpreadTimes();
    return rate.ratio / frame_s_;
  }

  // The times of frames that were chosen from a film of a higher rate, each the nearest one: early or late by up to
  // half a frame of that film, and how uneven they are then. Returns its rate, Hz, or 0. What is even at its stamps was
  // taken then.
  double TakeHigherRate(const TimedPaths& paths) {
    constexpr int kPhases = 24;
    constexpr double kFinestPhase = 1e-3;
    constexpr double kRegular = 0.2, kWhole = 0.02;  // of a frame
    constexpr double kMuchLess = 0.5;
    const std::vector<std::size_t> frames = NewFrames();
    const auto place = [&](std::size_t i) { return (stamps_s_[i] - stamps_s_.front()) / frame_s_; };
    const bool is_regular = std::ranges::all_of(
        frames, [&](std::size_t i) { return std::abs(place(i) - std::round(place(i))) < kRegular; });
    if (!is_regular || uneven_s_ == 0) return 0;
    double most = paths.LogLikelihood() - std::log(kDoubt) -
                  std::log(kConvertedOdds / static_cast<double>(kFilmRates_hz.size() * kPhases)),
           best_hz = 0;
    std::vector<double> best_s;
    for (const double source_hz : kFilmRates_hz) {
      const double ratio = source_hz * frame_s_;
      if (ratio < 1 + kWhole || std::abs(ratio - std::round(ratio)) < kWhole) continue;
      double most_of_rate = -INFINITY, best_phase = 0.5;
      // Of a long recording, and a ratio of large numbers, some frames are decided by a thousandth.
      double width = 1;
      while (width > kFinestPhase) {
        const double centre = best_phase;
        for (int step = 0; step < kPhases; ++step) {
          const double phase = centre + width * ((step + 0.5) / kPhases - 0.5);
          const double log_likelihood = paths.LogLikelihoodQuickly(frames, ChosenTimes(source_hz, phase));
          if (log_likelihood <= most_of_rate) continue;
          most_of_rate = log_likelihood;
          best_phase = phase;
        }
        width *= 2.0 / kPhases;
      }
      std::vector<double> best_of_rate_s = ChosenTimes(source_hz, best_phase);
      const double log_likelihood = paths.LogLikelihood(frames, best_of_rate_s);
      if (log_likelihood <= most) continue;
      most = log_likelihood;
      best_hz = source_hz;
      best_s = std::move(best_of_rate_s);
    }
    if (best_s.empty()) return 0;
    std::swap(recording_.time_s, best_s);
    const double left_s = Unevenness(TimedPaths(recording_, frames));
    if (left_s <= kMuchLess * uneven_s_) {
      uneven_s_ = left_s;
      return best_hz;
    }
    recording_.time_s = std::move(best_s);  // a film of another kind
    return 0;
  }

  // Of frames that are each the nearest one in a film of another rate, about their stamps.
  std::vector<double> ChosenTimes(double source_hz, double phase) const {
    std::vector<double> time_s;
    double shift_s = 0;
    for (const double stamp_s : stamps_s_) {
      const double place = std::round((stamp_s - stamps_s_.front()) / frame_s_);
      time_s.push_back(std::floor(source_hz * frame_s_ * place + phase) / source_hz);
      shift_s += (stamp_s - time_s.back()) / static_cast<double>(stamps_s_.size());
    }
    for (double& time : time_s) time += shift_s;
    return time_s;
  }

  struct Judgement {
    double log_odds = -INFINITY;  // of the likelier of both against the stamp
    bool is_cut = false;
    double moved_s = 0, sigma_s = 0;
    double misfit = 0, jump_mm = 0;
  };

  static constexpr std::ptrdiff_t kReach = 32;  // frames: what a path beside a passage rests on at most

  // What lies between frames[after − 1] and frames[after].
  Judgement Judge(const TimedPaths& paths, const std::vector<std::size_t>& frames, std::size_t after, std::size_t from,
                  std::size_t to, double usual_s) const {
    constexpr double kPlain = 1.5, kLong = 2.5, kLongest_s = 0.5;
    const double stamped_s = recording_.time_s[frames[after]] - recording_.time_s[frames[after - 1]],
                 misfit = paths.Misfit(frames, after, from, to);
    if (stamped_s < kLong * usual_s && misfit < kPlain) return {};
    const Passage passage = paths.Between(frames, after, from, to);
    if (passage.Markers() < 2) return {};
    const double by_stamp = passage.LogDensity(stamped_s), each = static_cast<double>(frames.size());
    const Judgement cut{.log_odds = std::log(kCutOdds / each) + passage.LogDensityOfCut(stamped_s) - by_stamp,
                        .is_cut = true,
                        .misfit = misfit,
                        .jump_mm = passage.JumpMm(stamped_s)};
    // Strong coding holds slow markers back for some frames and then lets them jump, as if time stood still or were
    // lost.
    constexpr double kHeldBackPx = 1;  // in a frame
    if (passage.Faster(kHeldBackPx / usual_s) < 2) return cut;
    Judgement jump = Likeliest(passage, usual_s, std::max(kLongest_s, stamped_s));
    jump.log_odds += std::log(kJumpOdds / each) - by_stamp;
    constexpr double kLeastFrames = 0.75, kUneven = 3, kOthers = 3;  // the logarithm of odds of 20
    if (std::abs(jump.moved_s - stamped_s) < std::max(kLeastFrames * usual_s, kUneven * uneven_s_) ||
        passage.LogRatioWithoutBest(jump.moved_s, stamped_s, 1) < kOthers ||
        passage.LogRatioWithoutBest(jump.moved_s, stamped_s, 2) < 0)
      jump.log_odds = -INFINITY;
    return cut.log_odds > jump.log_odds ? cut : jump;
  }

  // The time that the motion took, and the logarithm of the density of the paths, averaged over all times up to the
  // longest.
  static Judgement Likeliest(const Passage& passage, double usual_s, double longest_s) {
    constexpr double kShortest = 0.5, kStep = 1.03;
    double best_s = 0, most = -INFINITY;
    const auto sample = [&](double elapsed_s) {
      const double log_density = passage.LogDensity(elapsed_s);
      if (log_density <= most) return;
      most = log_density;
      best_s = elapsed_s;
    };
    for (double elapsed_s = kShortest * usual_s; elapsed_s < longest_s; elapsed_s *= kStep) sample(elapsed_s);
    for (double width = kStep - 1; width > 1e-4; width /= 2)
      for (const double times : {1 / (1 + width), 1 + width}) sample(best_s * times);
    // By the curvature of the logarithm (Laplace's method).
    const double step_s = 0.01 * usual_s;
    const double curvature =
        (2 * most - passage.LogDensity(best_s - step_s) - passage.LogDensity(best_s + step_s)) / (step_s * step_s);
    const double sigma_s = curvature > 0 ? std::min(1 / std::sqrt(curvature), longest_s) : longest_s;
    return {.log_odds = most + std::log(sigma_s * std::sqrt(2 * std::numbers::pi) / longest_s),
            .moved_s = best_s,
            .sigma_s = sigma_s};
  }

  // New frames, and what lies before each.
  struct Passages {
    std::vector<std::size_t> frames;
    std::vector<std::size_t> ends;  // of stretches that hang together
    std::vector<Judgement> before;  // of the first: none
  };

  void JudgeAround(const TimedPaths& paths, std::ptrdiff_t at, double usual_s, Passages& passages) const {
    const auto size = static_cast<std::ptrdiff_t>(passages.frames.size());
    for (std::ptrdiff_t k = std::max<std::ptrdiff_t>(at - kReach, 1); k < std::min(at + kReach, size); ++k) {
      const auto after = static_cast<std::size_t>(k);
      const auto end = std::ranges::upper_bound(passages.ends, after);
      passages.before[after] =
          *(end - 1) == after ? Judgement{} : Judge(paths, passages.frames, after, *(end - 1), *end, usual_s);
    }
  }

  // Whether a frame beside a jump stands where the one before it is, and the stamps hold without it: then it repeats
  // the picture, too slow a movement to be told by itself.
  bool TakeOutRepeat(const TimedPaths& paths, std::size_t after, double usual_s, Passages& passages) {
    for (const std::size_t k : {after - 1, after}) {
      if (k == 0 || k + 1 >= passages.frames.size()) continue;
      const auto into = StepPx(recording_, passages.frames[k - 1], passages.frames[k]),
                 out = StepPx(recording_, passages.frames[k], passages.frames[k + 1]);
      if (!into || !out || *into > 0.5 * *out) continue;
      std::vector<std::size_t> others = passages.frames;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
      if (Judge(paths, others, k, 0, others.size(), usual_s).log_odds > 0) continue;
      is_repeated_[passages.frames[k]] = true;
      passages.frames = std::move(others);
      passages.before.erase(passages.before.begin() + static_cast<std::ptrdiff_t>(k));
      for (std::size_t& end : passages.ends) end -= end > k;
      return true;
    }
    return false;
  }

  TimeJump JumpBefore(const Passages& passages, std::size_t after) const {
    const std::size_t a = passages.frames[after - 1], b = passages.frames[after];
    return {.before = recording_.frame[a],
            .after = recording_.frame[b],
            .stamped_s = recording_.time_s[b] - recording_.time_s[a],
            .moved_s = passages.before[after].moved_s,
            .sigma_s = passages.before[after].sigma_s};
  }

  // Where stretches end that hang together, and 0: where nobody is seen for long, as between two passes through the
  // picture, nothing says how time went on.
  std::vector<std::size_t> Stretches(const std::vector<std::size_t>& frames) const {
    constexpr double kLongest_s = 0.5;
    std::vector<std::size_t> ends = {0};
    std::optional<double> seen_s;
    for (std::size_t k = 0; k < frames.size(); ++k) {
      if (std::ranges::count_if(recording_.markers, [&](const auto& m) { return m.samples[frames[k]].IsKnown(); }) < 2)
        continue;
      const double time_s = recording_.time_s[frames[k]];
      if (seen_s && time_s - *seen_s > kLongest_s) ends.push_back(k);
      seen_s = time_s;
    }
    ends.push_back(frames.size());
    return ends;
  }

  // The clearest first, as it spoils the paths on which its neighbours are judged.
  void TakeJumps(FrameTimes& times) {
    constexpr double kCut_mm = 100;  // of 10 joined recordings 326 and more, of 6 whole ones 57 and less
    Passages passages;
    passages.frames = NewFrames();
    passages.ends = Stretches(passages.frames);
    passages.before.resize(passages.frames.size());
    const TimedPaths paths(recording_, passages.frames);
    const double usual_s = UsualInterval(passages.frames);
    for (std::size_t at = 0; at < passages.frames.size(); at += 2 * kReach)
      JudgeAround(paths, static_cast<std::ptrdiff_t>(at) + kReach, usual_s, passages);
    std::vector<std::pair<std::size_t, std::size_t>> cuts;
    while (true) {
      auto clearest = std::ranges::max_element(passages.before, {}, &Judgement::log_odds);
      if (clearest == passages.before.end() || clearest->log_odds < -std::log(kDoubt)) break;
      // Paths that reach across a cut make its neighbours look like one.
      if (clearest->is_cut)
        clearest = std::max_element(std::max(clearest - kReach, passages.before.begin()),
                                    std::min(clearest + kReach, passages.before.end()),
                                    [](const Judgement& a, const Judgement& b) {
                                      return a.is_cut < b.is_cut || (a.is_cut == b.is_cut && a.misfit < b.misfit);
                                    });
      const std::ptrdiff_t at = clearest - passages.before.begin();
      const auto after = static_cast<std::size_t>(at);
      const auto part = [&] { passages.ends.insert(std::ranges::upper_bound(passages.ends, after), after); };
      if (clearest->is_cut) {
        const std::size_t a = passages.frames[after - 1], b = passages.frames[after];
        if (clearest->jump_mm > kCut_mm)
          cuts.emplace_back(a, b);
        else
          times.jolts.push_back({recording_.frame[a], recording_.frame[b], clearest->jump_mm});
        part();
      } else if (!TakeOutRepeat(paths, after, usual_s, passages)) {
        times.jumps.push_back(JumpBefore(passages, after));
        times.jumps.back().is_applied = true;
        for (std::size_t i = passages.frames[after]; i < recording_.Frames(); ++i)
          recording_.time_s[i] += times.jumps.back().moved_s - times.jumps.back().stamped_s;
        part();
      }
      JudgeAround(paths, at, usual_s, passages);
    }
    if (!cuts.empty()) ThrowCuts(cuts);
    for (std::size_t after = 1; after < passages.frames.size(); ++after)
      if (passages.before[after].log_odds > kWorthAWord && !passages.before[after].is_cut)
        times.jumps.push_back(JumpBefore(passages, after));
    std::ranges::sort(times.jumps, {}, &TimeJump::before);
    std::ranges::sort(times.jolts, {}, &Jolt::before);
  }

  // A fit through a cut would bend the leg's paths towards each other, so each part is to be tracked by itself.
  [[noreturn]] void ThrowCuts(std::vector<std::pair<std::size_t, std::size_t>> cuts) const {
    constexpr std::size_t kShown = 6;
    std::ranges::sort(cuts);
    std::string frames;
    for (std::size_t k = 0; k < std::min(cuts.size(), kShown); ++k)
      frames += fmt::format("{}{} and {}", k > 0 ? ", " : "", recording_.frame[cuts[k].first],
                            recording_.frame[cuts[k].second]);
    throw Fail(
        "between frames {}{} the markers jump farther than a person can move, and no missing time explains it: the "
        "recording is cut there, or put together from several, or the camera was pushed; track each part by itself "
        "(here --end {:.3f}, then --start {:.3f})",
        frames, cuts.size() > kShown ? ", …" : "", stamps_s_[cuts.front().first], stamps_s_[cuts.front().second]);
  }

  // How far the frames' times are from those at which they were taken, root mean square, as after the conversion of a
  // rate; 0 where they are theirs. By frames whose lateness is known to a tenth of a frame; a few jumps make no
  // unevenness: the half that is off less tells.
  double Unevenness(const TimedPaths& paths) const {
    constexpr std::size_t kFewest = 20;
    constexpr double kKnown = 0.1, kMedianOfChiSquare = 0.455, kDeviations = 4;
    const std::vector<std::size_t> frames = NewFrames();
    const double usual_s = UsualInterval(frames);
    std::vector<Lateness> late;
    std::vector<double> across;
    for (std::size_t k = 0; k < frames.size(); ++k) {
      const auto one = paths.LatenessOf(frames, k);
      if (!one || one->sigma_s > usual_s) continue;
      late.push_back(*one);
      across.push_back(one->across);
    }
    if (late.size() < kFewest) return 0;
    // Of the markers over what their variances say, by what no time explains.
    const double noise = std::sqrt(Median(std::move(across)) / kMedianOfChiSquare);
    std::vector<double> squares, ratios;
    for (const Lateness& one : late) {
      if (noise * one.sigma_s > kKnown * usual_s) continue;
      squares.push_back(one.late_s * one.late_s);
      ratios.push_back(squares.back() / std::pow(noise * one.sigma_s, 2));
    }
    if (squares.size() < kFewest || Median(std::move(ratios)) < kMedianOfChiSquare * kDeviations) return 0;
    return std::sqrt(Median(std::move(squares)) / kMedianOfChiSquare);
  }

  // Repeated frames have no time of their own: evenly between the new ones on either side.
  void SpreadTimes() {
    std::vector<double>& time_s = recording_.time_s;
    for (std::size_t i = 1; i < time_s.size(); ++i) {
      if (!is_repeated_[i]) continue;
      std::size_t end = i;
      while (end < time_s.size() && is_repeated_[end]) ++end;
      const double from = time_s[i - 1],
                   step = end < time_s.size() ? (time_s[end] - from) / static_cast<double>(end - i + 1) : frame_s_;
      for (std::size_t k = i; k < end; ++k) time_s[k] = from + static_cast<double>(k - i + 1) * step;
      i = end;
    }
  }

  std::vector<std::int64_t> RemoveRepeated() {
    std::vector<std::int64_t> removed;
    for (std::size_t i = 0; i < is_repeated_.size(); ++i) {
      if (!is_repeated_[i]) continue;
      removed.push_back(recording_.frame[i]);
      for (motion::MarkerTrack& marker : recording_.markers) marker.samples[i] = {};
    }
    return removed;
  }

  motion::MarkerRecording& recording_;
  const std::vector<double> stamps_s_;
  const double frame_s_;  // between frames, usually
  double uneven_s_ = 0;   // how far frames are from their stamps, root mean square
  std::vector<bool> is_repeated_;
};

}  // namespace

FrameTimes CorrectFrameTimes(const std::vector<std::int64_t>& same_picture, motion::MarkerRecording& recording) {
  return FrameClock(recording).Correct(same_picture);
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
                    times.captured_hz > 0 ? fmt::format("; the recording was made with {} frames per second, at "
                                                        "whose times the motion is smooth: these times are used",
                                                        SignificantText(times.captured_hz, 4))
                                          : "; more light or a fixed frame rate avoids them"));
  for (const TimeJump& jump : times.jumps) {
    const bool is_longer = jump.moved_s > jump.stamped_s;
    const std::string consequence =
        jump.is_applied ? fmt::format("{}; the times of all later frames are set {:.4f} s {}",
                                      is_longer ? "frames are missing" : "time stands still",
                                      std::abs(jump.moved_s - jump.stamped_s), is_longer ? "later" : "earlier")
                        : fmt::format("{}, but the motion does not prove it: the time stamps stand",
                                      is_longer ? "frames may be missing" : "time may stand still");
    warnings.push_back(
        fmt::format("between frames {} and {} the motion took {} s where the time stamps say {:.4f} s: {}", jump.before,
                    jump.after, PlusMinusText(jump.moved_s, jump.sigma_s, 4), jump.stamped_s, consequence));
  }
  for (const Jolt& jolt : times.jolts)
    warnings.push_back(
        fmt::format("between frames {} and {} two markers or more move {:.0f} mm farther than a leg can: a camera "
                    "that was pushed, or other objects taken for markers; look at these frames",
                    jolt.before, jolt.after, jolt.jump_mm));
  if (times.chosen_from_hz > 0)
    warnings.push_back(
        fmt::format("the frames were chosen from a film of {} frames per second, as when a rate is converted: the "
                    "motion is smooth only at the times that they had there, which are used; track the camera's own "
                    "file where there is one",
                    SignificantText(times.chosen_from_hz, 4)));
  if (times.uneven_s > 0)
    warnings.push_back(
        fmt::format("the frames were not taken at their time stamps but up to a frame beside them ({:.1f} ms root mean "
                    "square), as after a conversion of the rate; times and speeds are uncertain by that; track the "
                    "camera's own file where there is one",
                    1e3 * times.uneven_s));
  return warnings;
}

}  // namespace lake::tracking
