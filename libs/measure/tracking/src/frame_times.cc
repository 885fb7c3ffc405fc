#include "lake/tracking/frame_times.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "film_rates.h"
#include "lake/core/error.h"
#include "lake/core/frames_where.h"
#include "lake/core/interrupt.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "timed_paths.h"

namespace lake::tracking {
namespace {

// Prior odds of the hypotheses, against frames that were taken at their stamps.
constexpr struct {
  double film = 0.1;         // of a recording: its frames were chosen from a film of another rate
  double cut = 1e-3;         // of a recording: it is cut
  double missing = 1e-2;     // of a recording: time is missing in it
  double each_frame = 0.3;   // of a run that repeats a picture: for each frame more, …
  double frozen = 0.01;      // … down to that of a picture that is frozen, …
  double stands = 0.01;      // … of it that no time passes meanwhile, …
  double cut_behind = 1e-6;  // … and that it is none, but a rest with a cut behind it
  double altered = 1e-3;     // of a copy that coding changes so much that its picture is another
  double misjudged = 0.03;   // of a frame whose paths say that it is new or repeated
} kPrior;
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

// How far the frames' times are from those at which they were taken, root mean square, as after the conversion of a
// rate; 0 where they are theirs. By frames whose lateness is known to a tenth of a frame; a few jumps make no
// unevenness: only the half that is off less counts.
double Unevenness(const TimedPaths& paths) {
  constexpr std::size_t kFewest = 20;
  constexpr double kKnown = 0.1, kMedianOfChiSquare = 0.455, kDeviations = 4;
  const double usual_s = paths.UsualInterval();
  std::vector<Lateness> late;
  std::vector<double> across;
  for (const auto& one : paths.LatenessOfAll()) {
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

// The logarithm of the odds that the frames from `first` to `end` − 1, which show hardly anything else than the one
// before, repeat it, while time goes on or stands, against that everything rested. `frame_s`: the usual interval.
double LogOddsOfRepeat(const TimedPaths& paths, std::size_t first, std::size_t end, double frame_s) {
  const Interval interval = paths.Between(first, end);
  const double passed_s = paths.TimeAt(end) - paths.TimeAt(first - 1),
               since_last_s = paths.TimeAt(end) - paths.TimeAt(end - 1),
               repeated = static_cast<double>(end - first - 1) * std::log(kPrior.each_frame);
  return LogSum({std::max(repeated, std::log(kPrior.frozen)) + interval.LogIfCopied(passed_s),
                 repeated + std::log(kPrior.stands) + interval.LogIfCopied(frame_s)}) -
         LogSum({interval.LogIfNew(since_last_s), std::log(kPrior.cut_behind) + interval.LogIfCut(since_last_s)});
}

// How much time lies between two frames, and how sure that is.
struct Elapsed {
  double log_odds = -INFINITY;  // of the likelier of both against the stamp
  bool is_cut = false;
  double moved_s = 0, sigma_s = 0;
  double misfit = 0, jump_mm = 0;
};

// The time that the motion took, and the logarithm of the density of the paths, averaged over all times up to the
// longest.
Elapsed LikeliestTime(const Interval& interval, double usual_s, double longest_s) {
  constexpr double kShortest = 0.5, kStep = 1.03, kFinest = 1e-4;
  double best_s = 0, most = -INFINITY;
  const auto sample = [&](double elapsed_s) {
    const double log_density = interval.LogIfNew(elapsed_s);
    if (log_density <= most) return;
    most = log_density;
    best_s = elapsed_s;
  };
  double elapsed_s = kShortest * usual_s, width = kStep - 1;
  while (elapsed_s < longest_s) {
    sample(elapsed_s);
    elapsed_s *= kStep;
  }
  while (width > kFinest) {
    for (const double times : {1 / (1 + width), 1 + width}) sample(best_s * times);
    width /= 2;
  }
  // By the curvature of the logarithm (Laplace's method).
  const double step_s = 0.01 * usual_s;
  const double curvature =
      (2 * most - interval.LogIfNew(best_s - step_s) - interval.LogIfNew(best_s + step_s)) / (step_s * step_s);
  const double sigma_s = curvature > 0 ? std::min(1 / std::sqrt(curvature), longest_s) : longest_s;
  return {.log_odds = most + std::log(sigma_s * std::sqrt(2 * std::numbers::pi) / longest_s),
          .moved_s = best_s,
          .sigma_s = sigma_s};
}

// What lies before this frame. `uneven_s`: how far frames are from their stamps, root mean square.
Elapsed Judge(const TimedPaths& paths, std::size_t at, double usual_s, double uneven_s) {
  if (paths.IsCut(at)) return {};  // decided
  constexpr double kPlain = 1.5, kLong = 2.5, kLongest_s = 0.5;
  const double stamped_s = paths.TimeAt(at) - paths.TimeAt(at - 1), misfit = paths.Misfit(at);
  if (stamped_s < kLong * usual_s && misfit < kPlain) return {};
  const Interval interval = paths.Between(at, at);
  if (interval.Markers() < 2) return {};
  const double by_stamp = interval.LogIfNew(stamped_s), each = static_cast<double>(paths.Frames());
  const Elapsed cut{.log_odds = std::log(kPrior.cut / each) + interval.LogIfCut(stamped_s) - by_stamp,
                    .is_cut = true,
                    .misfit = misfit,
                    .jump_mm = interval.JumpMm(stamped_s)};
  // Strong coding holds slow markers back for some frames and then lets them jump, as if time stood still or were
  // lost.
  constexpr double kHeldBackPx = 1;  // in a frame
  if (interval.Faster(kHeldBackPx / usual_s) < 2) return cut;
  Elapsed jump = LikeliestTime(interval, usual_s, std::max(kLongest_s, stamped_s));
  jump.log_odds += std::log(kPrior.missing / each) - by_stamp;
  constexpr double kLeastFrames = 0.75, kUneven = 3, kOthers = 3;  // the logarithm of odds of 20
  if (std::abs(jump.moved_s - stamped_s) < std::max(kLeastFrames * usual_s, kUneven * uneven_s) ||
      interval.LogRatioWithoutBest(jump.moved_s, stamped_s, 1) < kOthers ||
      interval.LogRatioWithoutBest(jump.moved_s, stamped_s, 2) < 0)
    jump.log_odds = -INFINITY;
  return cut.log_odds > jump.log_odds ? cut : jump;
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
    const bool is_regular = IsRegular();
    if (const std::optional<Film> film = is_regular ? FindSlowerFilm() : std::nullopt) {
      for (std::size_t i = 0; i < is_repeated_.size(); ++i) is_repeated_[i] = film->Repeats(PlaceOf(i));
      const TimedPaths paths(recording_, NewFrames());
      if (TakeTimesOf(*film, 0, paths)) times.captured_hz = film->rate_hz;
      MarkRepeats(same_picture);
    }
    const TimedPaths paths(recording_, NewFrames());
    times.uneven_s = Unevenness(paths);
    if (is_regular && times.captured_hz == 0 && times.uneven_s > 0) TakeFasterFilm(paths, times);
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

  // In frames since the first one, by its stamp.
  double PlaceOf(std::size_t i) const { return std::round((stamps_s_[i] - stamps_s_.front()) / frame_s_); }

  // Whether frames are whole numbers of the usual interval apart, as a converter makes them.
  bool IsRegular() const {
    constexpr double kRegular = 0.2;  // of a frame
    return std::ranges::all_of(stamps_s_, [&](double stamp_s) {
      const double place = (stamp_s - stamps_s_.front()) / frame_s_;
      return std::abs(place - std::round(place)) < kRegular;
    });
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
    const auto looks_the_same = [&](std::size_t k) {
      return std::ranges::binary_search(same_picture, recording_.frame[frames[k]]) ||
             StepPx(recording_, frames[k - 1], frames[k]).value_or(INFINITY) < kCopyPx;
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
      if (LogOddsOfRepeat(*paths, first, end, frame_s_) <= (is_same ? 0 : -std::log(kPrior.altered))) continue;
      for (std::size_t run = first; run < end; ++run) is_repeated_[frames[run]] = true;
      found = true;
    }
    return found;
  }

  // How far the markers come from one frame to another, or to the first behind it in which two are seen again, px; 0
  // where none is.
  double StepBehind(const std::vector<std::size_t>& frames, std::size_t from, std::size_t to) const {
    constexpr std::size_t kFarthest = 8;
    for (const std::size_t end = std::min(frames.size(), to + kFarthest); to < end; ++to)
      if (const auto step_px = StepPx(recording_, frames[from], frames[to])) return *step_px;
    return 0;
  }

  struct Run {
    std::size_t first, end;
  };

  // The frames from k on, 0.15 s of them at most, that may be copies of the one before them, between quick
  // movements; none if they move on. Strong coding changes a copy; a marker that turns round stands as still, so other
  // evidence must leave no doubt.
  Run Copies(const std::vector<std::size_t>& frames, std::size_t k) const {
    constexpr double kLongest_s = 0.15, kOfNeighbours = 0.25;
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

  // Of each frame the logarithm of the odds that it repeats the one before; 0 where nothing moves that would tell.
  std::vector<double> LogOddsOfRepeats() const {
    constexpr double kLeastOfCopyPx = 0.05, kOfKnownCopies = 2;
    const double most = std::log((1 - kPrior.misjudged) / kPrior.misjudged);
    std::vector<double> log_odds(is_repeated_.size(), most);
    const std::vector<std::size_t> frames = NewFrames();
    const TimedPaths paths(recording_, frames);
    // A copy moves by what coding changes.
    double copy_px = kLeastOfCopyPx;
    for (std::size_t i = 1; i < is_repeated_.size(); ++i)
      if (is_repeated_[i]) copy_px = std::max(copy_px, kOfKnownCopies * StepPx(recording_, i - 1, i).value_or(0));
    log_odds[frames.front()] = log_odds[frames.back()] = 0;
    for (std::size_t k = 1; k + 1 < frames.size(); ++k) {
      const double step_px = StepPx(recording_, frames[k - 1], frames[k]).value_or(0);
      const double log = StepBehind(frames, k - 1, k + 1) < kLeastStepPx
                             ? 0
                             : std::clamp(LogOddsOfRepeat(paths, k, k + 1, frame_s_), -most, most);
      log_odds[frames[k]] = log > 0 ? log : step_px > copy_px ? -most : 0;
    }
    return log_odds;
  }

  // The film of a lower rate whose frames are repeated where they were found to be: the likeliest. nullopt if it is
  // likelier that they are repeated at random.
  std::optional<Film> FindSlowerFilm() const {
    if (std::ranges::find(is_repeated_, true) == is_repeated_.end()) return std::nullopt;
    const std::vector<double> log_odds = LogOddsOfRepeats();
    const auto repeated = static_cast<double>(std::ranges::count_if(log_odds, [](double log) { return log > 0; })),
               is_new = static_cast<double>(std::ranges::count_if(log_odds, [](double log) { return log < 0; })),
               share = repeated / (repeated + is_new);
    double most = 0;  // by now of frames that are repeated at random
    for (const double log : log_odds) most += std::log(1 - share + share * std::exp(log));
    constexpr int kPhases = 192;  // enough for 24 of 25 frames
    std::optional<Film> best;
    for (Film film : SlowerFilms(1 / frame_s_)) {
      const double log_likelihood = FindPhase(
          [&](const Film& tried) {
            double sum = 0;
            for (std::size_t i = 0; i < log_odds.size(); ++i)
              if (tried.Repeats(PlaceOf(i))) sum += log_odds[i];
            return sum;
          },
          kPhases, film);
      if (log_likelihood + film.log_odds <= most) continue;
      most = log_likelihood + film.log_odds;
      best = film;
    }
    return best;
  }

  // Of the recording's frames; on average their stamps.
  std::vector<double> TimesOf(const Film& film) const {
    const std::vector<std::size_t> frames = NewFrames();
    std::vector<double> time_s;
    double shift_s = 0;
    for (std::size_t i = 0; i < stamps_s_.size(); ++i) time_s.push_back(film.Source(PlaceOf(i)) / film.rate_hz);
    for (const std::size_t i : frames) shift_s += (stamps_s_[i] - time_s[i]) / static_cast<double>(frames.size());
    for (double& time : time_s) time += shift_s;
    return time_s;
  }

  // Takes the film's times where the motion leaves no doubt that they are likelier than the stamps.
  bool TakeTimesOf(const Film& film, double log_odds, const TimedPaths& paths) {
    std::vector<double> time_s = TimesOf(film);
    if (log_odds + std::log(kPrior.film) + paths.LogLikelihood(time_s) - paths.LogLikelihood() < -std::log(kDoubt))
      return false;
    recording_.time_s = std::move(time_s);
    SpreadTimes();
    return true;
  }

  // The frames may have been chosen from a film of a higher rate, each the nearest one: early or late by up to half a
  // frame of that film. What is even at its stamps was taken then.
  void TakeFasterFilm(const TimedPaths& paths, FrameTimes& times) {
    constexpr double kMuchLess = 0.5;
    constexpr int kPhases = 24;
    std::optional<Film> best;
    double most = -INFINITY;
    for (Film film : FasterFilms(1 / frame_s_)) {
      FindPhase([&](const Film& tried) { return paths.LogLikelihoodQuickly(TimesOf(tried)); }, kPhases, film);
      const double log_likelihood = paths.LogLikelihood(TimesOf(film));
      if (log_likelihood <= most) continue;
      most = log_likelihood;
      best = film;
    }
    const std::vector<double> before_s = recording_.time_s;
    if (!best || !TakeTimesOf(*best, best->log_odds - std::log(kPhases), paths)) return;
    const double left_s = Unevenness(TimedPaths(recording_, NewFrames()));
    if (left_s <= kMuchLess * times.uneven_s) {
      times.uneven_s = left_s;
      times.chosen_from_hz = best->rate_hz;
    } else {
      recording_.time_s = before_s;  // a film of another kind
    }
  }

  TimeJump JumpBefore(const TimedPaths& paths, std::size_t at, const Elapsed& elapsed) const {
    return {.before = recording_.frame[paths.FrameAt(at - 1)],
            .after = recording_.frame[paths.FrameAt(at)],
            .stamped_s = paths.TimeAt(at) - paths.TimeAt(at - 1),
            .moved_s = elapsed.moved_s,
            .sigma_s = elapsed.sigma_s};
  }

  // The clearest first, as it spoils the paths on which its neighbours are judged.
  void TakeJumps(FrameTimes& times) {
    constexpr double kCut_mm = 100;        // of 10 joined recordings 326 and more, of 6 whole ones 57 and less
    constexpr std::ptrdiff_t kReach = 32;  // frames: what a path beside an interval rests on at most
    TimedPaths paths(recording_, NewFrames());
    const double usual_s = paths.UsualInterval();
    std::vector<Elapsed> before(paths.Frames());
    const auto judge = [&](std::ptrdiff_t from, std::ptrdiff_t to) {
      for (std::ptrdiff_t k = std::max<std::ptrdiff_t>(from, 1); k < std::min(to, std::ssize(before)); ++k)
        before[static_cast<std::size_t>(k)] = Judge(paths, static_cast<std::size_t>(k), usual_s, times.uneven_s);
    };
    judge(1, std::ssize(before));
    std::vector<std::pair<std::size_t, std::size_t>> cuts;
    while (true) {
      ThrowIfInterrupted();
      auto clearest = std::ranges::max_element(before, {}, &Elapsed::log_odds);
      if (clearest->log_odds < -std::log(kDoubt)) break;
      // Paths that reach across a cut make its neighbours look like one.
      if (clearest->is_cut)
        clearest = std::max_element(before.begin() + std::max<std::ptrdiff_t>(clearest - before.begin() - kReach, 0),
                                    before.begin() + std::min(clearest - before.begin() + kReach, std::ssize(before)),
                                    [](const Elapsed& a, const Elapsed& b) {
                                      return a.is_cut < b.is_cut || (a.is_cut == b.is_cut && a.misfit < b.misfit);
                                    });
      const std::ptrdiff_t at = clearest - before.begin();
      const std::size_t a = paths.FrameAt(static_cast<std::size_t>(at) - 1),
                        b = paths.FrameAt(static_cast<std::size_t>(at));
      if (!clearest->is_cut) {
        times.jumps.push_back(JumpBefore(paths, static_cast<std::size_t>(at), *clearest));
        times.jumps.back().is_applied = true;
        for (std::size_t i = b; i < recording_.Frames(); ++i)
          recording_.time_s[i] += times.jumps.back().moved_s - times.jumps.back().stamped_s;
      } else if (clearest->jump_mm > kCut_mm) {
        cuts.emplace_back(a, b);
      } else {
        times.position_jumps.push_back({recording_.frame[a], recording_.frame[b], clearest->jump_mm});
      }
      paths.Cut(static_cast<std::size_t>(at));
      judge(at - kReach, at + kReach);
    }
    if (!cuts.empty()) ThrowCuts(cuts);
    for (std::size_t at = 1; at < before.size(); ++at)
      if (before[at].log_odds > kWorthAWord && !before[at].is_cut)
        times.jumps.push_back(JumpBefore(paths, at, before[at]));
    std::ranges::sort(times.jumps, {}, &TimeJump::before);
    std::ranges::sort(times.position_jumps, {}, &PositionJump::before);
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
  for (const PositionJump& jump : times.position_jumps)
    warnings.push_back(
        fmt::format("between frames {} and {} two markers or more move {:.0f} mm farther than a leg can: a camera "
                    "that was pushed, or other objects taken for markers; look at these frames",
                    jump.before, jump.after, jump.jump_mm));
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
