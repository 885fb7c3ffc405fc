#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "lake/axis/functional_axis.h"
#include "lake/core/counted.h"
#include "lake/core/error.h"

namespace lake::axis {
namespace {

using dynamics::TurnNormal;
using Eigen::Matrix3d, Eigen::Matrix3Xd, Eigen::Vector3d;

std::vector<const exchange::PointTrack*> TracksOf(const exchange::PointRecording& points,
                                                  const std::vector<std::string>& names, const char* segment,
                                                  std::size_t least) {
  if (names.size() < least)
    throw UsageError("--segment {}: {}, needs at least {}", segment, Counted(names.size(), "marker"), least);
  std::vector<const exchange::PointTrack*> tracks;
  for (const std::string& name : names) {
    tracks.push_back(points.Find(name));
    if (!tracks.back()) {
      std::vector<std::string> there;
      for (const exchange::PointTrack& point : points.points) there.push_back(point.name);
      throw Fail("--segment {}: the file has no marker '{}'; it has {}", segment, name, fmt::join(there, ", "));
    }
    if (std::count(names.begin(), names.end(), name) > 1)
      throw UsageError("--segment {}: '{}' is named twice", segment, name);
  }
  return tracks;
}

// The leg's markers by the segment that carries them, where lake's own names say so; the knee's is on either.
void CheckIsOnSegment(const std::vector<std::string>& names, std::string_view segment) {
  constexpr std::pair<const char*, const char*> kPlaces[] = {{"ankle", "shank"}, {"heel", "foot"},
                                                             {"toe", "foot"},    {"hip", "thigh"},
                                                             {"waist", "trunk"}, {"shoulder", "trunk"}};
  for (const auto& [name, place] : kPlaces)
    if (place != segment && std::ranges::find(names, name) != names.end())
      throw UsageError("--segment {}: the marker '{}' is on the {}; name markers of the {}", segment, name, place,
                       segment);
}

// Planar points of a file of three dimensions have turns about this one axis only: their mirror image is a turn in
// space as well.
TurnNormal NormalOf(const exchange::PointRecording& points, const std::vector<const exchange::PointTrack*>& tracks) {
  constexpr double kFlat_mm = 0.01;  // root mean square; files are rounded
  if (points.space == exchange::PointSpace::kPlane) return Vector3d::UnitZ();
  Vector3d sum = Vector3d::Zero();
  Matrix3d squares = Matrix3d::Zero();
  double count = 0;
  for (const exchange::PointTrack* track : tracks)
    for (const Vector3d& place : track->positions) {
      if (!place.allFinite()) continue;
      sum += place;
      squares += place * place.transpose();
      ++count;
    }
  if (count == 0) return std::nullopt;
  const Vector3d mean = sum / count;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(squares / count - mean * mean.transpose());
  return eigen.eigenvalues()[0] < kFlat_mm * kFlat_mm ? TurnNormal(eigen.eigenvectors().col(0)) : std::nullopt;
}

Segment SegmentOf(const std::vector<const exchange::PointTrack*>& tracks, const char* name, const TurnNormal& normal) {
  std::vector<Matrix3Xd> places(tracks.front()->positions.size(), Matrix3Xd(3, tracks.size()));
  for (std::size_t frame = 0; frame < places.size(); ++frame)
    for (std::size_t m = 0; m < tracks.size(); ++m)
      places[frame].col(static_cast<Eigen::Index>(m)) = tracks[m]->positions[frame];
  auto segment = dynamics::FitRigidSegment(places, normal);
  if (!segment) throw Fail("no frame has all markers of the {}: leave out those that are seldom seen", name);
  return *std::move(segment);
}

}  // namespace

SegmentMotion MotionOf(const exchange::PointRecording& points, const SegmentMarkers& markers) {
  if (points.space == exchange::PointSpace::kImage)
    throw Fail("the markers are in pixels: give a trial in mm (calibrate the camera, or export it with a scale)");
  const std::size_t least = points.space == exchange::PointSpace::kPlane ? 2 : 3;
  CheckIsOnSegment(markers.shank, "shank");
  CheckIsOnSegment(markers.thigh, "thigh");
  const auto shank = TracksOf(points, markers.shank, "shank", least);
  const auto thigh = TracksOf(points, markers.thigh, "thigh", least);
  for (const std::string& name : markers.shank)
    if (std::count(markers.thigh.begin(), markers.thigh.end(), name))
      throw UsageError("--segment: '{}' is on the shank and on the thigh", name);
  std::vector<const exchange::PointTrack*> both = shank;
  both.insert(both.end(), thigh.begin(), thigh.end());
  const TurnNormal normal = NormalOf(points, both);
  return {SegmentOf(shank, "shank", normal), SegmentOf(thigh, "thigh", normal)};
}

}  // namespace lake::axis
