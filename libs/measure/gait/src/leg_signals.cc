#include "leg_signals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/core/threads.h"
#include "noise_from_differences.h"
#include "sizes.h"

namespace lake::gait {
namespace {

// Skin jumps on the bone, and a foot that strikes stops between two frames: how far a marker may be off a smooth path,
// with its speed as the movement over a moment, which a wrong position hardly changes.
std::vector<double> Jolts(const Detections& d, const std::vector<double>& time_s, double skin) {
  const double interval_s = MedianInterval(time_s);
  const std::size_t n = time_s.size();
  std::vector<double> jolts(n, skin);
  for (std::size_t i = 0, begin = 0, end = 0; i < n; ++i) {
    while (begin < i && (!d.seen[begin] || time_s[begin] < time_s[i] - kMovement_s)) ++begin;
    while (end + 1 < n && time_s[end + 1] <= time_s[i] + kMovement_s) ++end;
    std::size_t last = end;
    while (last > begin && !d.seen[last]) --last;
    if (last == begin || !d.seen[begin]) continue;
    const Eigen::Vector2d moved = d.track->samples[last].position - d.track->samples[begin].position;
    jolts[i] += moved.norm() / std::max(time_s[last] - time_s[begin], kMovement_s) * interval_s;
  }
  return jolts;
}

// The steps of a marker between the frames in which it is seen.
struct Steps {
  std::vector<std::size_t> frames;
  std::vector<Eigen::Vector2d> step;  // from the frame before, per usual interval; of the first: 0
  double interval_s = 0;              // between frames, usually
};

Steps FindSteps(const Detections& d, const std::vector<double>& time_s) {
  Steps steps;
  steps.interval_s = MedianInterval(time_s);
  for (std::size_t i = 0; i < d.seen.size(); ++i)
    if (d.seen[i]) steps.frames.push_back(i);
  steps.step.assign(steps.frames.size(), Eigen::Vector2d::Zero());
  for (std::size_t k = 1; k < steps.frames.size(); ++k)
    steps.step[k] = (d.in_plane[steps.frames[k]] - d.in_plane[steps.frames[k - 1]]) * steps.interval_s /
                    (time_s[steps.frames[k]] - time_s[steps.frames[k - 1]]);
  return steps;
}

// The median step around one, and how far steps there lie from it.
struct UsualStep {
  Eigen::Vector2d median;
  double spread = 0;
};

UsualStep UsualStepAround(const Steps& steps, std::size_t k) {
  constexpr std::size_t kReach = 5;  // frames on each side
  const std::size_t begin = k > kReach ? k - kReach : 1, end = std::min(steps.step.size(), k + kReach + 1);
  std::vector<double> x, y, distances;
  for (std::size_t j = begin; j < end; ++j) {
    x.push_back(steps.step[j].x());
    y.push_back(steps.step[j].y());
  }
  UsualStep usual{{Median(x), Median(y)}, 0};
  for (std::size_t j = begin; j < end; ++j) distances.push_back((steps.step[j] - usual.median).norm());
  usual.spread = 1.4826 * Median(distances);
  return usual;
}

// How far a step may lie from the others beside it, spread apart.
double OrdinaryStep(const Detections& d, std::size_t frame) {
  return (12 + d.jolt[frame] / d.sigma[frame]) * d.plane_sigma[frame];
}

// Whether a step is far from those around it.
bool IsJump(const Detections& d, const Steps& steps, std::size_t k) {
  const UsualStep usual = UsualStepAround(steps, k);
  return (steps.step[k] - usual.median).norm() > 5 * usual.spread + OrdinaryStep(d, steps.frames[k]);
}

// Samples are mistrusted from a jump away to the jump back: with the marker then where it would have been without them.
// More than half a second away is not an outlier but a question of naming.
void MistrustExcursions(Detections& d, const std::vector<double>& time_s) {
  constexpr double kLongest_s = 0.5;
  const Steps steps = FindSteps(d, time_s);
  const std::vector<std::size_t>& frames = steps.frames;
  for (std::size_t k = 1; k < frames.size(); ++k) {
    if (!IsJump(d, steps, k)) continue;
    const UsualStep usual = UsualStepAround(steps, k);
    const double jump = (steps.step[k] - usual.median).norm(), noise = OrdinaryStep(d, frames[k]);
    for (std::size_t back = k + 1; back < frames.size() && time_s[frames[back]] - time_s[frames[k]] <= kLongest_s;
         ++back) {
      const double gap = (time_s[frames[back]] - time_s[frames[k - 1]]) / steps.interval_s;
      const double away = (d.in_plane[frames[back]] - d.in_plane[frames[k - 1]] - gap * usual.median).norm();
      if (away > std::min(3 * usual.spread * gap + noise, jump / 2) || !IsJump(d, steps, back)) continue;
      for (std::size_t j = k; j < back; ++j) d.trusted[frames[j]] = 0;
      k = back;
      break;
    }
  }
}

double MeanDirection(const std::vector<Eigen::Vector2d>& vectors) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& v : vectors)
    if (v.allFinite() && v.norm() > 0) sum += v.normalized();
  return std::atan2(sum.x(), sum.y());
}

double MeanOfKnown(const std::vector<double>& values) {
  double sum = 0;
  std::size_t count = 0;
  for (const double value : values)
    if (std::isfinite(value)) {
      sum += value;
      ++count;
    }
  return sum / static_cast<double>(count);
}

std::size_t Known(const std::vector<double>& values) {
  return static_cast<std::size_t>(
      std::count_if(values.begin(), values.end(), [](double v) { return std::isfinite(v); }));
}

bool IsLength(int state) {
  return state == kShankLength || state == kThighLength || state == kTrunkLength;
}

// In the order of LegState, for messages.
constexpr std::array<const char*, kLegStates> kStateNames = {"ankle (x)",     "ankle (y)",      "shank's angle",
                                                             "thigh's angle", "shank's length", "thigh's length",
                                                             "trunk's angle", "trunk's length"};

struct SmoothedSignals {
  SplineGrid grid;
  std::vector<SmoothSignal> signals;
  double risk = 0;
};

SmoothedSignals SmoothOn(double step_s, const LegSignals& signals, const std::vector<double>& time_s, int states,
                         const LegFitOptions& options) {
  SmoothedSignals smoothed;
  smoothed.grid = MakeSplineGrid(time_s, step_s);
  SmoothingOptions smoothing;
  if (options.filter == LegFilter::kSpline) smoothing.cutoff_hz = options.cutoff_hz;
  smoothing.max_iterations = options.most_smoothing_iterations;
  smoothed.signals.resize(static_cast<std::size_t>(states));
  constexpr int kMostThreads = 2;  // each takes some 0.4 kB a frame meanwhile, and half an hour at 60 Hz has 108000
  ForEachInThreads(smoothed.signals.size(), std::min(Threads(), kMostThreads), [&](std::size_t s) {
    SmoothSignal& signal = smoothed.signals[s];
    signal = FitSmoothingSpline(smoothed.grid, time_s, signals.value[s], signals.sigma[s], smoothing);
    signal.covariance = BandedMatrix(0, 3);  // nobody asks for it here
  });
  for (const SmoothSignal& signal : smoothed.signals) smoothed.risk += signal.risk;
  return smoothed;
}

// Two segments that meet in a joint: by their places in the state, and the joint's marker.
struct Joint {
  LegMarker marker;
  LegState lower_angle, lower_length, upper_angle, upper_length;
};
constexpr Joint kJoints[] = {{kKnee, kShankAngle, kShankLength, kThighAngle, kThighLength},
                             {kHip, kThighAngle, kThighLength, kTrunkAngle, kTrunkLength}};

struct Length {
  double usual = 0, deviation = 0;
};

Length LengthOf(const std::vector<double>& values) {
  std::vector<double> known;
  for (const double value : values)
    if (std::isfinite(value)) known.push_back(value);
  if (known.empty()) return {};
  return {Median(known), RobustDeviation(known)};
}

// The side to which a joint bends, all in all: positive if the lower segment leans farther forward.
double SideOf(const Joint& joint, const LegSignals& signals) {
  double bend = 0;
  for (std::size_t i = 0; i < signals.value[joint.lower_angle].size(); ++i)
    if (const double sine = std::sin(signals.value[joint.lower_angle][i] - signals.value[joint.upper_angle][i]);
        std::isfinite(sine))
      bend += sine;
  return std::copysign(1.0, bend);
}

// An angle of the triangle whose sides are two segments and the line between their far ends.
struct TriangleAngle {
  double rad, sigma;
};

TriangleAngle AngleBeside(const Length& side, const Length& opposite, double line) {
  const double cosine = std::clamp(
      (side.usual * side.usual + line * line - opposite.usual * opposite.usual) / (2 * side.usual * line), -1.0, 1.0);
  const double sigma = std::hypot((1 / line - cosine / side.usual) * side.deviation,
                                  opposite.usual / (side.usual * line) * opposite.deviation);
  // Where the joint is nearly straight its angle goes with the root of the cosine's error.
  return {std::acos(cosine), sigma / std::max(std::sqrt(1 - cosine * cosine), std::sqrt(sigma))};
}

// Returns whether there is anything to bend.
bool BendHiddenJoint(const Joint& joint, const std::array<Detections, kLegMarkers>& leg,
                     const Eigen::Matrix2d& leg_from_plane, LegSignals& signals) {
  const Detections &below = leg[joint.marker - 1u], &above = leg[joint.marker + 1u], &own = leg[joint.marker];
  const Length lower = LengthOf(signals.value[joint.lower_length]), upper = LengthOf(signals.value[joint.upper_length]);
  if (!(lower.usual > 0 && upper.usual > 0)) return false;
  bool bent = false;
  const double side = SideOf(joint, signals);
  const auto set = [&](LegState angle, std::size_t i, double mean_rad, double rad, double sigma) {
    signals.value[angle][i] = mean_rad + std::remainder(rad - mean_rad, 2 * std::numbers::pi);
    signals.sigma[angle][i] = sigma;
  };
  const double lower_mean = MeanOfKnown(signals.value[joint.lower_angle]),
               upper_mean = MeanOfKnown(signals.value[joint.upper_angle]);
  for (std::size_t i = 0; i < own.trusted.size(); ++i) {
    if (own.trusted[i] || !below.trusted[i] || !above.trusted[i]) continue;
    const Eigen::Vector2d line = leg_from_plane * (above.in_plane[i] - below.in_plane[i]);
    if (!(line.norm() > 0)) continue;
    const double line_rad = std::atan2(line.x(), line.y()),
                 noise = std::hypot(below.plane_sigma[i], above.plane_sigma[i]) / line.norm();
    const TriangleAngle at_lower = AngleBeside(lower, upper, line.norm()),
                        at_upper = AngleBeside(upper, lower, line.norm());
    set(joint.lower_angle, i, lower_mean, line_rad + side * at_lower.rad, std::hypot(at_lower.sigma, noise));
    set(joint.upper_angle, i, upper_mean, line_rad - side * at_upper.rad, std::hypot(at_upper.sigma, noise));
    bent = true;
  }
  return bent;
}

}  // namespace

Detections CollectDetections(const motion::MarkerRecording& recording, const motion::MarkerTrack& track,
                             const LegView& view, double skin) {
  const std::size_t n = recording.Frames();
  Detections d{track.name,
               &track,
               view.Depth(track.name),
               std::vector<char>(n),
               {},
               std::vector<double>(n),
               {},
               std::vector<Eigen::Vector2d>(n),
               std::vector<double>(n),
               {}};
  for (std::size_t i = 0; i < n; ++i) d.seen[i] = track.samples[i].status == motion::SampleStatus::kDetected;
  for (std::size_t i = 0; i < n; ++i) {
    const motion::MarkerSample& sample = track.samples[i];
    if (!d.seen[i]) continue;
    if (!sample.position.allFinite() || !std::isfinite(sample.sigma) || sample.sigma < 0)
      throw Fail("marker '{}', frame {}: position ({}, {}) with sigma {} is not usable", track.name, recording.frame[i],
                 sample.position.x(), sample.position.y(), sample.sigma);
    try {
      d.in_plane[i] = PlaneFromRecorded(view, sample.position, d.depth_mm);
    } catch (const Error& error) {
      throw Fail("marker '{}', frame {}: {}", track.name, recording.frame[i], error.what());
    }
  }
  const double estimate = NoiseFromDifferences(track, d.seen);
  for (std::size_t i = 0; i < n; ++i) {
    if (!d.seen[i]) continue;
    d.sigma[i] = track.samples[i].sigma > 0 ? track.samples[i].sigma : estimate;
    d.plane_sigma[i] = d.sigma[i] * PlaneUnitsPerRecorded(view, d.in_plane[i], d.depth_mm);
  }
  d.trusted = d.seen;
  d.jolt = Jolts(d, recording.time_s, skin);
  MistrustExcursions(d, recording.time_s);
  return d;
}

void MistrustTheLone(Detections& d, const std::vector<double>& time_s) {
  const Steps steps = FindSteps(d, time_s);
  const std::vector<std::size_t>& frames = steps.frames;
  std::vector<std::size_t> begins;  // of the pieces: after a gap, or a jump
  for (std::size_t k = 1; k < frames.size(); ++k)
    if (frames[k] > frames[k - 1] + 1 || IsJump(d, steps, k)) begins.push_back(k);
  std::vector<std::size_t> lone;
  for (std::size_t p = 0; p + 1 < begins.size(); ++p) {
    const std::size_t begin = begins[p], end = begins[p + 1];
    const double seen_s = time_s[frames[end - 1]] - time_s[frames[begin]] + steps.interval_s;
    const double hidden_s = time_s[frames[end]] - time_s[frames[begin - 1]] - steps.interval_s - seen_s;
    if (end - begin < kLeastFrames && hidden_s > std::max(seen_s, SmoothingOptions{}.memory_s))
      for (std::size_t k = begin; k < end; ++k) lone.push_back(frames[k]);
  }
  if (2 * lone.size() > frames.size()) return;
  for (const std::size_t i : lone) d.trusted[i] = 0;
}

LegSignals MakeLegSignals(const std::array<Detections, kLegMarkers>& leg, const Eigen::Matrix2d& leg_from_plane,
                          int states) {
  constexpr int kAngles[] = {kShankAngle, kThighAngle, kTrunkAngle},
                kLengths[] = {kShankLength, kThighLength, kTrunkLength};
  const std::size_t n = leg[kAnkle].seen.size();
  const double unknown = motion::LegSample::kUnknown;
  LegSignals signals;
  for (auto* columns : {&signals.value, &signals.sigma})
    for (auto& column : *columns) column.assign(n, unknown);
  for (std::size_t i = 0; i < n; ++i) {
    if (!leg[kAnkle].trusted[i]) continue;
    const Eigen::Vector2d ankle = leg_from_plane * leg[kAnkle].in_plane[i];
    signals.value[kAnkleX][i] = ankle.x();
    signals.value[kAnkleY][i] = ankle.y();
    signals.sigma[kAnkleX][i] = signals.sigma[kAnkleY][i] = leg[kAnkle].plane_sigma[i];
  }
  const int segments = states == kLegStates ? 3 : 2;
  for (int segment = 0; segment < segments; ++segment) {
    const Detections &below = leg[static_cast<std::size_t>(segment)],
                     &above = leg[static_cast<std::size_t>(segment) + 1];
    std::vector<Eigen::Vector2d> vectors(n, Eigen::Vector2d::Constant(unknown));
    for (std::size_t i = 0; i < n; ++i)
      if (below.trusted[i] && above.trusted[i]) vectors[i] = leg_from_plane * (above.in_plane[i] - below.in_plane[i]);
    const double mean_rad = MeanDirection(vectors);
    const auto angle = static_cast<std::size_t>(kAngles[segment]), length = static_cast<std::size_t>(kLengths[segment]);
    for (std::size_t i = 0; i < n; ++i) {
      if (!(vectors[i].norm() > 0)) continue;
      const double sigma = std::hypot(below.plane_sigma[i], above.plane_sigma[i]);
      signals.value[angle][i] =
          mean_rad + std::remainder(std::atan2(vectors[i].x(), vectors[i].y()) - mean_rad, 2 * std::numbers::pi);
      signals.sigma[angle][i] = sigma / vectors[i].norm();
      signals.value[length][i] = vectors[i].norm();
      signals.sigma[length][i] = sigma;
    }
  }
  return signals;
}

std::set<int> BendHiddenJoints(const std::array<Detections, kLegMarkers>& leg, const Eigen::Matrix2d& leg_from_plane,
                               int states, LegSignals& signals) {
  std::set<int> bent;
  for (const Joint& joint : kJoints)
    if ((joint.marker == kKnee || states == kLegStates) && BendHiddenJoint(joint, leg, leg_from_plane, signals))
      bent.insert({joint.lower_angle, joint.upper_angle});
  return bent;
}

void CheckIsSeen(const LegSignals& signals, const std::array<Detections, kLegMarkers>& leg) {
  for (const int length : {kShankLength, kThighLength}) {
    const std::size_t below = length == kShankLength ? kAnkle : kKnee;
    const std::size_t frames = Known(signals.value[static_cast<std::size_t>(length)]);
    if (frames < kLeastFrames)
      throw Fail("leg fit: '{}' and '{}' are seen together in {} frames only; at least {} are needed", leg[below].name,
                 leg[below + 1].name, frames, kLeastFrames);
  }
}

std::string UnsettledWarning(const std::string& what) {
  return fmt::format(
      "{}: how smooth the motion is could not be settled, so angle, speed and their sigmas are less certain than they "
      "say; give a --cutoff, or look for outliers and wrong names",
      what);
}

// A low cutoff takes motion for noise. The leg fit keeps the cutoff where its sigmas are those of that noise, alike for
// all, and its priors go with them.
void KeepCutoff(const std::vector<SmoothSignal>& signals, LegStart& start) {
  for (const SmoothSignal& signal : signals) start.sigma_scale = std::max(start.sigma_scale, signal.noise_scale);
  for (std::size_t s = 0; s < signals.size(); ++s)
    for (double& roughness : start.priors[s].roughness)
      roughness *= std::pow(start.sigma_scale / signals[s].noise_scale, 2);
}

// A person moves as a whole: a segment that is hidden may move as quickly as another one does at times, or as one that
// is seen meanwhile. The likeliest path is that of the segment's own movement; how uncertain it is, this tells.
void QuickenWithOthers(std::vector<SmoothSignal>& signals) {
  std::vector<SmoothSignal*> angles;
  for (const std::size_t s : {kShankAngle, kThighAngle, kTrunkAngle})
    if (s < signals.size()) angles.push_back(&signals[s]);
  for (std::size_t k = 0; k < angles.front()->roughness.size(); ++k) {
    double quickest = 0;
    for (const SmoothSignal* angle : angles)
      quickest = std::max({quickest, angle->quickest_roughness, (1 - angle->change[k]) * angle->roughness[k]});
    for (SmoothSignal* angle : angles)
      angle->roughness[k] += angle->change[k] * std::max(0.0, quickest - angle->quickest_roughness);
  }
}

LegStart SmoothSignals(const LegSignals& signals, const std::vector<double>& time_s, int states,
                       const LegFitOptions& options) {
  const double frame_step_s = MedianInterval(time_s);
  // The coarsest grid that predicts the true curves as well as one knot per frame does.
  constexpr double kRiskTolerance = 4;
  SmoothedSignals best = SmoothOn(frame_step_s, signals, time_s, states, options);
  const double least_risk = best.risk;
  for (const double frames_per_knot : {4.0, 3.0, 2.0}) {
    SmoothedSignals candidate = SmoothOn(frames_per_knot * frame_step_s, signals, time_s, states, options);
    if (candidate.risk > least_risk + kRiskTolerance) continue;
    best = std::move(candidate);
    break;
  }

  LegStart start;
  start.grid = best.grid;
  start.coefficients.resize(best.grid.count * static_cast<std::size_t>(states));
  constexpr double kLengthMemory_s = 0.3;  // the slope of a length is alike over about this time
  for (std::size_t s = 0; s < static_cast<std::size_t>(states); ++s) {
    if (!best.signals[s].converged) start.unsettled.emplace_back(kStateNames[s]);
    start.priors[s].roughness = best.signals[s].roughness;
    if (IsLength(static_cast<int>(s)))
      // What a walk whose speeds' correlation falls off within the memory adds to its variance with each knot.
      start.priors[s].slope_variance =
          2 * best.signals[s].slope_square * best.grid.step_s * std::max(kLengthMemory_s, best.grid.step_s);
    for (std::size_t k = 0; k < best.grid.count; ++k)
      start.coefficients[k * static_cast<std::size_t>(states) + s] = best.signals[s].coefficients[k];
  }
  if (options.HasSplineCutoff())
    KeepCutoff(best.signals, start);
  else
    QuickenWithOthers(best.signals);
  for (std::size_t s = 0; s < static_cast<std::size_t>(states); ++s)
    start.priors[s].possible_roughness =
        options.HasSplineCutoff() ? start.priors[s].roughness : std::move(best.signals[s].roughness);
  start.knee_cutoff_hz = std::sqrt(best.signals[kShankAngle].cutoff_hz * best.signals[kThighAngle].cutoff_hz);
  return start;
}

void StartFrom(const LegSignals& signals, const std::set<int>& components, const std::vector<double>& time_s,
               int states, LegStart& start) {
  for (const int component : components) {
    const auto s = static_cast<std::size_t>(component);
    const SmoothSignal smooth = FitSmoothingSpline(start.grid, time_s, signals.value[s], signals.sigma[s]);
    for (std::size_t k = 0; k < start.grid.count; ++k)
      start.coefficients[k * static_cast<std::size_t>(states) + s] = smooth.coefficients[k];
  }
}

}  // namespace lake::gait
