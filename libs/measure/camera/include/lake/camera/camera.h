// A calibrated camera and, once known, the sagittal plane in front of it.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "lake/camera/lens.h"

namespace lake::camera {

// A lens in front of a pinhole, OpenCV's models and order of coefficients. Pixels are in the image frame: centre of the
// top-left pixel at (0, 0), x right, y down, distorted as recorded.
struct Camera {
  int image_width = 0;                    // px
  int image_height = 0;                   // px
  double fx = 0, fy = 0, cx = 0, cy = 0;  // px
  std::array<double, 5> distortion = {};  // k1 k2 p1 p2 k3; of a fisheye k1 k2 k3 k4 and 0
  LensModel model = LensModel::kBrownConrady;
  std::array<double, 9> more = {};  // k4 k5 k6 s1 s2 s3 s4 τx τy: the rational, thin-prism and tilted-sensor terms

  bool IsPlain() const { return model == LensModel::kBrownConrady && more == std::array<double, 9>{}; }
};

// The sagittal plane: z = 0 of the plane frame (mm; x right in the image, y up, z towards the camera).
using PlanePose = Eigen::Isometry3d;  // camera_from_plane

// Uncertainty of a calibrated camera.
struct CameraUncertainty {
  double rms_px = 0;  // reprojection error per corner, 2-D, as OpenCV counts it
  Eigen::Vector4d intrinsics_sd =
      Eigen::Vector4d::Zero();               // fx fy cx cy, px; one standard deviation, 0 for a fixed one
  std::array<double, 5> distortion_sd = {};  // k1 k2 p1 p2 k3
};

// Uncertainty of the plane's pose, given the camera.
struct PlaneUncertainty {
  double rms_px = 0;                                            // of the points it was fitted to, 2-D
  Eigen::Vector3d rotation_sd_rad = Eigen::Vector3d::Zero();    // about the plane's own x, y, z
  Eigen::Vector3d translation_sd_mm = Eigen::Vector3d::Zero();  // of plane_tvec, along the camera's x, y, z
};

struct CameraProfile {
  Camera camera;
  std::optional<PlanePose> camera_from_plane;
  std::optional<CameraUncertainty> uncertainty;
  std::optional<PlaneUncertainty> plane_uncertainty;
  double readout_s = 0;  // of a rolling shutter: the picture's row y is read at t + (y / height − 1/2) readout_s
  std::vector<std::string> warnings = {};  // of reading another program's file
};

// The pixel of a point in the camera frame (x right, y down, z forward). T is double or a ceres::Jet; the point's z
// must be positive. intrinsics: fx fy cx cy; distortion: k1 k2 p1 p2 k3.
template <typename T>
Eigen::Matrix<T, 2, 1> ProjectBrownConrady(const T* intrinsics, const T* distortion,
                                           const Eigen::Matrix<T, 3, 1>& point) {
  const T x = point.x() / point.z(), y = point.y() / point.z();
  const T r2 = x * x + y * y;
  const T radial = T(1) + r2 * (distortion[0] + r2 * (distortion[1] + r2 * distortion[4]));
  const T xd = x * radial + T(2) * distortion[2] * x * y + distortion[3] * (r2 + T(2) * x * x);
  const T yd = y * radial + distortion[2] * (r2 + T(2) * y * y) + T(2) * distortion[3] * x * y;
  return {intrinsics[0] * xd + intrinsics[2], intrinsics[1] * yd + intrinsics[3]};
}

// The pixel of a point in the camera frame under any model; T as above.
template <typename T>
Eigen::Matrix<T, 2, 1> ProjectAny(const Camera& camera, const Eigen::Matrix<T, 3, 1>& point) {
  const T intrinsics[] = {T(camera.fx), T(camera.fy), T(camera.cx), T(camera.cy)};
  if (camera.IsPlain()) {
    T distortion[5];
    for (std::size_t i = 0; i < 5; ++i) distortion[i] = T(camera.distortion[i]);
    return ProjectBrownConrady<T>(intrinsics, distortion, point);
  }
  T coefficients[kLensCoefficients];
  for (std::size_t i = 0; i < 5; ++i) coefficients[i] = T(camera.distortion[i]);
  for (std::size_t i = 0; i < 9; ++i) coefficients[5 + i] = T(camera.more[i]);
  return ProjectLens<T>(camera.model, intrinsics, coefficients, point);
}

// Throws Error if the point is not in front of the camera.
Eigen::Vector2d Project(const Camera& camera, const Eigen::Vector3d& point_in_camera);

// Beyond some angle from the axis the radial part turns back ("folds"), and a second, wrong ray has the same
// pixel. This is that angle's tangent sqrt(x² + y²); infinite if it never turns.
double FoldRadius(const Camera& camera);

// The direction (x, y, 1) in the camera frame that is seen at a pixel: Newton's method on the distortion, started and
// kept inside the fold. Throws Error if no ray inside the fold is seen there (a pixel outside the picture of a strongly
// distorting lens).
Eigen::Vector3d RayFromPixel(const Camera& camera, const Eigen::Vector2d& pixel);

// The point where a pixel's ray meets the plane z = depth of the plane frame, with its derivatives.
struct PlanePoint {
  Eigen::Vector2d position_mm;
  Eigen::Matrix2d mm_per_px;        // d position / d pixel
  Eigen::Vector2d mm_per_depth_mm;  // d position / d depth: the parallax of a marker that stands proud of the plane
};

// As PlaneFromPixel below, with its derivatives.
PlanePoint PlanePointFromPixel(const Camera& camera, const PlanePose& camera_from_plane, const Eigen::Vector2d& pixel,
                               double depth_mm = 0);

// Standard deviation per axis in the plane, mm (root mean square of both axes), of a point with this standard deviation
// in the picture, px.
double SigmaInPlane(const PlanePoint& point, double sigma_px);

// Where the ray of a pixel meets the plane z = `depth_mm` of the plane frame (a marker that stands proud of the
// sagittal plane towards the camera has a positive depth). In mm in the plane frame. Throws Error if the ray misses the
// plane.
Eigen::Vector2d PlaneFromPixel(const Camera& camera, const PlanePose& camera_from_plane, const Eigen::Vector2d& pixel,
                               double depth_mm = 0);

Eigen::Vector2d PixelFromPlane(const Camera& camera, const PlanePose& camera_from_plane,
                               const Eigen::Vector2d& point_in_plane_mm, double depth_mm = 0);

// Throws Error naming `camera_file`, `picture` (a video or image) and both sizes unless the camera was calibrated at
// this size.
void CheckResolution(const Camera& camera, const std::filesystem::path& camera_file, int width_px, int height_px,
                     const std::filesystem::path& picture);

// The camera of the same lens and field of view in a picture of another size and the same aspect, to a pixel: a video
// mode that scales the whole sensor. nullopt for another aspect.
std::optional<Camera> CameraAtSize(const Camera& camera, int width_px, int height_px);

// camera.yaml: an OpenCV FileStorage file with image_width, image_height, camera_matrix, distortion_coefficients and,
// if known, distortion_model (fisheye), readout_s, rms_px, intrinsics_sd, distortion_sd, plane_rvec, plane_tvec,
// plane_rms_px, plane_rotation_sd_rad, plane_translation_sd_mm. Files of OpenCV's calibration sample load as they are:
// 4, 5, 8, 12 or 14 coefficients, or 4 of a fisheye (distortion_model, or fisheye_model: 1). Throws Error naming file
// and key: a key that is absent, not finite, of a wrong shape, a focal length that is not positive, skew, another
// number of coefficients, a plane seen from behind.
// Or a file of another program, whose pose in the laboratory is left out: camera_info of ROS, camchain.yaml of kalibr,
// TOML of Pose2Sim and caliscope, .xcp of Vicon, XML of Qualisys; of several cameras the one called `view`.
CameraProfile ReadCameraProfile(const std::filesystem::path& path, const std::string& view = {});

// Whether a file's name ends as those of cameras do: .yaml, .toml, .xcp, …
bool IsCameraFile(const std::filesystem::path& path);

void WriteCameraProfile(const std::filesystem::path& path, const CameraProfile& profile);

// A key of camera.yaml, described for the template that a person fills in who has the lens from elsewhere.
struct CameraKey {
  const char* name;
  const char* value;    // an example, as OpenCV's FileStorage has it in YAML
  const char* meaning;  // with its unit
  bool is_needed = false;
};

// In the file's order: all that ReadCameraProfile knows.
std::span<const CameraKey> CameraKeys();

// A camera.yaml with every key and what it means, those that may be absent as comments. ReadCameraProfile takes it as
// it is: a camera of 1280 × 720 px without distortion and without a plane.
std::string CameraTemplate();

}  // namespace lake::camera
