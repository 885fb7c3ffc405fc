#include "lake/camera/homography.h"

#include <ceres/ceres.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <opencv2/core/eigen.hpp>
#include <vector>

#include "lake/core/error.h"

namespace lake::camera {
namespace {

// The similarity that moves points to mean 0 and mean square distance 2. Throws if they all coincide.
Eigen::Matrix3d Normalisation(const std::vector<Eigen::Vector2d>& points, const char* what) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto& p : points) mean += p / static_cast<double>(points.size());
  double square = 0;
  for (const auto& p : points) square += (p - mean).squaredNorm() / static_cast<double>(points.size());
  if (!(square > 0) || !std::isfinite(square))
    throw Fail("the {} of the known points all coincide or are not finite", what);
  const double scale = std::sqrt(2 / square);
  Eigen::Matrix3d normal;
  normal << scale, 0, -scale * mean.x(), 0, scale, -scale * mean.y(), 0, 0, 1;
  return normal;
}

Eigen::Vector2d Map(const Eigen::Matrix3d& h, const Eigen::Vector2d& p) {
  return (h * p.homogeneous()).hnormalized();
}

// The h that makes target x h source vanish in the least-squares sense; both normalised. cv::findHomography and
// cv::getPerspectiveTransform work in single precision: four exact corners of 0.6 m × 0.7 m come back within 4e-5 mm
// instead of 1e-12 mm, and points in one line without a complaint.
Eigen::Matrix3d DirectLinearTransform(const std::vector<Eigen::Vector2d>& source,
                                      const std::vector<Eigen::Vector2d>& target) {
  const auto rows = static_cast<Eigen::Index>(2 * source.size());
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(std::max<Eigen::Index>(rows, 9), 9);
  for (std::size_t i = 0; i < source.size(); ++i) {
    const Eigen::RowVector3d p = source[i].homogeneous().transpose();
    const auto row = static_cast<Eigen::Index>(2 * i);
    a.block<1, 3>(row, 0) = p, a.block<1, 3>(row, 6) = -target[i].x() * p;
    a.block<1, 3>(row + 1, 3) = p, a.block<1, 3>(row + 1, 6) = -target[i].y() * p;
  }
  cv::Mat matrix, singular, left, right_transposed;
  cv::eigen2cv(a, matrix);
  cv::SVD::compute(matrix, singular, left, right_transposed, cv::SVD::FULL_UV);
  // The eighth singular value vanishes where three of four points are in line; a good quadrilateral has more than 0.1.
  constexpr double kLeastRatio = 1e-3;
  if (singular.at<double>(7) < kLeastRatio * singular.at<double>(0))
    throw Fail(
        "the known points do not span a plane: four of them must form a quadrilateral with no three in one line");
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(right_transposed.ptr<double>(8));
}

// residual = image_from_plane(point) - pixel, all normalised; the ninth element of h is held by scale freedom.
struct TransferResidual {
  Eigen::Vector2d plane, image;

  template <typename T>
  bool operator()(const T* h, T* residual) const {
    const T w = h[6] * plane.x() + h[7] * plane.y() + h[8];
    residual[0] = (h[0] * plane.x() + h[1] * plane.y() + h[2]) / w - image.x();
    residual[1] = (h[3] * plane.x() + h[4] * plane.y() + h[5]) / w - image.y();
    return true;
  }
};

Eigen::Matrix3d Refine(const Eigen::Matrix3d& start, const std::vector<Eigen::Vector2d>& plane,
                       const std::vector<Eigen::Vector2d>& image) {
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> h = start / start.norm();
  ceres::Problem problem;
  for (std::size_t i = 0; i < plane.size(); ++i)
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<TransferResidual, 2, 9>(new TransferResidual{plane[i], image[i]}), nullptr,
        h.data());
  problem.SetManifold(h.data(), new ceres::SphereManifold<9>());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.function_tolerance = options.gradient_tolerance = options.parameter_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return summary.IsSolutionUsable() ? Eigen::Matrix3d(h) : start;
}

// All points must lie on the same side of the line that maps to infinity, else no camera saw them so.
void CheckOneSide(const Eigen::Matrix3d& h, std::span<const PlaneCorrespondence> points) {
  int positive = 0;
  for (const auto& p : points) positive += h.row(2).dot(p.pixel.homogeneous()) > 0;
  if (positive != 0 && positive != static_cast<int>(points.size()))
    throw Fail("the known points cannot be one view of a plane: are pixels and millimetres given in the same order?");
}

}  // namespace

HomographyFit PlaneHomography(std::span<const PlaneCorrespondence> points) {
  if (points.size() < 4) throw Fail("a plane needs at least 4 known points, not {}", points.size());
  std::vector<Eigen::Vector2d> image, plane;
  for (const auto& p : points) {
    if (!p.pixel.allFinite() || !p.point_in_plane.allFinite()) throw Fail("a known point of the plane is not finite");
    image.push_back(p.pixel);
    plane.push_back(p.point_in_plane);
  }
  const Eigen::Matrix3d n_image = Normalisation(image, "pixels"), n_plane = Normalisation(plane, "millimetres");
  for (auto& p : image) p = Map(n_image, p);
  for (auto& p : plane) p = Map(n_plane, p);

  const Eigen::Matrix3d image_from_plane = Refine(DirectLinearTransform(plane, image), plane, image);
  // Three points in line on one side only give a singular mapping.
  constexpr double kLeastDeterminant =
      1e-6;  // of a matrix of norm 1 between normalised points; a frontal view has 0.19
  if (std::abs((image_from_plane / image_from_plane.norm()).determinant()) < kLeastDeterminant)
    throw Fail("the known points do not span a plane: too many of them lie in one line");
  HomographyFit fit;
  fit.plane_from_image = n_plane.inverse() * image_from_plane.inverse() * n_image;
  CheckOneSide(fit.plane_from_image, points);
  // The sign is that of the points' side, so that ApplyHomography can tell the horizon.
  fit.plane_from_image *=
      (fit.plane_from_image.row(2).dot(points.front().pixel.homogeneous()) > 0 ? 1 : -1) / fit.plane_from_image.norm();
  const Eigen::Matrix3d back = fit.plane_from_image.inverse();
  for (const auto& p : points)
    fit.rms_px += (Map(back, p.point_in_plane) - p.pixel).squaredNorm() / static_cast<double>(points.size());
  fit.rms_px = std::sqrt(fit.rms_px);
  return fit;
}

Eigen::Vector2d ApplyHomography(const HomographyFit& fit, const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d p = fit.plane_from_image * pixel.homogeneous();
  if (!(p.z() > 0)) throw Fail("pixel ({:.1f}, {:.1f}) lies beyond the plane's horizon", pixel.x(), pixel.y());
  return p.hnormalized();
}

}  // namespace lake::camera
