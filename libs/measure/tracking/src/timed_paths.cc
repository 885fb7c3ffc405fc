#include "timed_paths.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <numeric>

#include "lake/core/statistics.h"
#include "lake/dynamics/path_smoother.h"
#include "leg_scale.h"

namespace lake::tracking {
namespace {

constexpr std::size_t kDensities = 8;               // decades, …
constexpr int kAboveQuick = 1;                      // … so many of them above that of a quick movement
constexpr double kSudden = 30, kSuddenShare = 0.1;  // a jerk out of all that was before: times the density, how often
constexpr std::size_t kFewest = 4;                  // samples that a path is judged by
constexpr double kMismeasured = 1e-6,
                 kUnrelated = 0.5;  // shares of markers that are something else afterwards: usually, after a cut

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

// The state later; in the meantime a person goes no farther than one can.
dynamics::PathState MovedWithinReach(const dynamics::PathState& state, double elapsed_s, double density,
                                     const dynamics::MotionPrior& prior) {
  return dynamics::WithinReach(dynamics::Moved(state, elapsed_s, density), state.Position(), prior);
}

}  // namespace

double LogSum(const std::vector<double>& logs) {
  const double most = *std::max_element(logs.begin(), logs.end());
  if (!std::isfinite(most)) return most;
  double sum = 0;
  for (const double log : logs) sum += std::exp(log - most);
  return most + std::log(sum);
}

double Interval::LogIfCopied(double elapsed_s) const {
  return LogOfAll(&Marker::copied, elapsed_s, kMismeasured);
}

double Interval::LogIfNew(double elapsed_s) const {
  return LogOfAll(&Marker::is_new, elapsed_s, kMismeasured);
}

double Interval::LogIfCut(double elapsed_s) const {
  return LogOfAll(&Marker::is_new, elapsed_s, kUnrelated);
}

double Interval::LogOfAll(Ways Marker::*ways, double elapsed_s, double unrelated) const {
  double total = 0;
  for (const Marker& marker : markers_) total += Log(marker.*ways, elapsed_s, unrelated);
  return total;
}

double Interval::Log(const Ways& ways, double elapsed_s, double unrelated) const {
  std::vector<double> logs;
  for (const Way& way : ways) {
    const auto join = [&](double share, double density) {
      const dynamics::PathState moved = MovedWithinReach(way.before, elapsed_s, density, prior_);
      logs.push_back(std::log((1 - unrelated) * share) + way.log_weight +
                     dynamics::LogJoin(moved, way.behind, 0, density));
    };
    join(1 - sudden_share_, way.density);
    if (sudden_share_ > 0) join(sudden_share_, kSudden * way.density);
    logs.push_back(std::log(unrelated) + way.log_weight + log_unrelated_);
  }
  return LogSum(logs);
}

double Interval::LogRatioWithoutBest(double elapsed_s, double other_s, std::size_t best) const {
  std::vector<double> ratios;
  for (const Marker& marker : markers_)
    ratios.push_back(Log(marker.is_new, elapsed_s, kMismeasured) - Log(marker.is_new, other_s, kMismeasured));
  std::ranges::sort(ratios);
  ratios.resize(ratios.size() - std::min(best, ratios.size()));
  return std::accumulate(ratios.begin(), ratios.end(), 0.0);
}

double Interval::JumpMm(double elapsed_s) const {
  std::vector<double> jumps = {0, 0};
  for (const Marker& marker : markers_) {
    const Way& likeliest = *std::ranges::max_element(marker.is_new, {}, &Way::log_weight);
    jumps.push_back((likeliest.behind.Position() -
                     MovedWithinReach(likeliest.before, elapsed_s, likeliest.density, prior_).Position())
                        .norm());
  }
  std::ranges::nth_element(jumps, jumps.begin() + 1, std::greater());
  return unit_mm_ * jumps[1];
}

int Interval::Faster(double least_px_s) const {
  return static_cast<int>(std::ranges::count_if(markers_, [&](const Marker& marker) {
    const Way& likeliest = *std::ranges::max_element(marker.is_new, {}, &Way::log_weight);
    return likeliest.before.Velocity().norm() > least_px_s && likeliest.behind.Velocity().norm() > least_px_s;
  }));
}

TimedPaths::TimedPaths(const motion::MarkerRecording& recording, std::vector<std::size_t> frames)
    : recording_(recording), frames_(std::move(frames)), is_cut_(frames_.size(), false) {
  unit_mm_ = MillimetresPerPx(recording);
  prior_ = dynamics::PersonPrior(unit_mm_);
  learnt_ = dynamics::LearnMotion(PathsAt(recording.time_s), unit_mm_);
}

std::vector<double> TimedPaths::Times() const {
  std::vector<double> time_s;
  time_s.reserve(frames_.size());
  for (const std::size_t i : frames_) time_s.push_back(recording_.time_s[i]);
  return time_s;
}

double TimedPaths::UsualInterval() const {
  return MedianInterval(Times());
}

std::vector<std::vector<dynamics::PathSample>> TimedPaths::PathsAt(const std::vector<double>& time_s) const {
  std::vector<std::vector<dynamics::PathSample>> paths;
  for (const motion::MarkerTrack& marker : recording_.markers) {
    paths.emplace_back();
    for (const std::size_t i : frames_)
      if (const motion::MarkerSample& sample = marker.samples[i]; sample.IsKnown())
        paths.back().push_back({time_s[i], sample.position, sample.sigma});
  }
  return paths;
}

// A marker's samples from a frame on in this direction, the farthest first. Where nobody is seen for long, as between
// two passes through the picture, nothing says how time went on.
std::vector<dynamics::PathSample> TimedPaths::Beside(const motion::MarkerTrack& marker, std::size_t nearest,
                                                     int step) const {
  constexpr std::size_t kEnough = 8, kMost = 20;
  constexpr double kReach_s = 0.25, kLongestGap_s = 0.5, kFastest = 5;  // deviations of a person's speed
  std::vector<dynamics::PathSample> samples;
  double last_s = TimeAt(nearest);
  for (std::size_t at = nearest; at < frames_.size(); at += static_cast<std::size_t>(step)) {
    if (at != nearest && is_cut_[step > 0 ? at : at + 1]) break;
    const motion::MarkerSample& sample = marker.samples[frames_[at]];
    if (!sample.IsKnown()) continue;
    const double gap_s = std::abs(TimeAt(at) - last_s);
    if (samples.size() == kMost || gap_s > kLongestGap_s) break;
    if (!samples.empty() && (sample.position - samples.back().position).norm() > kFastest * prior_.speed * gap_s) break;
    if (samples.size() >= kEnough && std::abs(TimeAt(at) - samples.front().time_s) > kReach_s) break;
    last_s = TimeAt(at);
    samples.push_back({last_s, sample.position, std::hypot(sample.sigma, learnt_.extra_sigma)});
  }
  std::reverse(samples.begin(), samples.end());
  return samples;
}

double TimedPaths::Misfit(std::size_t at) const {
  constexpr double kNumbers = 6;  // of a state
  double squares = 0;
  int markers = 0;
  for (const motion::MarkerTrack& track : recording_.markers) {
    const auto before = Beside(track, at - 1, -1), behind = Beside(track, at, 1);
    if (before.size() < kFewest || behind.size() < kFewest) continue;
    const dynamics::PathState predicted = dynamics::EvidenceAt(before, TimeAt(at), learnt_.density, prior_).state,
                              seen = dynamics::EvidenceAt(behind, TimeAt(at), learnt_.density, prior_).state;
    const Eigen::LLT<Eigen::Matrix3d> covariance(predicted.covariance + seen.covariance);
    squares += covariance.matrixL().solve(seen.mean - predicted.mean).squaredNorm();
    ++markers;
  }
  return markers > 0 ? squares / (kNumbers * markers) : 0;
}

// nullopt where too little is seen to tell a path.
std::optional<Interval::Marker> TimedPaths::MarkerBetween(const motion::MarkerTrack& track, std::size_t first,
                                                          std::size_t end) const {
  constexpr double kCopyPx = 0.05;  // by which coding changes a copy
  constexpr double kHiddenPx = 0.1;
  constexpr std::ptrdiff_t kAfter = 6;
  constexpr double kDriftPx = 0.05;                           // in a frame, at rest
  constexpr std::array<double, 2> kBeginnings = {0.02, 0.2};  // shares of a person's acceleration, where one begins
  const auto before = Beside(track, first - 1, -1);
  auto behind = Beside(track, end, 1);
  if (first < end && std::ssize(behind) > kAfter) behind.erase(behind.begin(), behind.end() - kAfter);
  if (before.size() < kFewest || behind.size() < (first == end ? kFewest : 1)) return std::nullopt;
  if (first < end)
    for (dynamics::PathSample& sample : behind) sample.sigma = std::hypot(sample.sigma, kHiddenPx);
  std::vector<dynamics::PathSample> run;
  double log_copied = 0;
  dynamics::PathState shown = dynamics::StartAt(before.back(), prior_);
  for (std::size_t at = first; at < end; ++at) {
    const motion::MarkerSample& sample = track.samples[frames_[at]];
    if (!sample.IsKnown()) continue;
    run.push_back({TimeAt(at), sample.position, std::hypot(sample.sigma, std::hypot(learnt_.extra_sigma, kCopyPx))});
    log_copied += dynamics::Observe(run.back(), shown);
  }
  Interval::Marker marker;
  for (std::size_t k = 0; k < kDensities; ++k) {
    const double density = DensityOf(k, learnt_.density);
    const auto from = dynamics::EvidenceAt(before, TimeAt(first - 1), density, prior_),
               to = dynamics::EvidenceAt(behind, TimeAt(end), density, prior_);
    const double weight = from.log_likelihood + to.log_likelihood;
    marker.copied.push_back({weight + log_copied, density, from.state, to.state});
    Interval::Way through{weight, density, from.state, to.state};
    double at_s = TimeAt(first - 1);
    for (const dynamics::PathSample& sample : run) {
      through.before = MovedWithinReach(through.before, sample.time_s - at_s, density, prior_);
      through.log_weight += dynamics::Observe(sample, through.before);
      at_s = sample.time_s;
    }
    through.before = dynamics::Moved(through.before, TimeAt(end - 1) - at_s, density);
    marker.is_new.push_back(through);
    if (first == end) continue;
    const double frame_s = TimeAt(first) - TimeAt(first - 1),
                 stopped = weight + log_copied + LogOddsOfStop(from.state, frame_s, density, prior_);
    for (const double beginning : kBeginnings)
      marker.is_new.push_back({stopped - std::log(kBeginnings.size()), density,
                               dynamics::StartAt(before.back(), {kDriftPx / frame_s, beginning * prior_.acceleration}),
                               to.state});
  }
  return marker;
}

Interval TimedPaths::Between(std::size_t first, std::size_t end) const {
  Interval interval;
  interval.unit_mm_ = unit_mm_;
  interval.prior_ = prior_;
  interval.sudden_share_ = first == end ? kSuddenShare : 0;
  interval.log_unrelated_ =
      -2 * std::log(kReach_mm / unit_mm_ * prior_.speed * prior_.acceleration) - 2 * std::log(2 * std::numbers::pi);
  for (const motion::MarkerTrack& track : recording_.markers)
    if (auto marker = MarkerBetween(track, first, end)) interval.markers_.push_back(*std::move(marker));
  return interval;
}

// One Gauss–Newton step: all that a body's jerk does, its markers do together.
std::vector<std::optional<Lateness>> TimedPaths::LatenessOfAll() const {
  struct Sums {
    double along = 0, information = 0, across = 0;
    int seen = 0;
  };
  std::vector<Sums> sums(frames_.size());
  const std::vector<double> time_s = Times();
  for (const motion::MarkerTrack& track : recording_.markers) {
    dynamics::SeenPath seen = dynamics::UnseenPath(2, time_s);
    for (std::size_t at = 0; at < frames_.size(); ++at)
      if (const motion::MarkerSample& sample = track.samples[frames_[at]]; sample.IsKnown())
        seen.See(at, sample.position, std::hypot(sample.sigma, learnt_.extra_sigma));
    const dynamics::SmoothedPath path =
        dynamics::SmoothPath(seen, {std::vector(frames_.size(), learnt_.density)}, prior_);
    for (std::size_t at = 0; at < frames_.size(); ++at) {
      const Eigen::Vector2d velocity = path.point[at].velocity.head<2>(), off = path.surprise[at].head<2>();
      const double speed = velocity.norm(), variance = path.surprise_variance[at];
      if (!seen.IsSeen(at) || !(speed > 0)) continue;
      sums[at].along += off.dot(velocity) / variance;
      sums[at].information += speed * speed / variance;
      sums[at].across += std::pow((off.x() * velocity.y() - off.y() * velocity.x()) / speed, 2) / variance;
      ++sums[at].seen;
    }
  }
  std::vector<std::optional<Lateness>> lateness;
  for (const Sums& sum : sums) {
    lateness.emplace_back();
    if (sum.seen >= 2)
      lateness.back() = {sum.along / sum.information, std::sqrt(sum.seen / sum.information), sum.across / sum.seen};
  }
  return lateness;
}

double TimedPaths::LogLikelihoodQuickly(const std::vector<double>& time_s) const {
  constexpr double kUsualError_px = 0.05;  // of coding; what is learnt holds wrong times' as well
  const double extra_sigma = std::min(learnt_.extra_sigma, kUsualError_px);
  double log_likelihood = 0;
  for (std::vector<dynamics::PathSample>& path : PathsAt(time_s)) {
    if (path.empty()) continue;
    for (dynamics::PathSample& sample : path) sample.sigma = std::hypot(sample.sigma, extra_sigma);
    log_likelihood += dynamics::EvidenceAt(path, path.back().time_s, learnt_.density, prior_).log_likelihood;
  }
  return log_likelihood;
}

double TimedPaths::LogLikelihood(const std::vector<double>& time_s) const {
  return dynamics::LearnMotion(PathsAt(time_s), unit_mm_).log_likelihood;
}

}  // namespace lake::tracking
