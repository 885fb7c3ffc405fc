#include "lake/gait/trunk_on_pelvis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"

namespace lake::gait {
namespace {

using motion::MarkerSample;

// In the leg frame's axes: from the pelvis' back to its front, and what both are uncertain by on each axis.
struct PelvisLine {
  Eigen::Vector2d forward;
  double sd = kNaN;
};

PelvisLine LineOf(const LegFitResult& fit, const MarkerSample& asis, const MarkerSample& psis) {
  return {.forward = LegFromPlane(asis.position - psis.position, fit.motion.facing, fit.up),
          .sd = std::hypot(asis.sigma, psis.sigma)};
}

// Why no lean can be told of these markers; empty if one can. `lines` are those of the frames that show both, `waist`
// how far the waist marker is from the middle between them there.
std::string WhyUnknown(const std::vector<PelvisLine>& lines, const std::vector<double>& waist) {
  if (lines.empty()) return fmt::format("the markers '{}' and '{}' are never seen together", kAsis, kPsis);
  const auto backward = std::ranges::count_if(lines, [](const PelvisLine& line) { return line.forward.x() < 0; });
  if (2 * backward > std::ssize(lines))
    return fmt::format("the marker '{}' is behind '{}': exchange their names, or say where the subject faces", kAsis,
                       kPsis);
  std::vector<double> lengths;
  lengths.reserve(lines.size());
  for (const PelvisLine& line : lines) lengths.push_back(line.forward.norm());
  if (!waist.empty() && Median(waist) < Median(lengths))
    return fmt::format(
        "the waist marker is on the pelvis itself, no farther from '{}' and '{}' than they are apart: give one on the "
        "trunk above, as on the shoulder",
        kAsis, kPsis);
  return "";
}

}  // namespace

TrunkOnPelvis FindTrunkOnPelvis(const LegFitResult& fit) {
  const std::size_t frames = fit.motion.samples.size();
  TrunkOnPelvis lean{std::vector<double>(frames, kNaN), std::vector<double>(frames, kNaN), ""};
  const motion::MarkerTrack *asis = fit.trajectory.Find(kAsis), *psis = fit.trajectory.Find(kPsis);
  const motion::MarkerTrack* waist = fit.trajectory.Find(fit.leg_markers.waist);
  if (!asis && !psis) return lean;
  if (!asis || !psis) {
    lean.warning = fmt::format("no lean to the pelvis: there is a marker '{}' and none called '{}'",
                               asis ? kAsis : kPsis, asis ? kPsis : kAsis);
    return lean;
  }
  std::vector<PelvisLine> lines;
  std::vector<double> from_waist;
  for (std::size_t i = 0; i < frames; ++i) {
    const MarkerSample &front = asis->samples[i], &back = psis->samples[i];
    if (!front.IsKnown() || !back.IsKnown()) continue;
    const PelvisLine& line = lines.emplace_back(LineOf(fit, front, back));
    if (waist && waist->samples[i].IsKnown())
      from_waist.push_back((waist->samples[i].position - (front.position + back.position) / 2).norm());
    const double tilt_deg = DegreesFromRadians(std::atan2(-line.forward.y(), line.forward.x())),
                 tilt_sd_deg = DegreesFromRadians(line.sd / line.forward.norm());
    lean.deg[i] = fit.motion.samples[i].trunk_deg - tilt_deg;
    lean.sd_deg[i] = std::hypot(fit.signals.sd.trunk_deg.empty() ? kNaN : fit.signals.sd.trunk_deg[i], tilt_sd_deg);
  }
  if (const std::string why = WhyUnknown(lines, from_waist); !why.empty()) {
    std::ranges::fill(lean.deg, kNaN);
    std::ranges::fill(lean.sd_deg, kNaN);
    lean.warning = "no lean to the pelvis: " + why;
  }
  return lean;
}

}  // namespace lake::gait
