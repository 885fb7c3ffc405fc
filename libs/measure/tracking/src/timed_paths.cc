#include "timed_paths.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>
#include <span>

#include "leg_scale.h"

namespace lake::tracking {
namespace {

constexpr std::size_t kDensities = 8;               // decades, …
constexpr int kAboveQuick = 1;                      // … so many of them above that of a quick movement
constexpr double kSudden = 30, kSuddenShare = 0.1;  // a jerk out of all that was before: times the density, how often
constexpr double kMismeasured = 1e-6,
                 kUnrelated = 0.5;  // shares of markers that are something else afterwards: usually, after a cut

double LogSum(const std::vector<double>& logs) {
  const double most = *std::max_element(logs.begin(), logs.end());
  if (!std::isfinite(most)) return most;
  double sum = 0;
  for (const double log : logs) sum += std::exp(log - most);
  return most + std::log(sum);
}

double DensityOf(std::size_t step, double quick) {
  return quick * std::pow(10, static_cast<double>(step) - static_cast<double>(kDensities - 1 - kAboveQuick));
}

// By how much likelier a path makes it that the derivatives of a marker's place from the first to the second, or from
// the second on, are none than they are of a moving person's at any time (Savage and Dickey's ratio); a logarithm.
double LogOddsOfNone(const dynamics::PathState& state, int derivatives, const dynamics::MotionPrior& prior) {
  const Eigen::LLT<Eigen::MatrixXd> covariance(state.covariance.block(1, 1, derivatives, derivatives));
  double odds = 2 * std::log(prior.speed) + (derivatives > 1 ? 2 * std::log(prior.acceleration) : 0);
  odds -= 2 * covariance.matrixLLT().diagonal().array().log().sum();
  return odds - 0.5 * covariance.matrixL().solve(state.mean.middleRows(1, derivatives)).squaredNorm();
}

// The same of a marker that rests, or comes to rest in the last frame or before the next one, against one that rests or
// moves, of even odds.
double LogOddsOfStop(const dynamics::PathState& state, double within_s, double density,
                     const dynamics::MotionPrior& prior) {
  const double rests = LogOddsOfNone(state, 2, prior);
  return LogSum({rests, LogOddsOfNone(state, 1, prior),
                 LogOddsOfNone(dynamics::Moved(state, within_s, density), 1, prior)}) -
         LogSum({0, rests});
}

// A path on its way: its state, and of which time that is.
struct Course {
  dynamics::PathState state;
  double at_s = 0;
};

// The logarithm of the density of samples that follow, each taken `earlier_s` before its time; the course is at the
// last of them then.
double Follow(std::span<const dynamics::PathSample> samples, double density, const dynamics::MotionPrior& prior,
              Course& course, double earlier_s = 0) {
  double log_density = 0;
  for (dynamics::PathSample sample : samples) {
    sample.time_s -= earlier_s;
    const Eigen::Vector2d was_at = course.state.Position();
    course.state =
        dynamics::WithinReach(dynamics::Moved(course.state, sample.time_s - course.at_s, density), was_at, prior);
    log_density += dynamics::Observe(sample, course.state);
    course.at_s = sample.time_s;
  }
  return log_density;
}

}  // namespace

double Passage::LogDensity(double elapsed_s) const {
  return LogDensity(elapsed_s, kMismeasured);
}

double Passage::LogDensityOfCut(double elapsed_s) const {
  return LogDensity(elapsed_s, kUnrelated);
}

double Passage::LogDensity(double elapsed_s, double unrelated) const {
  double total = 0;
  for (const Marker& marker : markers_) total += LogDensity(marker, elapsed_s, unrelated);
  return total;
}

double Passage::LogRatioWithoutBest(double elapsed_s, double other_s, std::size_t best) const {
  std::vector<double> ratios;
  for (const Marker& marker : markers_)
    ratios.push_back(LogDensity(marker, elapsed_s, kMismeasured) - LogDensity(marker, other_s, kMismeasured));
  std::ranges::sort(ratios);
  ratios.resize(ratios.size() - std::min(best, ratios.size()));
  return std::accumulate(ratios.begin(), ratios.end(), 0.0);
}

double Passage::LogDensity(const Marker& marker, double elapsed_s, double unrelated) const {
  std::vector<double> logs = {std::log(unrelated) + log_unrelated_};
  for (const Hypothesis& hypothesis : marker) {
    const auto join = [&](double density) {
      return std::log(1 - unrelated) + hypothesis.log_weight +
             dynamics::LogJoin(hypothesis.before, hypothesis.after, elapsed_s, density);
    };
    logs.push_back(std::log(1 - kSuddenShare) + join(hypothesis.density));
    logs.push_back(std::log(kSuddenShare) + join(kSudden * hypothesis.density));
  }
  return LogSum(logs);
}

double Passage::JumpMm(double elapsed_s) const {
  std::vector<double> jumps = {0, 0};
  for (const Marker& marker : markers_) {
    const Hypothesis& likeliest = *std::ranges::max_element(marker, {}, &Hypothesis::log_weight);
    const dynamics::PathState told = dynamics::WithinReach(
        dynamics::Moved(likeliest.before, elapsed_s, likeliest.density), likeliest.before.Position(), prior_);
    jumps.push_back((likeliest.after.Position() - told.Position()).norm());
  }
  std::ranges::nth_element(jumps, jumps.begin() + 1, std::greater());
  return unit_mm_ * jumps[1];
}

int Passage::Faster(double least_px_s) const {
  return static_cast<int>(std::ranges::count_if(markers_, [&](const Marker& marker) {
    const Hypothesis& likeliest = *std::ranges::max_element(marker, {}, &Hypothesis::log_weight);
    return likeliest.before.Velocity().norm() > least_px_s && likeliest.after.Velocity().norm() > least_px_s;
  }));
}

TimedPaths::TimedPaths(const motion::MarkerRecording& recording, const std::vector<std::size_t>& frames)
    : recording_(recording) {
  unit_mm_ = MillimetresPerPx(recording);
  prior_ = dynamics::PersonPrior(unit_mm_);
  learnt_ = dynamics::LearnMotion(PathsAt(frames, recording.time_s), unit_mm_);
}

std::vector<std::vector<dynamics::PathSample>> TimedPaths::PathsAt(const std::vector<std::size_t>& frames,
                                                                   const std::vector<double>& time_s) const {
  std::vector<std::vector<dynamics::PathSample>> paths;
  for (const motion::MarkerTrack& marker : recording_.markers) {
    paths.emplace_back();
    for (const std::size_t i : frames)
      if (const motion::MarkerSample& sample = marker.samples[i]; sample.IsKnown())
        paths.back().push_back({time_s[i], sample.position, sample.sigma});
  }
  return paths;
}

// A marker's samples in `frames` from `nearest` in this direction, the farthest first.
std::vector<dynamics::PathSample> TimedPaths::Beside(const motion::MarkerTrack& marker,
                                                     const std::vector<std::size_t>& frames, std::ptrdiff_t nearest,
                                                     std::ptrdiff_t end, int direction) const {
  constexpr std::size_t kFewest = 8, kMost = 20;
  constexpr double kReach_s = 0.25, kFastest = 5;  // deviations of a person's speed
  std::vector<dynamics::PathSample> samples;
  for (std::ptrdiff_t k = nearest; k != end; k += direction) {
    const std::size_t i = frames[static_cast<std::size_t>(k)];
    const motion::MarkerSample& sample = marker.samples[i];
    if (!sample.IsKnown()) continue;
    if (samples.size() == kMost) break;
    if (!samples.empty() && (sample.position - samples.back().position).norm() >
                                kFastest * prior_.speed * std::abs(recording_.time_s[i] - samples.back().time_s))
      break;
    if (samples.size() >= kFewest && std::abs(recording_.time_s[i] - samples.front().time_s) > kReach_s) break;
    samples.push_back({recording_.time_s[i], sample.position, std::hypot(sample.sigma, learnt_.extra_sigma)});
  }
  std::reverse(samples.begin(), samples.end());
  return samples;
}

// nullopt where too little is seen to tell a path.
std::optional<TimedPaths::Sides> TimedPaths::SidesOf(const motion::MarkerTrack& marker,
                                                     const std::vector<std::size_t>& frames, std::size_t after,
                                                     std::size_t from, std::size_t to) const {
  constexpr std::size_t kFewest = 4;
  const auto at = static_cast<std::ptrdiff_t>(after);
  Sides sides{Beside(marker, frames, at - 1, static_cast<std::ptrdiff_t>(from) - 1, -1),
              Beside(marker, frames, at, static_cast<std::ptrdiff_t>(to), 1)};
  return sides.before.size() < kFewest || sides.after.size() < kFewest ? std::nullopt : std::optional(std::move(sides));
}

double TimedPaths::Misfit(const std::vector<std::size_t>& frames, std::size_t after, std::size_t from,
                          std::size_t to) const {
  constexpr double kNumbers = 6;  // of a state
  const double before_s = recording_.time_s[frames[after - 1]], after_s = recording_.time_s[frames[after]];
  double squares = 0;
  int markers = 0;
  for (const motion::MarkerTrack& track : recording_.markers) {
    const auto sides = SidesOf(track, frames, after, from, to);
    if (!sides) continue;
    const dynamics::PathState told = dynamics::Moved(
                                  dynamics::EvidenceAt(sides->before, before_s, learnt_.density, prior_).state,
                                  after_s - before_s, learnt_.density),
                              seen = dynamics::EvidenceAt(sides->after, after_s, learnt_.density, prior_).state;
    const Eigen::LLT<Eigen::Matrix3d> covariance(told.covariance + seen.covariance);
    squares += covariance.matrixL().solve(seen.mean - told.mean).squaredNorm();
    ++markers;
  }
  return markers > 0 ? squares / (kNumbers * markers) : 0;
}

Passage TimedPaths::Between(const std::vector<std::size_t>& frames, std::size_t after, std::size_t from,
                            std::size_t to) const {
  Passage passage;
  passage.unit_mm_ = unit_mm_;
  passage.prior_ = prior_;
  passage.log_unrelated_ =
      -2 * std::log(kReach_mm / unit_mm_ * prior_.speed * prior_.acceleration) - 2 * std::log(2 * std::numbers::pi);
  for (const motion::MarkerTrack& track : recording_.markers) {
    const auto sides = SidesOf(track, frames, after, from, to);
    if (!sides) continue;
    Passage::Marker marker;
    std::vector<double> weights;
    for (std::size_t k = 0; k < kDensities; ++k) {
      const double density = DensityOf(k, learnt_.density);
      const auto told = dynamics::EvidenceAt(sides->before, recording_.time_s[frames[after - 1]], density, prior_),
                 seen = dynamics::EvidenceAt(sides->after, recording_.time_s[frames[after]], density, prior_);
      weights.push_back(told.log_likelihood + seen.log_likelihood);
      marker.push_back({weights.back(), density, told.state, seen.state});
    }
    const double all = LogSum(weights);
    for (Passage::Hypothesis& hypothesis : marker) hypothesis.log_weight -= all;
    passage.markers_.push_back(std::move(marker));
  }
  return passage;
}

std::optional<Lateness> TimedPaths::LatenessOf(const std::vector<std::size_t>& frames, std::size_t at) const {
  constexpr std::size_t kFewest = 3;
  const std::size_t i = frames[at];
  double along = 0, information = 0, across = 0;
  int seen = 0;
  for (const motion::MarkerTrack& track : recording_.markers) {
    const motion::MarkerSample& sample = track.samples[i];
    if (!sample.IsKnown()) continue;
    const auto here = static_cast<std::ptrdiff_t>(at);
    const auto before = Beside(track, frames, here - 1, -1, -1),
               behind = Beside(track, frames, here + 1, static_cast<std::ptrdiff_t>(frames.size()), 1);
    if (before.size() < kFewest || behind.size() < kFewest) continue;
    const dynamics::PathState a = dynamics::EvidenceAt(before, recording_.time_s[i], learnt_.density, prior_).state,
                              b = dynamics::EvidenceAt(behind, recording_.time_s[i], learnt_.density, prior_).state;
    const Eigen::Matrix3d weight_a = a.covariance.inverse(), weight_b = b.covariance.inverse(),
                          covariance = (weight_a + weight_b).inverse();
    const Eigen::Matrix<double, 3, 2> path = covariance * (weight_a * a.mean + weight_b * b.mean);
    const double variance = covariance(0, 0) + sample.sigma * sample.sigma + learnt_.extra_sigma * learnt_.extra_sigma;
    const Eigen::RowVector2d off = sample.position.transpose() - path.row(0);
    const double speed = path.row(1).norm();
    if (!(speed > 0)) continue;
    along -= off.dot(path.row(1)) / variance;
    information += speed * speed / variance;
    across += std::pow((off.x() * path(1, 1) - off.y() * path(1, 0)) / speed, 2) / variance;
    ++seen;
  }
  if (seen < 2 || !(information > 0)) return std::nullopt;
  // What a body's jerk does, all its markers do together.
  return Lateness{along / information, std::sqrt(seen / information), across / seen};
}

// About to begin to move: by this share of a person's usual acceleration.
dynamics::PathState TimedPaths::AtRest(const dynamics::PathSample& last, double frame_s, double beginning) const {
  constexpr double kDriftPx = 0.05;
  return dynamics::StartAt(last, {kDriftPx / frame_s, beginning * prior_.acceleration});
}

// nullopt where it is not seen on both sides.
std::optional<TimedPaths::MarkerRun> TimedPaths::RunOf(const motion::MarkerTrack& marker,
                                                       const std::vector<std::size_t>& frames, std::size_t first,
                                                       std::size_t end) const {
  // By which coding changes a copy, and displaces what begins to move.
  constexpr double kCopyPx = 0.05, kHiddenPx = 0.1;
  constexpr std::size_t kFewest = 4, kAfter = 6;
  MarkerRun seen;
  seen.before = Beside(marker, frames, static_cast<std::ptrdiff_t>(first) - 1, -1, -1);
  seen.behind = Beside(marker, frames, static_cast<std::ptrdiff_t>(end), static_cast<std::ptrdiff_t>(frames.size()), 1);
  if (seen.before.size() < kFewest || seen.behind.empty()) return std::nullopt;
  std::reverse(seen.behind.begin(), seen.behind.end());
  seen.behind.resize(std::min(seen.behind.size(), kAfter));
  for (dynamics::PathSample& sample : seen.behind) sample.sigma = std::hypot(sample.sigma, kHiddenPx);
  dynamics::PathState shown = dynamics::StartAt(seen.before.back(), prior_);
  for (std::size_t f = first; f < end; ++f) {
    const motion::MarkerSample& sample = marker.samples[frames[f]];
    if (!sample.IsKnown()) continue;
    seen.run.push_back({recording_.time_s[frames[f]], sample.position,
                        std::hypot(sample.sigma, std::hypot(learnt_.extra_sigma, kCopyPx))});
    seen.log_copied += dynamics::Observe(seen.run.back(), shown);
  }
  seen.run_s = recording_.time_s[frames[first]] - seen.before.back().time_s;
  seen.end_s = recording_.time_s[frames[end - 1]];
  return seen;
}

// What follows a run if the marker rested in it: it starts to move, more or less quickly.
double TimedPaths::LogDensityOfStart(const MarkerRun& seen, double density) const {
  constexpr std::array kBeginnings = {0.02, 0.2};  // shares of a person's acceleration
  std::vector<double> starts;
  for (const double beginning : kBeginnings) {
    Course course{AtRest(seen.before.back(), seen.run_s, beginning), seen.end_s};
    starts.push_back(Follow(seen.behind, density, prior_, course) - std::log(kBeginnings.size()));
  }
  return LogSum(starts);
}

TimedPaths::RunLogs TimedPaths::LogsAt(const MarkerRun& seen, double density, double stood_s) const {
  Course alone{dynamics::StartAt(seen.behind.front(), prior_), seen.behind.front().time_s};
  const double unrelated =
      Follow(std::span(seen.behind).subspan(1), density, prior_, alone) - 2 * std::log(kReach_mm / unit_mm_);
  const auto or_unrelated = [&](double log_density, double share) {
    return LogSum({std::log(1 - share) + log_density, std::log(share) + unrelated});
  };
  const double begin_s = seen.before.back().time_s;
  const auto [told, weight] = dynamics::EvidenceAt(seen.before, begin_s, density, prior_);
  const auto repeated = [&, &told = told, &weight = weight](double earlier_s) {
    Course course{told, begin_s};
    return weight + seen.log_copied +
           or_unrelated(Follow(seen.behind, density, prior_, course, earlier_s), kMismeasured);
  };
  Course course{told, begin_s};
  const double moving = weight + Follow(seen.run, density, prior_, course);
  const double moving_on = Follow(seen.behind, density, prior_, course);
  const double stopped = weight + seen.log_copied + LogOddsOfStop(told, seen.run_s, density, prior_);
  const double starting = LogDensityOfStart(seen, density);
  const auto new_pictures = [&](double share) {
    return LogSum({moving + or_unrelated(moving_on, share), stopped + or_unrelated(starting, share)});
  };
  return {.going_on = repeated(0),
          .standing = repeated(stood_s),
          .rested = new_pictures(kMismeasured),
          .cut = new_pictures(kUnrelated)};
}

// Of one marker; nullopt where it is not seen on both sides.
std::optional<TimedPaths::RunLogs> TimedPaths::LogsOfRun(const motion::MarkerTrack& marker,
                                                         const std::vector<std::size_t>& frames, std::size_t first,
                                                         std::size_t end, double stood_s) const {
  const auto seen = RunOf(marker, frames, first, end);
  if (!seen) return std::nullopt;
  std::array<RunLogs, kDensities> at;
  for (std::size_t k = 0; k < kDensities; ++k) at[k] = LogsAt(*seen, DensityOf(k, learnt_.density), stood_s);
  const auto sum = [&at](double RunLogs::*log) {
    std::vector<double> logs;
    logs.reserve(kDensities);
    for (const RunLogs& one : at) logs.push_back(one.*log);
    return LogSum(logs);
  };
  return RunLogs{.going_on = sum(&RunLogs::going_on),
                 .standing = sum(&RunLogs::standing),
                 .rested = sum(&RunLogs::rested),
                 .cut = sum(&RunLogs::cut)};
}

double TimedPaths::LogOddsOfRepeat(const std::vector<std::size_t>& frames, std::size_t first, std::size_t end,
                                   double frame_s) const {
  // Prior odds: a repetition is a third as likely with each frame more, down to a frozen picture's; that no time passes
  // meanwhile, a hundredth of it without end.
  constexpr double kEachFrame = 0.3, kFrozen = 0.01, kClockStands = 0.01, kCut = 1e-6;
  const double stood_s = recording_.time_s[frames[end]] - recording_.time_s[frames[first - 1]] - frame_s;
  RunLogs all;
  for (const motion::MarkerTrack& marker : recording_.markers)
    if (const auto logs = LogsOfRun(marker, frames, first, end, stood_s)) {
      all.going_on += logs->going_on;
      all.standing += logs->standing;
      all.rested += logs->rested;
      all.cut += logs->cut;
    }
  const double repeated = static_cast<double>(end - first - 1) * std::log(kEachFrame);
  return LogSum(
             {std::max(repeated, std::log(kFrozen)) + all.going_on, repeated + std::log(kClockStands) + all.standing}) -
         LogSum({all.rested, std::log(kCut) + all.cut});
}

double TimedPaths::LogLikelihoodQuickly(const std::vector<std::size_t>& frames,
                                        const std::vector<double>& time_s) const {
  constexpr double kUsualError_px = 0.05;  // of coding; what is learnt holds wrong times' as well
  const double extra_sigma = std::min(learnt_.extra_sigma, kUsualError_px);
  double log_likelihood = 0;
  for (std::vector<dynamics::PathSample>& path : PathsAt(frames, time_s)) {
    if (path.empty()) continue;
    for (dynamics::PathSample& sample : path) sample.sigma = std::hypot(sample.sigma, extra_sigma);
    log_likelihood += dynamics::EvidenceAt(path, path.back().time_s, learnt_.density, prior_).log_likelihood;
  }
  return log_likelihood;
}

double TimedPaths::LogLikelihood(const std::vector<std::size_t>& frames, const std::vector<double>& time_s) const {
  return dynamics::LearnMotion(PathsAt(frames, time_s), unit_mm_).log_likelihood;
}

}  // namespace lake::tracking
