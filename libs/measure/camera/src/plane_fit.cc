#include "lake/camera/plane_fit.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>

#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"

namespace lake::camera {
namespace {

constexpr double kTellApart = 25;     // sigma²
constexpr double kSamePoseDeg = 0.1;  // two minima closer than this are one
constexpr double kHighPlaneRmsPx = 2;
constexpr double kLargestRollDeg = 5;

// residual = seen - project(start * exp(turn) * point + translation), px; turn in the plane's own axes
struct PlanePointError {
  const Camera& camera;
  Eigen::Matrix3d start;
  Eigen::Vector2d seen, point;

  template <typename T>
  bool operator()(const T* turn, const T* translation, T* residual) const {
    const T in_plane[3] = {T(point.x()), T(point.y()), T(0)};
    Eigen::Matrix<T, 3, 1> turned;
    ceres::AngleAxisRotatePoint(turn, in_plane, turned.data());
    const Eigen::Matrix<T, 3, 1> in_camera =
        start.cast<T>() * turned + Eigen::Map<const Eigen::Matrix<T, 3, 1>>(translation);
    if (!(in_camera.z() > T(0))) return false;
    Eigen::Map<Eigen::Matrix<T, 2, 1>> error(residual);
    error = seen.cast<T>() - ProjectAny<T>(camera, in_camera);
    return true;
  }
};

struct Refined {
  PlanePose pose;
  double sum_px2 = 0;                   // of squared residuals
  Eigen::Matrix<double, 6, 6> inverse;  // (J'J)^-1 in turn, translation; NaN if singular
  std::vector<Eigen::Vector2d> residual_px;
};

// One solve about the pose; done twice, so that the covariance is taken at turn 0.
Refined RefineOnce(const Camera& camera, std::span<const PlaneCorrespondence> points, const PlanePose& start) {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero(), translation = start.translation();
  ceres::Problem problem;
  for (const auto& p : points)
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<PlanePointError, 2, 3, 3>(
            new PlanePointError{.camera = camera, .start = start.linear(), .seen = p.pixel, .point = p.point_in_plane}),
        nullptr, turn.data(), translation.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 200;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-13;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);

  Refined refined;
  refined.pose = start;
  refined.pose.linear() = start.linear() * Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()).toRotationMatrix();
  refined.pose.translation() = translation;
  refined.sum_px2 = 2 * summary.final_cost;
  ceres::Covariance covariance((ceres::Covariance::Options()));
  const std::vector<const double*> blocks = {turn.data(), translation.data()};
  Eigen::Matrix<double, 6, 6, Eigen::RowMajor> inverse;
  refined.inverse.setConstant(std::nan(""));
  if (covariance.Compute(blocks, &problem) && covariance.GetCovarianceMatrix(blocks, inverse.data()))
    refined.inverse = inverse;
  for (const auto& p : points)
    refined.residual_px.push_back(p.pixel - PixelFromPlane(camera, refined.pose, p.point_in_plane));
  return refined;
}

bool AllInFront(const PlanePose& pose, std::span<const PlaneCorrespondence> points) {
  return std::all_of(points.begin(), points.end(), [&](const PlaneCorrespondence& p) {
    return (pose * Eigen::Vector3d(p.point_in_plane.x(), p.point_in_plane.y(), 0)).z() > 0;
  });
}

std::vector<Refined> RefinedPoses(const Camera& camera, std::span<const PlaneCorrespondence> points) {
  std::vector<cv::Point3d> in_plane;
  std::vector<cv::Point2d> normalised;
  for (const auto& p : points) {
    const Eigen::Vector3d ray = RayFromPixel(camera, p.pixel);
    in_plane.emplace_back(p.point_in_plane.x(), p.point_in_plane.y(), 0);
    normalised.emplace_back(ray.x(), ray.y());
  }
  std::vector<cv::Mat> r, t;
  try {
    cv::solvePnPGeneric(in_plane, normalised, cv::Matx33d::eye(), cv::noArray(), r, t, false, cv::SOLVEPNP_IPPE);
  } catch (const cv::Exception&) {
    r.clear();
  }
  std::vector<Refined> poses;
  for (std::size_t i = 0; i < r.size(); ++i) {
    if (!cv::checkRange(r[i]) || !cv::checkRange(t[i])) continue;
    const Eigen::Vector3d rotation(r[i].ptr<double>());
    PlanePose start = PlanePose::Identity();
    start.linear() = Eigen::AngleAxisd(rotation.norm(), rotation.stableNormalized()).toRotationMatrix();
    start.translation() = Eigen::Vector3d(t[i].ptr<double>());
    if (!AllInFront(start, points)) continue;
    poses.push_back(RefineOnce(camera, points, RefineOnce(camera, points, start).pose));
  }
  if (poses.empty()) throw Fail("no pose of the plane explains its {} known points", points.size());
  std::sort(poses.begin(), poses.end(), [](const Refined& a, const Refined& b) { return a.sum_px2 < b.sum_px2; });
  return poses;
}

double RollDeg(const PlanePose& pose) {
  return DegreesFromRadians(std::atan2(-pose.linear()(1, 0), pose.linear()(0, 0)));
}

double ApartDeg(const PlanePose& a, const PlanePose& b) {
  return DegreesFromRadians(std::acos(std::clamp(a.linear().col(2).dot(b.linear().col(2)), -1.0, 1.0)));
}

void AddWarnings(PlaneFit& fit) {
  if (fit.other && fit.other->as_likely)
    fit.warnings.push_back(
        fmt::format("the plane's tilt is ambiguous: another pose, {:.1f} degrees away, fits as well ({:.3f} px "
                    "against {:.3f} px RMS); use a larger board or points farther apart, or a closer camera",
                    fit.other->apart_deg, fit.other->rms_px, fit.uncertainty.rms_px));
  if (fit.uncertainty.rms_px > kHighPlaneRmsPx)
    fit.warnings.push_back(
        fmt::format("the known points miss the plane by {:.1f} px RMS: a point is wrong, or the camera file is "
                    "not this camera's",
                    fit.uncertainty.rms_px));
  if (std::abs(fit.roll_deg) > kLargestRollDeg)
    fit.warnings.push_back(
        fmt::format("the plane's x axis is turned by {:.0f} degrees in the picture: y is not up; set the board "
                    "level, or say where up is with --vertical when tracking",
                    fit.roll_deg));
}

// The points' coordinates after counter-clockwise quarter turns of the frame.
std::vector<Eigen::Vector2d> Turned(std::vector<Eigen::Vector2d> points, int quarter_turns) {
  for (auto& p : points)
    for (int i = 0; i < quarter_turns; ++i) p = Eigen::Vector2d(p.y(), -p.x());
  return points;
}

}  // namespace

PlaneFit FitPlane(const Camera& camera, std::span<const PlaneCorrespondence> points, const PlaneFitOptions& options) {
  PlaneHomography(points);  // says clearly what is wrong with bad points
  const std::vector<Refined> poses = RefinedPoses(camera, points);
  const Refined& best = poses.front();
  if (!(best.pose.inverse().translation().z() > 0))
    throw Fail(
        "the millimetres of the known points are mirrored: seen from the camera, y must point up where x points right");
  if (!best.inverse.allFinite()) throw Fail("the known points do not fix the plane's pose");

  const double n = static_cast<double>(points.size());
  PlaneFit fit;
  fit.camera_from_plane = best.pose;
  fit.residual_px = best.residual_px;
  fit.sigma_px = std::max(std::sqrt(best.sum_px2 / (2 * n - 6)), options.least_sigma_px);
  const Eigen::Matrix<double, 6, 1> sd = fit.sigma_px * best.inverse.diagonal().cwiseSqrt();
  fit.uncertainty = {std::sqrt(best.sum_px2 / n), sd.head<3>(), sd.tail<3>()};
  fit.roll_deg = RollDeg(best.pose);
  if (poses.size() > 1 && ApartDeg(best.pose, poses[1].pose) > kSamePoseDeg)
    fit.other = {.camera_from_plane = poses[1].pose,
                 .rms_px = std::sqrt(poses[1].sum_px2 / n),
                 .apart_deg = ApartDeg(best.pose, poses[1].pose),
                 .as_likely = poses[1].sum_px2 - best.sum_px2 < kTellApart * fit.sigma_px * fit.sigma_px};
  AddWarnings(fit);
  return fit;
}

PlaneFit FitPlaneToBoard(const Camera& camera, const Board& board, const BoardView& view,
                         const PlaneFitOptions& options) {
  const auto correspondences = [&](const std::vector<Eigen::Vector2d>& corners) {
    std::vector<PlaneCorrespondence> points;
    for (std::size_t i = 0; i < view.corner.size(); ++i)
      points.push_back({view.pixel[i], corners.at(static_cast<std::size_t>(view.corner[i]))});
    return points;
  };
  const std::vector<Eigen::Vector2d> corners = BoardCorners(board);
  const PlaneFit as_printed = FitPlane(camera, correspondences(corners), options);
  // Each quarter turn of the frame adds 90 degrees to the roll of its x axis.
  const int quarter_turns = (static_cast<int>(std::lround(-as_printed.roll_deg / 90)) + 4) % 4;
  std::vector<Eigen::Vector2d> turned = Turned(corners, quarter_turns);
  Eigen::Vector2d lower_left = turned.front();
  for (const auto& p : turned) lower_left = lower_left.cwiseMin(p);
  for (auto& p : turned) p -= lower_left;
  return FitPlane(camera, correspondences(turned), options);
}

std::vector<PlaneCorrespondence> ParsePlanePoints(std::string_view text) {
  std::vector<PlaneCorrespondence> points;
  for (const std::string& part : SplitText(text, ';')) {
    if (part.empty()) continue;
    const std::vector<std::string> sides = SplitText(part, '=');
    if (sides.size() != 2) throw UsageError("plane points '{}': write X,Y=XMM,YMM", part);
    const auto pixel = ParseNumbers(sides[0], 2, "--points"), mm = ParseNumbers(sides[1], 2, "--points");
    points.push_back({{pixel[0], pixel[1]}, {mm[0], mm[1]}});
  }
  if (points.size() < 4) throw UsageError("--points: at least 4 points are needed, not {}", points.size());
  Eigen::AlignedBox2d extent;
  for (const PlaneCorrespondence& point : points) extent.extend(point.point_in_plane);
  constexpr double kLeast_mm = 10;  // in m, no room is as large
  if (const double size_mm = extent.diagonal().norm(); size_mm < kLeast_mm)
    throw UsageError(
        "--points: the places lie within {} mm of each other, which is no plane to move in: are they in m?",
        SignificantText(size_mm, 3));
  return points;
}

}  // namespace lake::camera
