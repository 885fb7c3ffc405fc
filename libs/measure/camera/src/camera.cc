#include "lake/camera/camera.h"

#include <ceres/jet.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "lake/core/error.h"

namespace lake::camera {
namespace {

// Where a falling function crosses zero, from below.
double Bisect(const auto& function, double low, double high, int halvings) {
  for (int i = 0; i < halvings; ++i) {
    const double middle = (low + high) / 2;
    (function(middle) > 0 ? low : high) = middle;
  }
  return low;
}

// The radial part of the lens at a distance r from the axis: where (r, 0) goes without the tangential terms.
template <typename T>
T RadialPart(const Camera& camera, const T& r) {
  T c[kLensCoefficients] = {};
  for (std::size_t i = 0; i < 5; ++i) c[i] = T(camera.distortion[i]);
  if (camera.model == LensModel::kFisheye) return DistortFisheye(c, r, T(0)).x();
  c[2] = c[3] = T(0);
  for (std::size_t i = 0; i < 3; ++i) c[5 + i] = T(camera.more[i]);
  return DistortBrownConrady(c, 8, r, T(0)).x();
}

// The first r at which the radial part does not rise; it is looked for in steps of half a degree of the angle from the
// axis, so that what happens at the very edge is not missed.
double SearchFold(const Camera& camera) {
  constexpr int kSteps = 178, kToTheLastBit = 60;
  constexpr double kStep_rad = std::numbers::pi / 360;
  using Jet = ceres::Jet<double, 1>;
  const auto slope = [&](double angle) { return RadialPart(camera, Jet(std::tan(angle), 0)).v[0]; };
  for (int i = 0; i < kSteps; ++i)
    if (!(slope((i + 1) * kStep_rad) > 0))
      return std::tan(Bisect(slope, i * kStep_rad, (i + 1) * kStep_rad, kToTheLastBit));
  return std::numeric_limits<double>::infinity();
}

// The distorted normalised point of a normalised point, and its Jacobian.
struct Distorted {
  Eigen::Vector2d point;
  Eigen::Matrix2d jacobian;
};

Distorted Distort(const Camera& camera, const Eigen::Vector2d& p) {
  using Jet = ceres::Jet<double, 2>;
  Camera normalised = camera;
  normalised.fx = normalised.fy = 1;
  normalised.cx = normalised.cy = 0;
  const Eigen::Matrix<Jet, 2, 1> at = ProjectAny<Jet>(normalised, {Jet(p.x(), 0), Jet(p.y(), 1), Jet(1)});
  Distorted d{{at.x().a, at.y().a}, {}};
  d.jacobian << at.x().v.transpose(), at.y().v.transpose();
  return d;
}

// About the radius inside the fold that the radial part alone moves to `distorted`; the fold itself if none does.
double UndistortRadius(const Camera& camera, double distorted, double fold) {
  constexpr int kHalvings = 8;       // a start for Newton's method
  constexpr double kFarthest = 1e3;  // 89.94 degrees from the axis: a fisheye sees no further in front of itself
  const auto missing = [&](double r) { return distorted - RadialPart(camera, r); };
  double high = std::isfinite(fold) ? fold : std::max(distorted, 1e-3);
  while (!std::isfinite(fold) && missing(high) > 0 && high < kFarthest) high *= 2;
  return missing(high) >= 0 ? high : Bisect(missing, 0, high, kHalvings);
}

// Newton's method with the step halved while it does not help; nullopt if it ends on no solution inside the fold.
std::optional<Eigen::Vector2d> UndistortNewton(const Camera& camera, const Eigen::Vector2d& target,
                                               Eigen::Vector2d point) {
  constexpr int kMaxIterations = 50, kMaxHalvings = 20;
  constexpr double kTolerance = 1e-14;  // of a normalised coordinate; 1e-11 px at fx = 1000
  Distorted now = Distort(camera, point);
  for (int i = 0; i < kMaxIterations && now.jacobian.determinant() > 0; ++i) {
    Eigen::Vector2d step = now.jacobian.inverse() * (target - now.point);
    if (step.norm() <= kTolerance * (1 + point.norm())) return point;
    Distorted next = Distort(camera, point + step);
    int halvings = 0;
    const auto worse = [&] {
      return next.jacobian.determinant() <= 0 || (next.point - target).norm() > (now.point - target).norm();
    };
    for (; worse() && halvings < kMaxHalvings; ++halvings) next = Distort(camera, point + (step /= 2));
    if (halvings == kMaxHalvings) {  // rounding keeps the residual from falling further, or there is no solution
      const double noise = 1e-13 * (1 + target.norm());
      return (now.point - target).norm() < noise ? std::optional(point) : std::nullopt;
    }
    point += step;
    now = next;
  }
  return std::nullopt;
}

}  // namespace

Eigen::Vector2d Project(const Camera& camera, const Eigen::Vector3d& point_in_camera) {
  if (!(point_in_camera.z() > 0))
    throw Fail("a point at z = {:.1f} mm is not in front of the camera", point_in_camera.z());
  return ProjectAny<double>(camera, point_in_camera);
}

// Many pixels of one camera are asked for one after the other, so each thread keeps the fold of the lens that it asked
// for last: looking for it takes several times as long as undoing the distortion of a pixel.
double FoldRadius(const Camera& camera) {
  struct Known {
    LensModel model;
    std::array<double, 5> distortion;
    std::array<double, 9> more;
    double fold;
  };
  thread_local std::optional<Known> last;
  if (!last || last->model != camera.model || last->distortion != camera.distortion || last->more != camera.more)
    last =
        Known{.model = camera.model, .distortion = camera.distortion, .more = camera.more, .fold = SearchFold(camera)};
  return last->fold;
}

Eigen::Vector3d RayFromPixel(const Camera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d target((pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy);
  const double distance = target.norm(), fold = FoldRadius(camera);
  if (distance == 0 && camera.IsPlain() && camera.distortion[2] == 0 && camera.distortion[3] == 0) return {0, 0, 1};
  if (std::isfinite(distance)) {
    // A little inside the fold, so that the first Jacobian is regular.
    const double radius = std::min(UndistortRadius(camera, distance, fold), fold * (1 - 1e-3));
    const Eigen::Vector2d start = distance > 0 ? Eigen::Vector2d(target * (radius / distance)) : target;
    const std::optional<Eigen::Vector2d> point = UndistortNewton(camera, target, start);
    if (point && point->norm() <= fold) return {point->x(), point->y(), 1};
  }
  throw Fail("pixel ({:.1f}, {:.1f}): the lens distortion cannot be undone there; is the camera file the right one?",
             pixel.x(), pixel.y());
}

PlanePoint PlanePointFromPixel(const Camera& camera, const PlanePose& camera_from_plane, const Eigen::Vector2d& pixel,
                               double depth_mm) {
  const PlanePose plane_from_camera = camera_from_plane.inverse();
  const Eigen::Vector3d ray = RayFromPixel(camera, pixel);
  const Eigen::Vector3d origin = plane_from_camera.translation(), direction = plane_from_camera.linear() * ray;
  const double scale = (depth_mm - origin.z()) / direction.z();
  if (!(scale > 0) || !std::isfinite(scale))
    throw Fail("pixel ({:.1f}, {:.1f}): its ray does not meet the sagittal plane in front of the camera", pixel.x(),
               pixel.y());
  PlanePoint point;
  point.position_mm = (origin + scale * direction).head<2>();
  point.mm_per_depth_mm = direction.head<2>() / direction.z();
  // A turn of the ray moves the point by scale (d direction), then along the ray back into the plane.
  Eigen::Matrix<double, 2, 3> position_by_direction;
  position_by_direction << scale, 0, -scale * point.mm_per_depth_mm.x(), 0, scale, -scale * point.mm_per_depth_mm.y();
  const Eigen::Matrix2d ray_by_pixel =
      Distort(camera, ray.head<2>()).jacobian.inverse() * Eigen::Vector2d(1 / camera.fx, 1 / camera.fy).asDiagonal();
  point.mm_per_px = position_by_direction * plane_from_camera.linear().leftCols<2>() * ray_by_pixel;
  return point;
}

double SigmaInPlane(const PlanePoint& point, double sigma_px) {
  return sigma_px * point.mm_per_px.norm() / std::sqrt(2.0);
}

Eigen::Vector2d PlaneFromPixel(const Camera& camera, const PlanePose& camera_from_plane, const Eigen::Vector2d& pixel,
                               double depth_mm) {
  return PlanePointFromPixel(camera, camera_from_plane, pixel, depth_mm).position_mm;
}

Eigen::Vector2d PixelFromPlane(const Camera& camera, const PlanePose& camera_from_plane,
                               const Eigen::Vector2d& point_in_plane_mm, double depth_mm) {
  return Project(camera, camera_from_plane * Eigen::Vector3d(point_in_plane_mm.x(), point_in_plane_mm.y(), depth_mm));
}

std::optional<Camera> CameraAtSize(const Camera& camera, int width_px, int height_px) {
  const double scale_x = static_cast<double>(width_px) / camera.image_width,
               scale_y = static_cast<double>(height_px) / camera.image_height;
  // Heights are rounded to whole, often even pixels.
  if (std::abs(camera.image_height * scale_x - height_px) > 1 && std::abs(camera.image_width * scale_y - width_px) > 1)
    return std::nullopt;
  Camera scaled = camera;
  scaled.image_width = width_px;
  scaled.image_height = height_px;
  scaled.fx *= scale_x;
  scaled.fy *= scale_y;
  scaled.cx = (camera.cx + 0.5) * scale_x - 0.5;
  scaled.cy = (camera.cy + 0.5) * scale_y - 0.5;
  return scaled;
}

void CheckResolution(const Camera& camera, const std::filesystem::path& camera_file, int width_px, int height_px,
                     const std::filesystem::path& picture) {
  if (camera.image_width == width_px && camera.image_height == height_px) return;
  const bool turned = camera.image_width == height_px && camera.image_height == width_px;
  throw Fail("{}: the camera was calibrated at {}x{} px, but {} has {}x{}; {}", camera_file.string(),
             camera.image_width, camera.image_height, picture.string(), width_px, height_px,
             turned ? "calibrate with the camera turned the same way" : "calibrate in the same video mode");
}

}  // namespace lake::camera
