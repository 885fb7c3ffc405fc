#include "lake/loads/leg_path.h"

#include <cmath>

#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "lake/dynamics/path_smoother.h"

namespace lake::loads {
namespace {

const motion::MarkerTrack& FindMarker(const motion::MarkerRecording& recording, const std::string& name) {
  if (const motion::MarkerTrack* track = recording.Find(name)) return *track;
  throw Fail("loads: no marker '{}' in the trial; name the markers with --map", name);
}

// Fills one point of every frame from the path's smoother with a given cutoff.
void SmoothPoint(const motion::MarkerTrack& track, const LegPathOptions& options, int joint, LegPath& path) {
  constexpr double kSigma_m = 1e-3;  // all alike: with a given cutoff only their ratios matter
  const std::size_t n = path.time_s.size();
  const double frame_s = (path.time_s.back() - path.time_s.front()) / static_cast<double>(n - 1);
  dynamics::SeenPath seen = dynamics::UnseenPath(2, path.time_s);
  for (std::size_t i = 0; i < n; ++i)
    if (track.samples[i].IsKnown())
      seen.See(i, gait::LegFromPlane(track.samples[i].position, options.facing, options.up) / kMmPerM, kSigma_m);
  const dynamics::PathModel model{std::vector(n, dynamics::DensityOfCutoff(options.cutoff_hz, kSigma_m, frame_s))};
  const dynamics::SmoothedPath smooth = dynamics::SmoothPath(seen, model, dynamics::PersonPrior(kMmPerM));
  for (std::size_t i = 0; i < n; ++i) {
    PointMotion& point = path.frames[i][static_cast<std::size_t>(joint)];
    point.position_m = smooth.point[i].position.head<2>();
    point.velocity_m_s = smooth.point[i].velocity.head<2>();
    point.acceleration_m_s2 = smooth.point[i].acceleration.head<2>();
  }
  std::vector<double> sigmas_mm;
  for (std::size_t i = 0; i < n; ++i) {
    path.known[i] = path.known[i] && track.samples[i].IsKnown();
    if (track.samples[i].IsKnown()) sigmas_mm.push_back(track.samples[i].sigma);
  }
  path.sigma_m[static_cast<std::size_t>(joint)] = Median(sigmas_mm) / kMmPerM;
}

}  // namespace

LegPath MakeLegPath(const motion::MarkerRecording& trajectory, const LegPathOptions& options) {
  if (trajectory.unit != motion::LengthUnit::kMm)
    throw Fail("loads: the trial has no scale: lengths are in px; give --scale, or a --camera with the sagittal plane");
  LegPath path;
  path.time_s = trajectory.time_s;
  path.frames.resize(trajectory.Frames());
  path.known.assign(trajectory.Frames(), 1);
  path.has_shoulder = trajectory.Find(options.shoulder) != nullptr;
  path.names = {options.markers.ankle, options.markers.knee, options.markers.hip,
                path.has_shoulder ? options.shoulder : options.markers.waist};
  for (int joint = 0; joint < kJoints; ++joint)
    SmoothPoint(FindMarker(trajectory, path.names[static_cast<std::size_t>(joint)]), options, joint, path);
  return path;
}

SegmentMotion SegmentBetween(const PointMotion& lower, const PointMotion& upper) {
  const Eigen::Vector2d d = upper.position_m - lower.position_m, d1 = upper.velocity_m_s - lower.velocity_m_s,
                        d2 = upper.acceleration_m_s2 - lower.acceleration_m_s2;
  SegmentMotion segment;
  segment.length_m = d.norm();
  segment.along = d / segment.length_m;
  segment.across = {segment.along.y(), -segment.along.x()};
  segment.tilt_rad = std::atan2(d.x(), d.y());
  segment.length_rate_m_s = d1.dot(segment.along);
  segment.tilt_rate_rad_s = d1.dot(segment.across) / segment.length_m;
  segment.tilt_acceleration_rad_s2 =
      (d2.dot(segment.across) - 2 * segment.length_rate_m_s * segment.tilt_rate_rad_s) / segment.length_m;
  return segment;
}

}  // namespace lake::loads
