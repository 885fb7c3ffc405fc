#include "detections.h"

#include <algorithm>
#include <cmath>

#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "noise_from_differences.h"
#include "sizes.h"

namespace lake::gait {
namespace {

// Skin jumps on the bone, and a foot that strikes stops between two frames: how far a marker may be off a smooth path,
// with its speed as the movement over a moment, which a wrong position hardly changes.
std::vector<double> Jumps(const Detections& d, const std::vector<double>& time_s, double skin) {
  const double interval_s = MedianInterval(time_s);
  const std::size_t n = time_s.size();
  std::vector<double> jumps(n, skin);
  for (std::size_t i = 0, begin = 0, end = 0; i < n; ++i) {
    while (begin < i && (!d.seen[begin] || time_s[begin] < time_s[i] - kMovement_s)) ++begin;
    while (end + 1 < n && time_s[end + 1] <= time_s[i] + kMovement_s) ++end;
    std::size_t last = end;
    while (last > begin && !d.seen[last]) --last;
    if (last == begin || !d.seen[begin]) continue;
    const Eigen::Vector2d moved = d.track->samples[last].position - d.track->samples[begin].position;
    jumps[i] += moved.norm() / std::max(time_s[last] - time_s[begin], kMovement_s) * interval_s;
  }
  return jumps;
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
  return (12 + d.jump[frame] / d.sigma[frame]) * d.plane_sigma[frame];
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

}  // namespace

Detections CollectDetections(const motion::MarkerRecording& recording, const motion::MarkerTrack& track,
                             const LegView& view, double skin) {
  const std::size_t n = recording.Frames();
  Detections d;
  d.name = track.name;
  d.track = &track;
  d.depth_mm = view.Depth(track.name);
  d.seen.resize(n);
  d.sigma.resize(n);
  d.in_plane.resize(n);
  d.plane_sigma.resize(n);
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
    d.has_sigmas = d.has_sigmas && track.samples[i].sigma > 0;
    d.plane_sigma[i] = d.sigma[i] * PlaneUnitsPerRecorded(view, d.in_plane[i], d.depth_mm);
  }
  d.trusted = d.seen;
  d.jump = Jumps(d, recording.time_s, skin);
  MistrustExcursions(d, recording.time_s);
  return d;
}

std::size_t FramesTogether(const Detections& lower, const Detections& upper) {
  std::size_t frames = 0;
  for (std::size_t i = 0; i < lower.trusted.size() && i < upper.trusted.size(); ++i)
    frames += lower.trusted[i] && upper.trusted[i];
  return frames;
}

void MistrustIsolated(Detections& d, const std::vector<double>& time_s) {
  const Steps steps = FindSteps(d, time_s);
  const std::vector<std::size_t>& frames = steps.frames;
  std::vector<std::size_t> begins;  // of the pieces: after a gap, or a jump
  for (std::size_t k = 1; k < frames.size(); ++k)
    if (frames[k] > frames[k - 1] + 1 || IsJump(d, steps, k)) begins.push_back(k);
  std::vector<std::size_t> isolated;
  for (std::size_t p = 0; p + 1 < begins.size(); ++p) {
    const std::size_t begin = begins[p], end = begins[p + 1];
    const double seen_s = time_s[frames[end - 1]] - time_s[frames[begin]] + steps.interval_s;
    const double hidden_s = time_s[frames[end]] - time_s[frames[begin - 1]] - steps.interval_s - seen_s;
    if (end - begin < kLeastFrames && hidden_s > std::max(seen_s, kMemory_s))
      for (std::size_t k = begin; k < end; ++k) isolated.push_back(frames[k]);
  }
  if (2 * isolated.size() > frames.size()) return;
  for (const std::size_t i : isolated) d.trusted[i] = 0;
}

void CheckIsSeen(const std::array<Detections, kLegMarkers>& leg) {
  for (const LegSegmentIndex segment : {kShank, kThigh}) {
    const Detections &lower = leg[motion::kSegments[segment].lower], &upper = leg[motion::kSegments[segment].upper];
    const std::size_t frames = FramesTogether(lower, upper);
    if (frames < kLeastFrames)
      throw Fail("leg fit: '{}' and '{}' are seen together in {} frames only; at least {} are needed", lower.name,
                 upper.name, frames, kLeastFrames);
  }
}

}  // namespace lake::gait
