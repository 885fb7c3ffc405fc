#include "lake/camera/camera.h"

#include <Eigen/LU>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "lake/core/atomic_file.h"
#include "lake/core/error.h"

namespace lake {
namespace {

// The distorted normalised point of a normalised point, and its Jacobian.
struct Distorted {
  Eigen::Vector2d point;
  Eigen::Matrix2d jacobian;
};

Distorted Distort(const std::array<double, 5>& k, const Eigen::Vector2d& p) {
  const auto [k1, k2, p1, p2, k3] = k;
  const double x = p.x(), y = p.y(), r2 = p.squaredNorm();
  const double radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double slope = k1 + r2 * (2 * k2 + r2 * 3 * k3);  // d radial / d r2
  Distorted d;
  d.point = {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x), y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y};
  d.jacobian(0, 0) = radial + 2 * x * x * slope + 2 * p1 * y + 6 * p2 * x;
  d.jacobian(0, 1) = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y;
  d.jacobian(1, 0) = 2 * x * y * slope + 2 * p1 * x + 2 * p2 * y;
  d.jacobian(1, 1) = radial + 2 * y * y * slope + 6 * p1 * y + 2 * p2 * x;
  return d;
}

cv::Mat ReadMatrix(const cv::FileStorage& file, const std::string& key, const std::filesystem::path& path) {
  cv::Mat matrix;
  if (file[key].empty()) throw Fail("{}: no key '{}'", path.string(), key);
  try {
    file[key] >> matrix;
    matrix.convertTo(matrix, CV_64F);
  } catch (const cv::Exception&) {
    throw Fail("{}: '{}' is not a matrix of numbers", path.string(), key);
  }
  if (!cv::checkRange(matrix)) throw Fail("{}: '{}' holds a value that is not finite", path.string(), key);
  return matrix.reshape(1, 1);
}

int ReadSize(const cv::FileStorage& file, const std::string& key, const std::filesystem::path& path) {
  if (!file[key].isInt()) throw Fail("{}: no whole number '{}'", path.string(), key);
  const int size = static_cast<int>(file[key]);
  if (size <= 0 || size > 1 << 16) throw Fail("{}: '{}' is {}, not the size of a picture", path.string(), key, size);
  return size;
}

Camera ReadCamera(const cv::FileStorage& file, const std::filesystem::path& path) {
  Camera camera;
  camera.image_width = ReadSize(file, "image_width", path);
  camera.image_height = ReadSize(file, "image_height", path);
  const cv::Mat k = ReadMatrix(file, "camera_matrix", path);
  if (k.total() != 9) throw Fail("{}: 'camera_matrix' has {} values, not 9", path.string(), k.total());
  camera.fx = k.at<double>(0), camera.fy = k.at<double>(4), camera.cx = k.at<double>(2), camera.cy = k.at<double>(5);
  if (camera.fx <= 0 || camera.fy <= 0) throw Fail("{}: a focal length in 'camera_matrix' is not positive", path.string());
  const cv::Mat d = ReadMatrix(file, "distortion_coefficients", path);
  if (d.total() != 4 && d.total() != 5)
    throw Fail("{}: 'distortion_coefficients' has {} values; 4 or 5 (k1 k2 p1 p2 k3) are understood", path.string(), d.total());
  for (std::size_t i = 0; i < d.total(); ++i) camera.distortion[i] = d.at<double>(static_cast<int>(i));
  return camera;
}

std::optional<PlanePose> ReadPlane(const cv::FileStorage& file, const std::filesystem::path& path) {
  if (file["plane_rvec"].empty() && file["plane_tvec"].empty()) return std::nullopt;
  const cv::Mat r = ReadMatrix(file, "plane_rvec", path), t = ReadMatrix(file, "plane_tvec", path);
  if (r.total() != 3 || t.total() != 3) throw Fail("{}: 'plane_rvec' and 'plane_tvec' must have 3 values each", path.string());
  const Eigen::Vector3d rotation(r.at<double>(0), r.at<double>(1), r.at<double>(2));
  PlanePose pose = PlanePose::Identity();
  if (rotation.norm() > 0) pose.linear() = Eigen::AngleAxisd(rotation.norm(), rotation.normalized()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(t.at<double>(0), t.at<double>(1), t.at<double>(2));
  if (pose.translation().z() <= 0) throw Fail("{}: 'plane_tvec' puts the plane's origin behind the camera", path.string());
  return pose;
}

}  // namespace

Eigen::Vector2d Project(const Camera& camera, const Eigen::Vector3d& point_in_camera) {
  const double intrinsics[] = {camera.fx, camera.fy, camera.cx, camera.cy};
  return ProjectBrownConrady<double>(intrinsics, camera.distortion.data(), point_in_camera);
}

Eigen::Vector3d RayFromPixel(const Camera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d target((pixel.x() - camera.cx) / camera.fx, (pixel.y() - camera.cy) / camera.fy);
  constexpr int kMaxIterations = 50;
  constexpr double kTolerance = 1e-13;  // of a normalised coordinate; 1e-10 px at fx = 1000
  Eigen::Vector2d point = target;
  for (int i = 0; i < kMaxIterations; ++i) {
    const Distorted d = Distort(camera.distortion, point);
    if (d.jacobian.determinant() <= 0) break;  // beyond the fold of the distortion
    const Eigen::Vector2d step = d.jacobian.inverse() * (d.point - target);
    point -= step;
    if (step.norm() < kTolerance * (1 + point.norm())) return {point.x(), point.y(), 1};
  }
  throw Fail("pixel ({:.1f}, {:.1f}): the lens distortion cannot be undone there; is the camera file the right one?", pixel.x(),
             pixel.y());
}

Eigen::Vector2d PlaneFromPixel(const Camera& camera, const PlanePose& camera_from_plane, const Eigen::Vector2d& pixel,
                               double depth_mm) {
  const PlanePose plane_from_camera = camera_from_plane.inverse();
  const Eigen::Vector3d origin = plane_from_camera.translation();
  const Eigen::Vector3d direction = plane_from_camera.linear() * RayFromPixel(camera, pixel);
  const double scale = (depth_mm - origin.z()) / direction.z();
  if (!(scale > 0) || !std::isfinite(scale))
    throw Fail("pixel ({:.1f}, {:.1f}): its ray does not meet the sagittal plane in front of the camera", pixel.x(), pixel.y());
  return (origin + scale * direction).head<2>();
}

Eigen::Vector2d PixelFromPlane(const Camera& camera, const PlanePose& camera_from_plane,
                               const Eigen::Vector2d& point_in_plane_mm, double depth_mm) {
  return Project(camera, camera_from_plane * Eigen::Vector3d(point_in_plane_mm.x(), point_in_plane_mm.y(), depth_mm));
}

CameraProfile ReadCameraProfile(const std::filesystem::path& path) {
  const std::string text = ReadTextFile(path, 1 << 24);
  try {
    const cv::FileStorage file(text, cv::FileStorage::READ | cv::FileStorage::MEMORY);
    if (!file.isOpened()) throw Fail("{}: not an OpenCV FileStorage file", path.string());
    return {ReadCamera(file, path), ReadPlane(file, path)};
  } catch (const cv::Exception& error) {
    throw Fail("{}: not an OpenCV FileStorage file: {}", path.string(), error.err);
  }
}

void WriteCameraProfile(const std::filesystem::path& path, const CameraProfile& profile) {
  const Camera& camera = profile.camera;
  cv::FileStorage file(".yaml", cv::FileStorage::WRITE | cv::FileStorage::MEMORY | cv::FileStorage::FORMAT_YAML);
  file << "image_width" << camera.image_width << "image_height" << camera.image_height;
  file << "camera_matrix" << cv::Mat(cv::Matx33d(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1));
  file << "distortion_coefficients" << cv::Mat(1, 5, CV_64F, const_cast<double*>(camera.distortion.data()));
  if (profile.camera_from_plane) {
    const Eigen::AngleAxisd rotation(profile.camera_from_plane->linear());
    const Eigen::Vector3d r = rotation.angle() * rotation.axis(), t = profile.camera_from_plane->translation();
    file << "plane_rvec" << cv::Mat(cv::Vec3d(r.x(), r.y(), r.z())) << "plane_tvec" << cv::Mat(cv::Vec3d(t.x(), t.y(), t.z()));
  }
  WriteTextFile(path, file.releaseAndGetString());
}

}  // namespace lake
