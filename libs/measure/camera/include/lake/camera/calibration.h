// A camera from views of a board: OpenCV's solution as the seed, then one bundle adjustment over all views.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <utility>
#include <vector>

#include "lake/camera/board.h"
#include "lake/camera/camera.h"

namespace lake::camera {

// Which of the models' coefficients are free.
enum class LensFamily {
  kPolynomial,  // k1 k2 p1 p2 k3
  kRational,    // these and k4 k5 k6
  kFisheye,     // k1 k2 k3 k4 of the angle from the axis
};

// "polynomial", "rational", "fisheye".
std::string ToString(LensFamily lens);

struct CalibrationOptions {
  LensFamily lens = LensFamily::kPolynomial;
  bool robust = true;          // Cauchy loss, its scale from the residuals; else least squares
  bool fix_k3 = false;         // k3 = 0: for views that do not reach the corners of the picture
  bool square_pixels = false;  // fx = fy
};

// Summary of a solve.
struct SolveSummary {
  bool usable = false;
  int iterations = 0;
  double cost_before = 0, cost_after = 0;  // half the sum of (robustified) squares, px²
  std::string message;
};

struct CornerOutlier {
  std::size_t view = 0;  // index into the views
  int corner = 0;        // index into BoardCorners
  double error_px = 0;
};

// fx fy cx cy and the first five coefficients: k1 k2 p1 p2 k3; of a fisheye k1 k2 k3 k4 and zeros.
using IntrinsicCovariance = Eigen::Matrix<double, 9, 9>;

struct CalibrationResult {
  Camera camera;
  IntrinsicCovariance covariance = IntrinsicCovariance::Zero();  // rows of fixed parameters are 0
  std::vector<Eigen::Isometry3d> camera_from_board;              // one per view
  std::vector<std::vector<Eigen::Vector2d>> residual_px;         // per view and corner: seen − predicted
  std::vector<double> view_rms_px;                               // 2-D, as OpenCV counts it
  std::vector<CornerOutlier> outliers;  // beyond 5 sigma_px, worst first; one in 3e5 if the noise is normal
  double rms_px = 0;                    // of all corners, 2-D
  double inlier_rms_px = 0;             // without the outliers
  double sigma_px = 0;                  // noise of one coordinate, from the median residual
  double seed_rms_px = 0;               // OpenCV's own, same model, of 30 of the views at most
  SolveSummary summary;
};

// Zhang's method as OpenCV has it (Z. Zhang, A flexible new technique for camera calibration, 2000) gives the seed. The
// bundle adjustment minimises sum rho(|seen − predicted|²) over intrinsics, distortion and all poses. The covariance is
// that of an M-estimate, (J'J)^-1 · sum |psi|² / (2n − p) / mean(psi')² (Huber & Ronchetti, Robust Statistics, 2009,
// sec. 7.6), which for least squares is the residual variance times (J'J)^-1; it stays 0 if the summary is not usable.
// Throws Error: fewer than 3 views, views that do not fix the parameters.
CalibrationResult CalibrateCamera(const Board& board, const std::vector<BoardView>& views, int width_px, int height_px,
                                  const CalibrationOptions& options = {});

// Of the views, those with an even (`first` 0) or an odd index.
std::vector<BoardView> EveryOther(const std::vector<BoardView>& views, std::size_t first);

// Cross-validated error of each family of lenses.
struct LensChoice {
  LensFamily lens = LensFamily::kPolynomial;
  std::vector<std::pair<LensFamily, double>> error_px;  // median corner error of the views left out; of those that fit
};

// Every family is fitted to the odd and to the even views in turn, and tried on the others with only the board's pose
// free. The least error wins, but a family of more coefficients, or another kind, must be better by 3 %. With fewer
// than 10 views, or where k3 is to stay fixed, the polynomial.
LensChoice ChooseLens(const Board& board, const std::vector<BoardView>& views, int width_px, int height_px,
                      const CalibrationOptions& options = {});

// The standard deviations for camera.yaml.
CameraUncertainty UncertaintyOf(const CalibrationResult& result);

}  // namespace lake::camera
