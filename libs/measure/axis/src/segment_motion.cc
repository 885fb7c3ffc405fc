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

using Eigen::Matrix3d, Eigen::Matrix3Xd, Eigen::MatrixXd, Eigen::Vector3d;

constexpr Eigen::Index kMostModes = 2;    // of a segment: soft tissue moves in few ways
constexpr double kLeastModeShare = 0.01;  // of the deformation's variance

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

std::optional<Pose> PoseOf(const Matrix3Xd& shape, const std::vector<const exchange::PointTrack*>& tracks,
                           std::size_t frame, const Normal& normal, std::size_t least) {
  std::vector<Eigen::Index> seen;
  for (std::size_t m = 0; m < tracks.size(); ++m)
    if (tracks[m]->positions[frame].allFinite()) seen.push_back(static_cast<Eigen::Index>(m));
  if (seen.size() < least) return std::nullopt;
  Matrix3Xd from = shape(Eigen::all, seen), to(3, seen.size());
  for (std::size_t k = 0; k < seen.size(); ++k)
    to.col(static_cast<Eigen::Index>(k)) = tracks[static_cast<std::size_t>(seen[k])]->positions[frame];
  const Vector3d from_mean = from.rowwise().mean(), to_mean = to.rowwise().mean();
  from.colwise() -= from_mean;
  to.colwise() -= to_mean;
  Pose pose;
  pose.turn = TurnBetween(from, to, normal);
  pose.origin = to_mean - pose.turn * from_mean;
  return pose;
}

// Values at the rows of `known`, which rise, by lines between them.
MatrixXd Bridged(const MatrixXd& values, const std::vector<Eigen::Index>& known, Eigen::Index rows) {
  MatrixXd all(rows, values.cols());
  std::size_t after = 0;
  for (Eigen::Index row = 0; row < rows; ++row) {
    while (after + 1 < known.size() && known[after] < row) ++after;
    const std::size_t before = known[after] > row && after > 0 ? after - 1 : after;
    const double width = static_cast<double>(known[after] - known[before]);
    const double share = width > 0 ? static_cast<double>(row - known[before]) / width : 0;
    all.row(row) = (1 - share) * values.row(static_cast<Eigen::Index>(before)) +
                   share * values.row(static_cast<Eigen::Index>(after));
  }
  return all;
}

// From the frames with all markers, of which there is one at least.
Deformation DeformationOf(const Matrix3Xd& shape, const std::vector<const exchange::PointTrack*>& tracks,
                          const std::vector<Pose>& poses, const Normal& normal) {
  std::vector<Eigen::Index> complete;
  MatrixXd strays(poses.size(), shape.size());
  for (std::size_t frame = 0; frame < poses.size(); ++frame) {
    Matrix3Xd stray(3, shape.cols());
    for (Eigen::Index m = 0; m < shape.cols(); ++m)
      stray.col(m) = poses[frame].turn.transpose() *
                         (tracks[static_cast<std::size_t>(m)]->positions[frame] - poses[frame].origin) -
                     shape.col(m);
    if (!stray.allFinite()) continue;
    strays.row(static_cast<Eigen::Index>(complete.size())) = stray.reshaped().transpose();
    complete.push_back(static_cast<Eigen::Index>(frame));
  }
  strays.conservativeResize(static_cast<Eigen::Index>(complete.size()), Eigen::NoChange);
  strays.rowwise() -= Eigen::RowVectorXd(strays.colwise().mean());
  const double markers = static_cast<double>(shape.cols()), frames = static_cast<double>(complete.size());
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(strays.transpose() * strays);
  Eigen::Index modes = 0;
  const Eigen::Index last = eigen.eigenvalues().size() - 1;
  while (modes < kMostModes && eigen.eigenvalues()[last - modes] > kLeastModeShare * strays.squaredNorm()) ++modes;
  const MatrixXd scores = strays * eigen.eigenvectors().rightCols(modes) / std::sqrt(markers);
  Deformation deformation;
  deformation.modes = Bridged(scores, complete, static_cast<Eigen::Index>(poses.size()));
  const double freedom = normal ? 2 * markers - 3 : 3 * markers - 6;  // coordinates that a pose does not take
  deformation.marker_sd_mm = std::sqrt(strays.squaredNorm() / (frames * freedom));
  deformation.radius_mm = shape.norm() / std::sqrt(markers);
  deformation.pose_sd_mm = deformation.marker_sd_mm / std::sqrt(markers);
  deformation.pose_sd_rad = deformation.pose_sd_mm / deformation.radius_mm;
  return deformation;
}

// The shape is the mean of the frames laid onto each other, turned as the first complete frame (Procrustes).
Segment SegmentOf(const std::vector<const exchange::PointTrack*>& tracks, const char* name, const Normal& normal,
                  std::size_t least) {
  constexpr int kRounds = 5;  // the mean shape stands still after two or three
  const std::size_t frames = tracks.front()->positions.size();
  const auto complete = [&](std::size_t frame) {
    return std::all_of(tracks.begin(), tracks.end(), [&](const auto* t) { return t->positions[frame].allFinite(); });
  };
  Matrix3Xd shape(3, tracks.size());
  bool has_shape = false;
  for (int round = 0; round < kRounds; ++round) {
    Matrix3Xd sum = Matrix3Xd::Zero(3, shape.cols());
    for (std::size_t frame = 0; frame < frames; ++frame) {
      if (!complete(frame)) continue;
      Matrix3Xd now(3, tracks.size());
      for (std::size_t m = 0; m < tracks.size(); ++m)
        now.col(static_cast<Eigen::Index>(m)) = tracks[m]->positions[frame];
      now.colwise() -= Vector3d(now.rowwise().mean());
      if (!has_shape) shape = now;
      has_shape = true;
      sum += TurnBetween(now, shape, normal) * now;
    }
    if (!has_shape) throw Fail("no frame has all markers of the {}: leave out those that are seldom seen", name);
    Matrix3Xd mean = sum;
    mean.colwise() -= Vector3d(mean.rowwise().mean());
    shape = mean * (shape.norm() / mean.norm());
  }
  Segment segment{std::vector<Pose>(frames), shape.col(0), {}};
  for (std::size_t frame = 0; frame < frames; ++frame)
    segment.poses[frame] = PoseOf(shape, tracks, frame, normal, least).value_or(Pose());
  segment.deformation = DeformationOf(shape, tracks, segment.poses, normal);
  return segment;
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
  const Normal normal = NormalOf(points, both);
  return {SegmentOf(shank, "shank", normal, least), SegmentOf(thigh, "thigh", normal, least)};
}

}  // namespace lake::axis
