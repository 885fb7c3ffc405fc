#include "lake/gait/sts_crossings.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lake/core/statistics.h"

namespace lake::gait {
namespace {

// Derivative per s of the polynomial through up to five samples around a frame; NaN if one of them is not known.
double SlopeAt(const std::vector<double>& time_s, const std::vector<double>& values, std::size_t frame) {
  const std::size_t first = frame < 2 ? 0 : frame - 2, last = std::min(frame + 2, time_s.size() - 1);
  double slope = 0;
  for (std::size_t j = first; j <= last; ++j) {
    double weight = j == frame ? 0 : 1 / (time_s[j] - time_s[frame]);
    for (std::size_t m = first; m <= last; ++m) {
      if (m == j || m == frame) continue;
      if (j == frame)
        weight += 1 / (time_s[frame] - time_s[m]);
      else
        weight *= (time_s[frame] - time_s[m]) / (time_s[j] - time_s[m]);
    }
    slope += weight * values[j];
  }
  return slope;
}

// Where `excess` passes from at most 0 to above 0 in the step that ends at frame i.
std::optional<double> Crossing(const std::vector<double>& time_s, std::size_t i, double before, double after) {
  if (!(before <= 0 && after > 0)) return std::nullopt;
  return time_s[i - 1] + (time_s[i] - time_s[i - 1]) * before / (before - after);
}

double MiddleOfStep(const std::vector<double>& time_s, std::size_t i) {
  return 0.5 * (time_s[i - 1] + time_s[i]);
}

std::vector<double> KnownOf(const std::vector<double>& values, std::size_t begin, std::size_t end) {
  std::vector<double> known;
  for (std::size_t i = begin; i < end; ++i)
    if (std::isfinite(values[i])) known.push_back(values[i]);
  return known;
}

}  // namespace

StsCrossings::StsCrossings(const motion::LegMotion& motion, const StsOptions& limits)
    : motion_(motion), limits_(limits) {
  std::vector<double> trunk_deg;
  for (const motion::LegSample& sample : motion.samples) {
    trunk_deg.push_back(sample.trunk_deg);
    hip_height_.push_back((sample.ak + sample.kh).y());
  }
  for (std::size_t i = 0; i < trunk_deg.size(); ++i) trunk_deg_s_.push_back(SlopeAt(motion.time_s, trunk_deg, i));
}

double StsCrossings::OnsetSeconds(std::size_t frame) const {
  const std::vector<double>& time_s = motion_.time_s;
  if (frame == 0) return time_s[0];
  constexpr double kRest_s = 0.5;
  const auto rest = static_cast<std::size_t>(std::lower_bound(time_s.begin(), time_s.end(), time_s[frame] - kRest_s) -
                                             time_s.begin());
  std::optional<double> onset;
  const auto consider = [&](const std::vector<double>& signal, double least) {
    const std::vector<double> quiet = KnownOf(signal, rest, frame);
    const double middle = Median(quiet), limit = std::max(limits_.onset_deviations * RobustDeviation(quiet), least);
    const auto excess = [&](std::size_t i) { return std::abs(signal[i] - middle) - limit; };
    if (const auto time = Crossing(time_s, frame, excess(frame - 1), excess(frame)))
      onset = std::min(onset.value_or(*time), *time);
  };
  consider(hip_height_, limits_.onset_height_mm);
  consider(trunk_deg_s_, limits_.onset_trunk_deg_s);
  return onset.value_or(MiddleOfStep(time_s, frame));
}

double StsCrossings::StandingSeconds(std::size_t onset, std::size_t frame) const {
  if (frame == 0) return motion_.time_s[0];
  double peak = 0;
  for (std::size_t i = onset; i <= frame; ++i) peak = std::min(peak, motion_.samples[i].knee_deg_s);
  const auto excess = [&](std::size_t i) { return motion_.samples[i].knee_deg_s - limits_.standing_fraction * peak; };
  return Crossing(motion_.time_s, frame, excess(frame - 1), excess(frame))
      .value_or(MiddleOfStep(motion_.time_s, frame));
}

}  // namespace lake::gait
