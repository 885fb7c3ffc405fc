// Onset and standing between frames. The events are found frame by frame (lake/gait/sts_events.h); at 30 frames/s half
// a frame is 1 % of a sit-to-stand, and at full speed 3 mm of the knee's path, so the crossing itself is interpolated
// here.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "lake/compare/registration.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "sampling.h"

namespace lake {
namespace {

// The limits of lake/gait/sts_events.h.
constexpr double kOnsetDeviations = 3, kOnsetHeightMm = 2, kOnsetTrunkDegPerS = 2, kStandingFraction = 0.05;

// Where `excess` passes from at most 0 to above 0 in the step that ends at frame i.
std::optional<double> Crossing(const std::vector<double>& time_s, std::size_t i, double before, double after) {
  if (!(before <= 0 && after > 0)) return std::nullopt;
  return time_s[i - 1] + (time_s[i] - time_s[i - 1]) * before / (before - after);
}

// An event that no crossing places is somewhere in the step before its frame.
double MiddleOfStep(const std::vector<double>& time_s, std::size_t i) {
  return 0.5 * (time_s[i - 1] + time_s[i]);
}

std::vector<double> Section(const std::vector<double>& values, std::size_t begin, std::size_t end) {
  std::vector<double> section;
  for (std::size_t i = begin; i < end; ++i)
    if (std::isfinite(values[i])) section.push_back(values[i]);
  return section;
}

class IntervalFinder {
 public:
  explicit IntervalFinder(const LegMotion& motion) : motion_(motion) {
    std::vector<double> trunk_deg;
    for (const LegSample& sample : motion.samples) {
      trunk_deg.push_back(sample.trunk_deg);
      hip_height_.push_back((sample.ak + sample.kh).y());
    }
    for (std::size_t i = 0; i < trunk_deg.size(); ++i) trunk_deg_s_.push_back(SlopeAt(motion.time_s, trunk_deg, i));
  }

  double Onset(std::size_t i) const {
    if (i == 0) return motion_.time_s[0];
    constexpr double kRestS = 0.5;
    const std::size_t rest = FrameAfter(motion_.time_s, motion_.time_s[i] - kRestS);
    std::optional<double> onset;
    const auto consider = [&](const std::vector<double>& signal, double least) {
      const std::vector<double> quiet = Section(signal, rest, i);
      const double middle = Median(quiet), limit = std::max(kOnsetDeviations * RobustDeviation(quiet), least);
      const auto excess = [&](std::size_t frame) { return std::abs(signal[frame] - middle) - limit; };
      if (const auto time = Crossing(motion_.time_s, i, excess(i - 1), excess(i)))
        onset = std::min(onset.value_or(*time), *time);
    };
    consider(hip_height_, kOnsetHeightMm);
    consider(trunk_deg_s_, kOnsetTrunkDegPerS);
    return onset.value_or(MiddleOfStep(motion_.time_s, i));
  }

  double Standing(std::size_t onset, std::size_t i) const {
    if (i == 0) return motion_.time_s[0];
    double peak = 0;
    for (std::size_t j = onset; j <= i; ++j) peak = std::min(peak, motion_.samples[j].knee_deg_s);
    const auto excess = [&](std::size_t frame) { return motion_.samples[frame].knee_deg_s - kStandingFraction * peak; };
    return Crossing(motion_.time_s, i, excess(i - 1), excess(i)).value_or(MiddleOfStep(motion_.time_s, i));
  }

 private:
  const LegMotion& motion_;
  std::vector<double> hip_height_, trunk_deg_s_;
};

}  // namespace

std::vector<StsInterval> FindStsIntervals(const TrialTables& trial) {
  const std::vector<double>& time_s = trial.motion.time_s;
  std::map<int, std::map<StsEventKind, double>> repetitions;
  for (const StsEvent& event : trial.events) repetitions[event.repetition][event.kind] = event.time_s;
  if (time_s.empty() || repetitions.empty())
    throw Fail("{}: no sit-to-stand found in it (the hip must rise while the knee extends by 30° or more)", trial.name);
  const IntervalFinder finder(trial.motion);
  std::vector<StsInterval> intervals;
  for (const auto& [repetition, events] : repetitions) {
    if (!events.contains(StsEventKind::kOnset) || !events.contains(StsEventKind::kStanding)) continue;
    const double onset_s = events.at(StsEventKind::kOnset), standing_s = events.at(StsEventKind::kStanding);
    if (standing_s > time_s.back() || onset_s < time_s.front())
      throw Fail(
          "{}: repetition {} lasts from {:.3f} to {:.3f} s, but the recording from {:.3f} to {:.3f} s: it is shorter "
          "than the motion",
          trial.name, repetition, onset_s, standing_s, time_s.front(), time_s.back());
    const std::size_t first = FrameAfter(time_s, onset_s), last = FrameAfter(time_s, standing_s);
    if (last < first + 3) throw Fail("{}: repetition {} has only {} frames", trial.name, repetition, last - first + 1);
    intervals.push_back({repetition, finder.Onset(first), finder.Standing(first, last)});
  }
  if (intervals.empty())
    throw Fail(
        "{}: the recording is shorter than the motion: it ends at {:.3f} s, before the first sit-to-stand reaches "
        "standing",
        trial.name, time_s.back());
  return intervals;
}

}  // namespace lake
