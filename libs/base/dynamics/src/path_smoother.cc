#include "lake/dynamics/path_smoother.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "disturbance_smoother.h"
#include "lake/core/interrupt.h"
#include "lake/core/statistics.h"
#include "lake/core/threads.h"

namespace lake::dynamics {
namespace {

constexpr double kHalfPower = std::numbers::sqrt2 - 1;  // 1 / (1 + this) is −3 dB

std::size_t FirstSeen(const SeenPath& seen) {
  std::size_t first = 0;
  while (first < seen.sigma.size() && !seen.IsSeen(first)) ++first;
  return first;
}

// All axes by one filter, as they err alike.
class PathFilter {
 public:
  PathFilter(const SeenPath& seen) : seen_(seen), filter_(seen.time_s.size(), kAxisStates, seen.axes) {
    for (std::size_t i = 0; i < seen.time_s.size(); ++i) {
      filter_.At(i).first_row = filter_.rows.size();
      filter_.At(i).rows = seen.IsSeen(i);
      if (!seen.IsSeen(i)) continue;
      Row<kAxisStates>& row = filter_.rows.emplace_back();
      row.h << 1, 0, 0, seen.sigma[i];
      row.value = seen.place[i].transpose();
      row_frame_.push_back(i);
    }
  }

  double Forward(const PathModel& model, const MotionPrior& prior) {
    for (std::size_t k = 0; k < filter_.rows.size(); ++k)
      filter_.rows[k].variance = model.WhiteVariance(row_frame_[k], seen_.sigma[row_frame_[k]]);
    const Eigen::Matrix4d start = StartCovariance(model, prior);
    const std::size_t first = FirstSeen(seen_);
    const Eigen::RowVector3d first_place =
        first < seen_.place.size() ? Eigen::RowVector3d(seen_.place[first]) : Eigen::RowVector3d::Zero();
    return filter_.Forward([&](std::size_t i, Means<kAxisStates>& mean, Square<kAxisStates>& covariance) {
      Frame<kAxisStates>& frame = filter_.At(i);
      const Eigen::RowVector3d before = mean.row(kPosition);
      if (i > 0) {
        const AxisStep step = Step(model, i);
        step.Apply(mean);
        step.Apply(covariance);
        step.Apply(covariance.transpose());
        covariance.topLeftCorner<3, 3>() += model.density[i] * step.jerk;
        covariance(kLasting, kLasting) += model.lasting * (1 - step.kept * step.kept);
      }
      frame.starts = i == 0 || covariance(0, 0) > prior.reach * prior.reach;
      if (!frame.starts) return;
      mean.setZero();
      mean.row(kPosition) = i > 0 ? before : first_place;
      covariance = start;
    });
  }

  Frame<kAxisStates>& At(std::size_t frame) { return filter_.At(frame); }

  template <typename StateVisit, typename RowVisit, typename StepVisit>
  void Back(const PathModel& model, const StateVisit& state_visit, const RowVisit& row_visit,
            const StepVisit& step_visit) {
    filter_.Back(
        [&](std::size_t i, Backward<kAxisStates>& b) {
          const AxisStep step = Step(model, i);
          step.ApplyTransposed(b.r);
          step.ApplyTransposed(b.n);
          step.ApplyTransposed(b.n.transpose());
        },
        state_visit, row_visit, step_visit);
  }

  AxisStep Step(const PathModel& model, std::size_t frame) const {
    const double elapsed_s = seen_.time_s[frame] - seen_.time_s[frame - 1];
    return {elapsed_s, model.Kept(frame, elapsed_s)};
  }

 private:
  const SeenPath& seen_;
  Filter<kAxisStates> filter_;
  std::vector<std::size_t> row_frame_;
};

// What a variance's fixed-point step needs: the squares of the smoothed disturbances, and how many of them the
// measurements determine.
struct Evidence {
  double squares = 0, determined = 0;

  void Add(double more_squares, double more_determined) {
    squares += more_squares;
    determined += more_determined;
  }
  double Ratio() const { return squares / std::max(determined, 1e-30); }
};

struct PathEvidences {
  std::vector<Evidence> jerk;          // per frame, of the interval before it
  Evidence white, per_speed, lasting;  // of the first two as factors of the present variances
  std::vector<double> speed2;          // |ẋ|², per frame
  double log_likelihood = 0;
};

PathEvidences Examine(const SeenPath& seen, const PathModel& model, const MotionPrior& prior) {
  PathFilter filter(seen);
  PathEvidences found;
  const std::size_t n = seen.time_s.size();
  found.jerk.resize(n);
  found.speed2.resize(n);
  found.log_likelihood = filter.Forward(model, prior);
  filter.Back(
      model,
      [&](std::size_t i, const Backward<kAxisStates>& b) {
        const Frame<kAxisStates>& frame = filter.At(i);
        found.speed2[i] = (frame.mean.row(kVelocity) + frame.covariance.row(kVelocity) * b.r).squaredNorm();
      },
      [&](std::size_t i, const Values<kAxisStates>& u, double d) {
        const double variance = seen.sigma[i] * seen.sigma[i], speed2 = model.SpeedNoise(i);
        found.white.Add(variance * u.squaredNorm(), variance * seen.axes * d);
        found.per_speed.Add(speed2 * u.squaredNorm(), speed2 * seen.axes * d);
      },
      [&](std::size_t i, const Backward<kAxisStates>& b) {
        if (i == 0 || filter.At(i).starts) return;
        const AxisStep step = filter.Step(model, i);
        const double q = model.density[i];
        const auto r = b.r.topRows<3>();
        found.jerk[i] = {q * q * (r.transpose() * step.jerk * r).trace(),
                         q * seen.axes * (step.jerk * b.n.topLeftCorner<3, 3>()).trace()};
        const double fresh = model.lasting * (1 - step.kept * step.kept);
        found.lasting.Add(fresh * model.lasting * b.r.row(kLasting).squaredNorm(),
                          fresh * seen.axes * b.n(kLasting, kLasting));
      });
  return found;
}

// The evidence in a window around each frame.
std::vector<Evidence> InWindows(const std::vector<Evidence>& evidence, const std::vector<double>& time_s,
                                double window_s) {
  std::vector<Evidence> sums;
  sums.reserve(evidence.size());
  Evidence around;
  for (std::size_t i = 0, begin = 0, end = 0; i < evidence.size(); ++i) {
    for (; end < evidence.size() && time_s[end] <= time_s[i] + window_s; ++end)
      around.Add(evidence[end].squares, evidence[end].determined);
    for (; time_s[begin] < time_s[i] - window_s; ++begin)
      around.Add(-evidence[begin].squares, -evidence[begin].determined);
    sums.push_back({std::max(around.squares, 0.0), std::max(around.determined, 0.0)});
  }
  return sums;
}

// The variance in each window, which takes in a share of the whole.
std::vector<double> VariancesInWindows(const std::vector<Evidence>& evidence, const std::vector<double>& time_s,
                                       const LearningOptions& options, double axes) {
  Evidence whole;
  for (const Evidence& each : evidence) whole.Add(each.squares, each.determined);
  const double common = axes * options.common, usual = whole.squares / std::max(whole.determined, 1e-9);
  std::vector<double> variances;
  variances.reserve(evidence.size());
  for (const Evidence& window : InWindows(evidence, time_s, options.window_s))
    variances.push_back((window.squares + common * usual) / (window.determined + common));
  return variances;
}

double RmsSigma(const SeenPath& seen) {
  std::vector<double> sigmas;
  for (std::size_t i = 0; i < seen.sigma.size(); ++i)
    if (seen.IsSeen(i)) sigmas.push_back(seen.sigma[i]);
  return RootMeanSquare(sigmas);
}

constexpr double kLeastLastingShare = 0.08;  // where nothing else is known: no real noise is quite white
constexpr double kLeastLasting = 1e-4, kLeastWhite = 1e-3, kLeastPerSpeed_s2 = 1e-10;

// The next value of a variance of all frames: such steps are short, so they are made longer (over-relaxation).
double Next(double variance, double factor, double least) {
  constexpr double kStretch = 1.8;
  return std::max(variance * std::pow(factor, kStretch), least);
}

// One round of a path, whose lasting noise is that of all paths.
void Update(const SeenPath& seen, const PathEvidences& found, double lasting, const LearningOptions& options,
            double least_density, PathModel& model) {
  const double white = Next(model.white + model.jitter, found.white.Ratio(), kLeastWhite);
  model.density = VariancesInWindows(found.jerk, seen.time_s, options, seen.axes);
  for (double& density : model.density) density = std::max(density, least_density);
  if (options.trust == SigmaTrust::kNone) {
    model.white = white;
    model.per_speed_s2 = Next(model.per_speed_s2, found.per_speed.Ratio(), kLeastPerSpeed_s2);
    model.lasting = lasting;
  } else {
    const double scale = options.trust == SigmaTrust::kScale ? std::max(1.0, white) : 1;
    model.lasting = scale * std::max({1 - white / scale, options.lasting_share, kLeastLastingShare});
    model.not_averaged = scale * options.lasting_share;
    model.white = std::max(scale - model.lasting, kLeastWhite);
    model.jitter = std::max(0.0, white - scale);
  }
  model.speed2 = found.speed2;
}

// Of the lasting noise: τ and λ.
struct Memory {
  double time_s, length;
};

struct Learnt {
  std::vector<PathModel> models;
  double log_likelihood = 0;
};

Learnt LearnWithMemory(std::span<const SeenPath> paths, const MotionPrior& prior, const LearningOptions& options,
                       double least_density, std::vector<PathModel> models, const Memory& memory) {
  constexpr double kWorthARound = 1e-5;  // of the log-likelihood, per measurement
  for (PathModel& model : models) {
    model.memory_s = memory.time_s;
    model.memory_length = memory.length;
  }
  double measurements = 0;
  for (const SeenPath& seen : paths)
    measurements += seen.axes * static_cast<double>(std::ranges::count_if(seen.sigma, [](double s) { return s > 0; }));
  Learnt learnt;
  std::vector<PathEvidences> found(paths.size());
  learnt.log_likelihood = -INFINITY;
  for (int round = 0; round < options.most_rounds; ++round) {
    ThrowIfInterrupted();
    ForEachInThreads(paths.size(), Threads(), [&](std::size_t p) { found[p] = Examine(paths[p], models[p], prior); });
    const double before = std::exchange(learnt.log_likelihood, 0);
    Evidence lasting;
    for (const PathEvidences& each : found) {
      learnt.log_likelihood += each.log_likelihood;
      lasting.Add(each.lasting.squares, each.lasting.determined);
    }
    if (std::abs(learnt.log_likelihood - before) < kWorthARound * measurements) break;
    const double now = std::max(models.front().lasting, kLeastLasting),
                 next_lasting = Next(now, lasting.Ratio() / now, kLeastLasting);
    for (std::size_t p = 0; p < paths.size(); ++p)
      Update(paths[p], found[p], next_lasting, options, least_density, models[p]);
  }
  learnt.models = std::move(models);
  return learnt;
}

// In a gap the movement is no longer that of its sides with a chance that grows with the time to them; it is then the
// quickest of the recording.
void QuickenGaps(std::span<const SeenPath> paths, const LearningOptions& options, std::vector<PathModel>& models) {
  double quickest = 0;
  for (const PathModel& model : models) quickest = std::max(quickest, *std::ranges::max_element(model.density));
  for (std::size_t p = 0; p < paths.size(); ++p) {
    const SeenPath& seen = paths[p];
    const std::size_t n = seen.time_s.size();
    std::vector<double> away_s(n, INFINITY);
    double last_s = -INFINITY;
    for (std::size_t i = 0; i < n; ++i) {
      if (seen.IsSeen(i)) last_s = seen.time_s[i];
      away_s[i] = seen.time_s[i] - last_s;
    }
    last_s = INFINITY;
    for (std::size_t i = n; i-- > 0;) {
      if (seen.IsSeen(i)) last_s = seen.time_s[i];
      away_s[i] = std::min(away_s[i], last_s - seen.time_s[i]);
    }
    for (std::size_t i = 1; i < n; ++i) {
      const double middle_s = (away_s[i] + away_s[i - 1]) / 2, interval_s = seen.time_s[i] - seen.time_s[i - 1];
      const double chance = -std::expm1(-std::max(0.0, middle_s - interval_s / 2) / options.gap_memory_s);
      models[p].density[i] += chance * (quickest - models[p].density[i]);
    }
  }
}

// Of a place with the marker's jitter, of which the frame's white noise hides a part. The lasting noise that smoothing
// does not take away is in it whole, and of the rest what is left of the white noise: the path together with the
// lasting noise is known to that.
double VarianceWhereSeen(const Square<kAxisStates>& covariance, const PathModel& model, double sigma) {
  const double part = model.OfJitter(), of_jitter = (1 - part) * model.jitter * sigma * sigma;
  const Eigen::Vector4d place(1 - part, 0, 0, -part * sigma), with_lasting(1 - part, 0, 0, (1 - part) * sigma);
  const double variance = std::max(place.dot(covariance * place), 0.0) + of_jitter;
  if (model.not_averaged == 0) return variance;
  return std::max(variance,
                  with_lasting.dot(covariance * with_lasting) + of_jitter + model.not_averaged * sigma * sigma);
}

}  // namespace

SmoothedPath SmoothPath(const SeenPath& seen, const PathModel& model, const MotionPrior& prior) {
  PathFilter filter(seen);
  SmoothedPath path;
  const std::size_t n = seen.time_s.size();
  const int axes = seen.axes;
  path.point.resize(n);
  path.surprise.assign(n, Eigen::Vector3d::Zero());
  path.surprise_variance.assign(n, 0.0);
  filter.Forward(model, prior);
  filter.Back(
      model,
      [&](std::size_t i, const Backward<kAxisStates>& b) {
        const Frame<kAxisStates>& frame = filter.At(i);
        const Means<kAxisStates> mean = frame.mean + frame.covariance * b.r;
        const Square<kAxisStates> covariance = frame.covariance - frame.covariance * b.n * frame.covariance;
        PathPoint& point = path.point[i];
        point.position = mean.row(kPosition);
        point.velocity = mean.row(kVelocity);
        point.acceleration = mean.row(kAcceleration);
        double variance = std::max(covariance(kPosition, kPosition), 0.0);
        if (seen.IsSeen(i)) {
          const double sigma = seen.sigma[i], part = model.OfJitter();
          point.position += part * (seen.place[i] - point.position - sigma * mean.row(kLasting).transpose());
          variance = VarianceWhereSeen(covariance, model, sigma);
        }
        for (int a = 0; a < axes; ++a) point.position_covariance(a, a) = variance;
        point.velocity_variance = std::max(covariance(kVelocity, kVelocity), 0.0);
      },
      [&](std::size_t i, const Values<kAxisStates>& u, double d) {
        path.surprise[i] = u.transpose() / d;
        path.surprise_variance[i] = 1 / d;
      },
      [](auto&&...) {});
  return path;
}

std::vector<PathModel> LearnPaths(std::span<const SeenPath> paths, const MotionPrior& prior,
                                  const LearningOptions& options) {
  // The last two: films in which a pixel is so large.
  const std::array<Memory, 5> memories = {
      {{0.03, INFINITY}, {0.12, INFINITY}, {0.5, INFINITY}, {0.5, 3 / options.unit_mm}, {0.5, 1 / options.unit_mm}}};
  constexpr double kFirstCutoff = 0.25;   // of the rate: nothing is smoothed away before it is learnt to be noise
  constexpr double kLeastCutoffHz = 0.5;  // of human movement
  constexpr double kFirstLasting = 0.3, kFirstPerSpeed_s2 = 1e-6;
  std::vector<PathModel> models;
  double least_density = INFINITY;
  for (const SeenPath& seen : paths) {
    const std::size_t n = seen.time_s.size();
    PathModel& model = models.emplace_back();
    const double sigma = RmsSigma(seen), interval_s = MedianInterval(seen.time_s);
    model.density.assign(n, DensityOfCutoff(kFirstCutoff / interval_s, sigma, interval_s));
    model.lasting = std::max(options.lasting_share, kFirstLasting);
    model.white = std::max(1 - model.lasting, kLeastWhite);
    if (options.trust == SigmaTrust::kNone) model.per_speed_s2 = kFirstPerSpeed_s2;
    model.speed2.assign(n, 0.0);
    least_density = std::min(least_density, DensityOfCutoff(kLeastCutoffHz, sigma, interval_s));
  }
  constexpr double kLongestUnknown_s = 0.2;
  constexpr double kClear = 10;  // by so much must a shorter memory be likelier
  Learnt best;
  for (const Memory& memory : memories) {
    // Noise of unknown size that lasts longer would be taken for the movement itself.
    if (options.trust == SigmaTrust::kNone && memory.time_s > kLongestUnknown_s) break;
    Learnt learnt = LearnWithMemory(paths, prior, options, least_density, models, memory);
    if (best.models.empty() || learnt.log_likelihood > best.log_likelihood - kClear) best = std::move(learnt);
  }
  QuickenGaps(paths, options, best.models);
  return best.models;
}

SmoothedPath LearnAndSmooth(const SeenPath& seen, const MotionPrior& prior, const LearningOptions& options) {
  return SmoothPath(seen, LearnPaths({&seen, 1}, prior, options).front(), prior);
}

SeenPath UnseenPath(int axes, std::vector<double> time_s) {
  const std::size_t n = time_s.size();
  return {axes, std::move(time_s), std::vector(n, Eigen::Vector3d::Zero().eval()), std::vector<double>(n, NAN)};
}

std::vector<double> LowPass(std::span<const double> time_s, std::span<const double> values, double cutoff_hz) {
  constexpr double kSigma = 1e-3;  // all alike, and so small that the prior does not count
  SeenPath seen = UnseenPath(1, {time_s.begin(), time_s.end()});
  for (std::size_t i = 0; i < values.size(); ++i)
    if (std::isfinite(values[i])) seen.See(i, {values[i], 0}, kSigma);
  const PathModel model{std::vector(values.size(), DensityOfCutoff(cutoff_hz, kSigma, MedianInterval(time_s)))};
  const SmoothedPath path = SmoothPath(seen, model, PersonPrior(1));
  std::vector<double> passed;
  for (std::size_t i = 0; i < values.size(); ++i) passed.push_back(seen.IsSeen(i) ? path.point[i].position.x() : NAN);
  return passed;
}

double DensityOfCutoff(double cutoff_hz, double sigma, double interval_s) {
  return sigma * sigma * interval_s * std::pow(2 * std::numbers::pi * cutoff_hz, 6) / kHalfPower;
}

double CutoffOfDensity(double density, double sigma, double interval_s) {
  return std::pow(kHalfPower * density / (sigma * sigma * interval_s), 1.0 / 6) / (2 * std::numbers::pi);
}

}  // namespace lake::dynamics
