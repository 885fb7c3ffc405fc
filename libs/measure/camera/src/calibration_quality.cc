#include "lake/camera/calibration_quality.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "lake/core/angles.h"
#include "lake/core/error.h"

namespace lake::camera {
namespace {

constexpr double kHighRmsPx = 0.5;         // the field's custom: under 0.3 px good, over 0.5 px warn
constexpr double kLeastCoverage = 0.5;     // of cells
constexpr double kWidestEmptyStrip = 0.2;  // of the picture's width or height
constexpr double kLeastTiltDeg = 15;
constexpr std::size_t kFewViews = 8;
constexpr double kLargestFocalSd = 0.01;  // relative
constexpr double kHalvesDifferPx = 1;
constexpr double kHalvesDisagree = 3;  // of the RMS: beyond it the views may be of two cameras

// residual = project_b(rotation * ray_a) - pixel, px
struct RotatedRayError {
  Camera b;
  Eigen::Vector3d ray;
  Eigen::Vector2d pixel;

  template <typename T>
  bool operator()(const T* rotation, T* residual) const {
    const Eigen::Matrix<T, 3, 1> from = ray.cast<T>();
    Eigen::Matrix<T, 3, 1> turned;
    ceres::AngleAxisRotatePoint(rotation, from.data(), turned.data());
    if (!(turned.z() > T(0))) return false;
    Eigen::Map<Eigen::Matrix<T, 2, 1>> error(residual);
    error = ProjectAny<T>(b, turned) - pixel.cast<T>();
    return true;
  }
};

int CellsAlong(int length, int longer) {
  return std::max(1, static_cast<int>(std::lround(10.0 * length / longer)));
}

std::optional<Eigen::Vector3d> RayIfAny(const Camera& camera, const Eigen::Vector2d& pixel) {
  try {
    return RayFromPixel(camera, pixel);
  } catch (const Error&) {
    return std::nullopt;
  }
}

void WarnOfFit(const std::vector<BoardView>& views, const CalibrationResult& result, std::size_t worst,
               std::vector<std::string>& warnings) {
  if (result.rms_px <= kHighRmsPx) return;
  const char* cause = result.inlier_rms_px < kHighRmsPx
                          ? "a few corners are far off (blur, a hidden corner, a reflection)"
                          : "the board is not flat, the picture is blurred, or its lens is "
                            "beyond this model";
  warnings.push_back(fmt::format("RMS {:.2f} px is above {} px: {}; the worst view is {} ({:.2f} px)", result.rms_px,
                                 kHighRmsPx, cause, views[worst].name, result.view_rms_px[worst]));
}

void WarnOfCoverage(const Coverage& coverage, std::vector<std::string>& warnings) {
  std::string sides;
  const auto add = [&](double strip, const char* side) {
    if (strip > kWidestEmptyStrip)
      sides += fmt::format("{}{:.0f} % at the {}", sides.empty() ? "" : ", ", 100 * strip, side);
  };
  add(coverage.empty_left, "left");
  add(coverage.empty_right, "right");
  add(coverage.empty_top, "top");
  add(coverage.empty_bottom, "bottom");
  if (coverage.fraction >= kLeastCoverage && sides.empty()) return;
  warnings.push_back(
      fmt::format("the board covered {:.0f} % of the picture{}: the distortion there is a guess; move the board "
                  "into every corner of the picture",
                  100 * coverage.fraction, sides.empty() ? "" : ", nothing in " + sides));
}

void WarnOfGeometry(const std::vector<BoardView>& views, const CalibrationResult& result, double tilt_deg,
                    std::vector<std::string>& warnings) {
  if (views.size() < kFewViews)
    warnings.push_back(fmt::format("only {} views of the board: 12 to 25 are good", views.size()));
  if (tilt_deg < kLeastTiltDeg)
    warnings.push_back(
        fmt::format("the views are nearly parallel (the largest angle between two is {:.0f} degrees): focal length and "
                    "distance cannot be separated; tilt the board by 30 to 45 degrees",
                    tilt_deg));
  const double sd = std::sqrt(std::max(result.covariance(0, 0), 0.0)) / result.camera.fx;
  if (sd > kLargestFocalSd)
    warnings.push_back(
        fmt::format("the focal length is known to {:.1f} % only (one standard deviation): take more views, "
                    "nearer and more tilted",
                    100 * sd));
}

}  // namespace

Coverage CoverageOf(const std::vector<BoardView>& views, int width_px, int height_px) {
  const int longer = std::max(width_px, height_px);
  Coverage coverage;
  coverage.columns = CellsAlong(width_px, longer);
  coverage.rows = CellsAlong(height_px, longer);
  coverage.corners.assign(static_cast<std::size_t>(coverage.columns * coverage.rows), 0);
  Eigen::Array2d low(1, 1), high(0, 0);
  for (const BoardView& view : views) {
    for (const Eigen::Vector2d& pixel : view.pixel) {
      const Eigen::Array2d at = (pixel.array() + 0.5) / Eigen::Array2d(width_px, height_px);
      low = low.min(at);
      high = high.max(at);
      const int column = std::clamp(static_cast<int>(at.x() * coverage.columns), 0, coverage.columns - 1);
      const int row = std::clamp(static_cast<int>(at.y() * coverage.rows), 0, coverage.rows - 1);
      ++coverage.corners[static_cast<std::size_t>(row * coverage.columns + column)];
    }
  }
  const auto filled = std::count_if(coverage.corners.begin(), coverage.corners.end(), [](int n) { return n > 0; });
  coverage.fraction = static_cast<double>(filled) / static_cast<double>(coverage.corners.size());
  coverage.empty_left = low.x();
  coverage.empty_right = 1 - high.x();
  coverage.empty_top = low.y();
  coverage.empty_bottom = 1 - high.y();
  return coverage;
}

CameraDifference CompareCameras(const Camera& a, const Camera& b) {
  constexpr int kAlongLonger = 40;
  constexpr double kLossScalePx = 1;  // the corners of the picture, where both are guesses, shall not turn the rest
  const int longer = std::max(a.image_width, a.image_height);
  CameraDifference difference;
  difference.columns = std::max(2, kAlongLonger * a.image_width / longer);
  difference.rows = std::max(2, kAlongLonger * a.image_height / longer);
  std::vector<std::optional<Eigen::Vector3d>> rays;
  for (int row = 0; row < difference.rows; ++row) {
    for (int column = 0; column < difference.columns; ++column) {
      difference.pixel.emplace_back((a.image_width - 1) * static_cast<double>(column) / (difference.columns - 1),
                                    (a.image_height - 1) * static_cast<double>(row) / (difference.rows - 1));
      rays.push_back(RayIfAny(a, difference.pixel.back()));
    }
  }
  double rotation[3] = {0, 0, 0};
  ceres::Problem problem;
  for (std::size_t i = 0; i < rays.size(); ++i)
    if (rays[i])
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<RotatedRayError, 2, 3>(new RotatedRayError{b, *rays[i], difference.pixel[i]}),
          new ceres::CauchyLoss(kLossScalePx), rotation);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);

  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Eigen::Vector2d error = Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN());
    if (rays[i] && RotatedRayError{b, *rays[i], difference.pixel[i]}(rotation, error.data())) {
      sum += error.squaredNorm();
      ++count;
      difference.largest_px = std::max(difference.largest_px, error.norm());
    }
    difference.difference_px.push_back(error);
  }
  difference.rms_px = count ? std::sqrt(sum / count) : std::numeric_limits<double>::quiet_NaN();
  return difference;
}

std::optional<CameraDifference> CrossValidate(const Board& board, const std::vector<BoardView>& views, int width_px,
                                              int height_px, const CalibrationOptions& options) {
  if (views.size() < 6) return std::nullopt;
  try {
    const CalibrationResult even = CalibrateCamera(board, EveryOther(views, 0), width_px, height_px, options);
    const CalibrationResult odd = CalibrateCamera(board, EveryOther(views, 1), width_px, height_px, options);
    if (!even.summary.usable || !odd.summary.usable) return std::nullopt;
    return CompareCameras(even.camera, odd.camera);
  } catch (const Error&) {
    return std::nullopt;
  }
}

double LargestTiltDeg(const CalibrationResult& result) {
  double smallest_cosine = 1;
  for (const auto& a : result.camera_from_board)
    for (const auto& b : result.camera_from_board)
      smallest_cosine = std::min(smallest_cosine, a.linear().col(2).dot(b.linear().col(2)));
  return DegreesFromRadians(std::acos(std::clamp(smallest_cosine, -1.0, 1.0)));
}

CalibrationQuality AssessCalibration(const Board& board, const std::vector<BoardView>& views,
                                     const CalibrationResult& result, const CalibrationOptions& options) {
  const auto [width, height] = std::pair(result.camera.image_width, result.camera.image_height);
  CalibrationQuality quality;
  quality.coverage = CoverageOf(views, width, height);
  quality.cross_validation = CrossValidate(board, views, width, height, options);
  quality.largest_tilt_deg = LargestTiltDeg(result);
  quality.worst_view = static_cast<std::size_t>(std::max_element(result.view_rms_px.begin(), result.view_rms_px.end()) -
                                                result.view_rms_px.begin());
  if (quality.cross_validation && quality.cross_validation->rms_px > kHalvesDisagree * result.rms_px)
    quality.two_cameras = FindTwoCameras(board, views, result, options);
  if (quality.two_cameras)
    quality.warnings.push_back(fmt::format("{}: was the camera's zoom or focus changed, or its picture stabilised?",
                                           Describe(*quality.two_cameras, views)));
  WarnOfFit(views, result, quality.worst_view, quality.warnings);
  WarnOfCoverage(quality.coverage, quality.warnings);
  WarnOfGeometry(views, result, quality.largest_tilt_deg, quality.warnings);
  if (quality.cross_validation && quality.cross_validation->rms_px > kHalvesDifferPx)
    quality.warnings.push_back(
        fmt::format("odd and even views give cameras that differ by {:.1f} px RMS over the picture: more "
                    "views, more coverage, or fewer parameters (--fix-k3) are needed",
                    quality.cross_validation->rms_px));
  return quality;
}

}  // namespace lake::camera
