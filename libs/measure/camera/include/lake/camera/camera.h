// A calibrated camera and, once known, the sagittal plane in front of it.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace lake::camera {

// OpenCV's models of lens distortion.
enum class LensModel {
  kBrownConrady,  // D. C. Brown, Close-range camera calibration, 1971; with OpenCV's rational, thin-prism and tilt
                  // terms
  kFisheye,       // J. Kannala & S. S. Brandt, 2006: the angle from the axis, not its tangent, as an odd polynomial
};

// k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4 τx τy; of a fisheye k1 k2 k3 k4 and zeros.
inline constexpr std::size_t kLensCoefficients = 14;

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

// Of the normalised point (x, y) = (X/Z, Y/Z).
template <typename T>
Eigen::Matrix<T, 2, 1> DistortFisheye(const T* c, const T& x, const T& y) {
  using std::atan, std::sqrt;
  const T r2 = x * x + y * y;
  if (r2 < T(1e-16)) return {x, y};
  const T r = sqrt(r2), theta = atan(r), t2 = theta * theta;
  const T scale = theta * (T(1) + t2 * (c[0] + t2 * (c[1] + t2 * (c[2] + t2 * c[3])))) / r;
  return {x * scale, y * scale};
}

// The image of a distorted point on a sensor tilted by τx about x, then by τy about y.
template <typename T>
Eigen::Matrix<T, 2, 1> OnTiltedSensor(const T& tau_x, const T& tau_y, const T& x, const T& y) {
  using std::cos, std::sin;
  const T cx = cos(tau_x), sx = sin(tau_x), cy = cos(tau_y), sy = sin(tau_y);
  // R = R_y(τy) R_x(τx); the point is projected onto the turned plane: [R33 0 −R13; 0 R33 −R23; 0 0 1] R (x, y, 1).
  const T rx = cy * x + sy * sx * y - sy * cx, ry = cx * y + sx, rz = sy * x - cy * sx * y + cy * cx;
  const T r33 = cy * cx, r13 = -sy * cx;
  return {(r33 * rx - r13 * rz) / rz, (r33 * ry - sx * rz) / rz};
}

// With the first 5, 8 or all 14 of the coefficients.
template <typename T>
Eigen::Matrix<T, 2, 1> DistortBrownConrady(const T* c, int count, const T& x, const T& y) {
  const T r2 = x * x + y * y, r4 = r2 * r2;
  T radial = T(1) + r2 * (c[0] + r2 * (c[1] + r2 * c[4]));
  if (count > 5) radial /= T(1) + r2 * (c[5] + r2 * (c[6] + r2 * c[7]));
  const T xd = x * radial + T(2) * c[2] * x * y + c[3] * (r2 + T(2) * x * x);
  const T yd = y * radial + c[2] * (r2 + T(2) * y * y) + T(2) * c[3] * x * y;
  if (count <= 8) return {xd, yd};
  const T xs = xd + c[8] * r2 + c[9] * r4, ys = yd + c[10] * r2 + c[11] * r4;
  if (c[12] == T(0) && c[13] == T(0)) return {xs, ys};
  return OnTiltedSensor(c[12], c[13], xs, ys);
}

// The pixel of a point in the camera frame (x right, y down, z forward). T is double or a ceres::Jet; the point's z
// must be positive. intrinsics: fx fy cx cy; coefficients as above.
template <typename T>
Eigen::Matrix<T, 2, 1> ProjectLens(LensModel model, int count, const T* intrinsics, const T* coefficients,
                                   const Eigen::Matrix<T, 3, 1>& point) {
  const T x = point.x() / point.z(), y = point.y() / point.z();
  const Eigen::Matrix<T, 2, 1> d = model == LensModel::kFisheye ? DistortFisheye(coefficients, x, y)
                                                                : DistortBrownConrady(coefficients, count, x, y);
  return {intrinsics[0] * d.x() + intrinsics[2], intrinsics[1] * d.y() + intrinsics[3]};
}

// The pixel of a point in the camera frame under any model; T as above.
template <typename T>
Eigen::Matrix<T, 2, 1> ProjectAny(const Camera& camera, const Eigen::Matrix<T, 3, 1>& point) {
  const T intrinsics[] = {T(camera.fx), T(camera.fy), T(camera.cx), T(camera.cy)};
  const int count = camera.IsPlain() ? 5 : static_cast<int>(kLensCoefficients);
  T coefficients[kLensCoefficients];
  for (int i = 0; i < count; ++i)
    coefficients[i] =
        T(i < 5 ? camera.distortion[static_cast<std::size_t>(i)] : camera.more[static_cast<std::size_t>(i - 5)]);
  return ProjectLens<T>(camera.model, count, intrinsics, coefficients, point);
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
