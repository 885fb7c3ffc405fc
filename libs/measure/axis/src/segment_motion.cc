#include <fmt/ranges.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "lake/axis/functional_axis.h"
#include "lake/core/error.h"

namespace lake::axis {
namespace {

using Eigen::Matrix3d, Eigen::Matrix3Xd, Eigen::Vector3d;

std::vector<const exchange::PointTrack*> TracksOf(const exchange::PointRecording& points,
                                                  const std::vector<std::string>& names, const char* segment,
                                                  std::size_t least) {
  if (names.size() < least)
    throw UsageError("--segment {}: {} marker{}, needs at least {}", segment, names.size(),
                     names.size() == 1 ? "" : "s", least);
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

// Of the plane in which all markers of both segments are, throughout.
using Normal = std::optional<Vector3d>;

// Planar points of a file of three dimensions have turns about this one axis only: their mirror image is a turn in
// space as well.
Normal NormalOf(const exchange::PointRecording& points, const std::vector<const exchange::PointTrack*>& tracks) {
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
  return eigen.eigenvalues()[0] < kFlat_mm * kFlat_mm ? Normal(eigen.eigenvectors().col(0)) : std::nullopt;
}

// The least-squares turn that takes `from` to `to`, both about their means (Kabsch); in a plane about its normal.
Matrix3d TurnBetween(const Matrix3Xd& from, const Matrix3Xd& to, const Normal& normal) {
  const Matrix3d moment = to * from.transpose();
  if (normal) {
    const Vector3d turned(moment(2, 1) - moment(1, 2), moment(0, 2) - moment(2, 0), moment(1, 0) - moment(0, 1));
    const double angle = std::atan2(normal->dot(turned), moment.trace());
    return Eigen::AngleAxisd(angle, *normal).toRotationMatrix();
  }
  const Eigen::JacobiSVD<Matrix3d> svd(moment, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3d sign = Vector3d::Ones();
  sign.z() = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
}

// Poses the shape where so many of its markers are seen at the frame, and appends the frame's deformation.
void AddFrame(const std::vector<const exchange::PointTrack*>& tracks, std::size_t frame, const Normal& normal,
              std::size_t least, Segment& segment) {
  segment.poses.emplace_back();
  segment.deformation.emplace_back(Matrix3Xd::Zero(3, segment.shape.cols()));
  std::vector<Eigen::Index> seen;
  for (std::size_t m = 0; m < tracks.size(); ++m)
    if (tracks[m]->positions[frame].allFinite()) seen.push_back(static_cast<Eigen::Index>(m));
  if (seen.size() < least) return;
  Matrix3Xd from = segment.shape(Eigen::all, seen), to(3, seen.size());
  for (std::size_t k = 0; k < seen.size(); ++k)
    to.col(static_cast<Eigen::Index>(k)) = tracks[static_cast<std::size_t>(seen[k])]->positions[frame];
  const Vector3d from_mean = from.rowwise().mean(), to_mean = to.rowwise().mean();
  from.colwise() -= from_mean;
  to.colwise() -= to_mean;
  Pose& pose = segment.poses.back();
  pose.turn = TurnBetween(from, to, normal);
  pose.origin = to_mean - pose.turn * from_mean;
  segment.deformation.back()(Eigen::all, seen) = pose.turn.transpose() * to - from;
}

// The mean shape is the mean of the complete frames laid onto each other, turned as the first (Procrustes).
Segment SegmentOf(const std::vector<const exchange::PointTrack*>& tracks, const char* name, const Normal& normal,
                  std::size_t least) {
  constexpr int kRounds = 5;  // the mean shape stands still after two or three
  const std::size_t frames = tracks.front()->positions.size();
  std::vector<Matrix3Xd> complete;  // about their means
  for (std::size_t frame = 0; frame < frames; ++frame) {
    Matrix3Xd now(3, tracks.size());
    for (std::size_t m = 0; m < tracks.size(); ++m) now.col(static_cast<Eigen::Index>(m)) = tracks[m]->positions[frame];
    if (!now.allFinite()) continue;
    now.colwise() -= Vector3d(now.rowwise().mean());
    complete.push_back(now);
  }
  if (complete.empty()) throw Fail("no frame has all markers of the {}: leave out those that are seldom seen", name);
  Segment segment;
  segment.shape = complete.front();
  for (int round = 0; round < kRounds; ++round) {
    Matrix3Xd sum = Matrix3Xd::Zero(3, segment.shape.cols());
    for (const Matrix3Xd& now : complete) sum += TurnBetween(now, segment.shape, normal) * now;
    segment.shape = sum / static_cast<double>(complete.size());
  }
  for (std::size_t frame = 0; frame < frames; ++frame) AddFrame(tracks, frame, normal, least, segment);
  const double markers = static_cast<double>(tracks.size());
  segment.freedom = normal ? 2 * markers - 3 : 3 * markers - 6;
  double square = 0;
  for (const Matrix3Xd& deformation : segment.deformation) square += deformation.squaredNorm();
  const auto seen = std::ranges::count_if(segment.poses, &Pose::IsSeen);
  segment.marker_sd_mm = std::sqrt(square / (static_cast<double>(seen) * segment.freedom));
  return segment;
}

}  // namespace

double Segment::PointSdMm(double distance_mm) const {
  return marker_sd_mm * std::hypot(1 / std::sqrt(static_cast<double>(shape.cols())), distance_mm / shape.norm());
}

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
  const Normal normal = NormalOf(points, both);
  return {SegmentOf(shank, "shank", normal, least), SegmentOf(thigh, "thigh", normal, least)};
}

}  // namespace lake::axis
