#include "path_join.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "leg_scale.h"

namespace lake::tracking {
namespace {

constexpr double kError_mm = 0.4;  // of a position, by coding
constexpr double kClock = 0.2;     // of a time, in frames: a converted rate shows pictures too early or too late

// All where there are no others: those of repeated pictures too.
template <typename Iterator>
PathEnd EndOf(Iterator from_the_end, Iterator to, bool repeated_too = false) {
  PathEnd end;
  for (Iterator sample = from_the_end; sample != to && end.size() < kPathEndSamples; ++sample)
    if (!sample->repeated || repeated_too) end.push_back({.time_s = sample->time_s, .position = sample->position});
  if (end.empty() && !repeated_too) return EndOf(from_the_end, to, true);
  std::ranges::reverse(end);
  return end;
}

// In radii, the only measure of length in the picture, with errors that include the clock's.
dynamics::PathState StateAt(PathEnd end, double radius_px, const MarkerPhysics& physics, double density) {
  double step = 0;
  for (std::size_t i = 0; i < end.size(); ++i) {
    if (i + 1 < end.size()) step = (end[i + 1].position - end[i].position).norm() / radius_px;
    end[i].position /= radius_px;
    end[i].sigma = std::hypot(kError_mm / physics.radius_mm, kClock * step);
  }
  return dynamics::EvidenceAt(end, end.back().time_s, density, dynamics::PersonPrior(physics.radius_mm)).state;
}

double LogUnrelated(const MarkerPhysics& physics) {
  const dynamics::MotionPrior prior = dynamics::PersonPrior(physics.radius_mm);
  return -2 * std::log(kReach_mm / physics.radius_mm * prior.speed * prior.acceleration) -
         2 * std::log(2 * std::numbers::pi);
}

}  // namespace

PathEnd FirstSamples(const Tracklet& tracklet) {
  return EndOf(tracklet.samples.begin(), tracklet.samples.end());
}

PathEnd LastSamples(const Tracklet& tracklet) {
  return EndOf(tracklet.samples.rbegin(), tracklet.samples.rend());
}

double GapBetween(const PathEnd& before, const PathEnd& after) {
  return after.back().time_s - before.back().time_s;
}

PathJoin JoinPaths(const PathEnd& before, const PathEnd& after, double gap_s, double radius_px,
                   const MarkerPhysics& physics) {
  const double density = physics.quick_mm2_s5 / (physics.radius_mm * physics.radius_mm),
               elapsed_s = std::min(gap_s, physics.turns_after_s);
  const dynamics::PathState last = StateAt(before, radius_px, physics, density),
                            first = StateAt(after, radius_px, physics, density),
                            predicted = dynamics::Moved(last, elapsed_s, density);
  const Eigen::Matrix<double, 3, 2> apart = first.mean - predicted.mean;
  const Eigen::LLT<Eigen::Matrix3d> covariance(predicted.covariance + first.covariance);
  return {covariance.matrixL().solve(apart).squaredNorm(),
          dynamics::LogJoin(last, first, elapsed_s, density) - LogUnrelated(physics)};
}

}  // namespace lake::tracking
