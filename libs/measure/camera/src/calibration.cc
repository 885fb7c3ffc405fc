#include "lake/camera/calibration.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <opencv2/calib3d.hpp>

#include "lake/camera/plane_fit.h"
#include "lake/core/counted.h"
#include "lake/core/error.h"
#include "lake/core/interrupt.h"
#include "lake/core/statistics.h"

namespace lake::camera {
namespace {

constexpr std::size_t kLeastViews = 3;  // two are enough for five intrinsics only in theory
constexpr double kOutlierSigmas = 5;
constexpr double kMedianOfRayleigh =
    1.17741002251547469;  // sqrt(2 ln 2): median |r| of a 2-D normal error of unit sigma

// The unknowns as Ceres sees them.
struct Unknowns {
  std::array<double, 4> intrinsics;  // fx fy cx cy
  std::array<double, kLensCoefficients> distortion = {};
  struct Pose {
    std::array<double, 3> rotation;  // angle-axis
    std::array<double, 3> translation;
  };
  std::vector<Pose> poses;  // camera from board
};

// The coefficients that a family has, in the order of lens.h.
constexpr int CoefficientsOf(LensFamily lens) {
  return lens == LensFamily::kRational ? 8 : lens == LensFamily::kFisheye ? 4 : 5;
}

LensModel ModelOf(LensFamily lens) {
  return lens == LensFamily::kFisheye ? LensModel::kFisheye : LensModel::kBrownConrady;
}

// residual = seen - project(camera_from_board * point), px
template <LensFamily kLens>
struct CornerError {
  Eigen::Vector2d seen, point_in_board;

  template <typename T>
  bool operator()(const T* intrinsics, const T* distortion, const T* rotation, const T* translation,
                  T* residual) const {
    const T point[3] = {T(point_in_board.x()), T(point_in_board.y()), T(0)};
    Eigen::Matrix<T, 3, 1> in_camera;
    ceres::AngleAxisRotatePoint(rotation, point, in_camera.data());
    in_camera += Eigen::Map<const Eigen::Matrix<T, 3, 1>>(translation);
    if (!(in_camera.z() > T(0))) return false;
    Eigen::Map<Eigen::Matrix<T, 2, 1>> error(residual);
    error = seen.cast<T>() - ProjectLens<T>(ModelOf(kLens), CoefficientsOf(kLens), intrinsics, distortion, in_camera);
    return true;
  }

  static ceres::CostFunction* Create(const Eigen::Vector2d& seen, const Eigen::Vector2d& point) {
    return new ceres::AutoDiffCostFunction<CornerError, 2, 4, CoefficientsOf(kLens), 3, 3>(
        new CornerError{seen, point});
  }
};

ceres::CostFunction* CreateCornerError(LensFamily lens, const Eigen::Vector2d& seen, const Eigen::Vector2d& point) {
  switch (lens) {
    case LensFamily::kRational:
      return CornerError<LensFamily::kRational>::Create(seen, point);
    case LensFamily::kFisheye:
      return CornerError<LensFamily::kFisheye>::Create(seen, point);
    case LensFamily::kPolynomial:
      break;
  }
  return CornerError<LensFamily::kPolynomial>::Create(seen, point);
}

// fx and fy move together: (f, cx, cy) of (fx, fy, cx, cy).
struct SquarePixels {
  template <typename T>
  bool Plus(const T* x, const T* delta, T* moved) const {
    moved[0] = x[0] + delta[0];
    moved[1] = x[1] + delta[0];
    moved[2] = x[2] + delta[1];
    moved[3] = x[3] + delta[2];
    return true;
  }
  template <typename T>
  bool Minus(const T* y, const T* x, T* delta) const {
    delta[0] = (y[0] - x[0] + y[1] - x[1]) / T(2);
    delta[1] = y[2] - x[2];
    delta[2] = y[3] - x[3];
    return true;
  }
};

struct Seed {
  Unknowns unknowns;
  double rms_px = 0;
};

std::vector<std::vector<cv::Point3f>> PointsInBoard(const Board& board, const std::vector<BoardView>& views) {
  const std::vector<Eigen::Vector2d> corners = BoardCorners(board);
  std::vector<std::vector<cv::Point3f>> points;
  for (const BoardView& view : views) {
    auto& list = points.emplace_back();
    for (const int c : view.corner) {
      const Eigen::Vector2d& p = corners.at(static_cast<std::size_t>(c));
      list.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), 0.f);
    }
  }
  return points;
}

// Spread over all views: OpenCV solves densely for all poses together, in a time that grows with the cube of their
// number, and thirty views fix a camera as well as a start needs it.
std::vector<std::size_t> ViewsForSeed(std::size_t views) {
  constexpr std::size_t kMost = 30;
  const std::size_t count = std::min(views, kMost);
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < count; ++i) chosen.push_back(i * views / count);
  return chosen;
}

Seed SeedOfOpenCv(const Board& board, const std::vector<BoardView>& views, cv::Size size,
                  const CalibrationOptions& options) {
  const std::vector<std::vector<cv::Point3f>> points = PointsInBoard(board, views);
  std::vector<std::vector<cv::Point2f>> pixels;
  for (const BoardView& view : views) {
    auto& list = pixels.emplace_back();
    for (const auto& p : view.pixel) list.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  const std::vector<std::size_t> chosen = ViewsForSeed(views.size());
  std::vector<std::vector<cv::Point3f>> chosen_points;
  std::vector<std::vector<cv::Point2f>> chosen_pixels;
  for (const std::size_t view : chosen) {
    chosen_points.push_back(points[view]);
    chosen_pixels.push_back(pixels[view]);
  }
  // OpenCV's default goes on for all 30 iterations, most of them without a change that a double shows; to one in a
  // million the bundle adjustment takes over at the same minimum, after a third of the time.
  const cv::TermCriteria until(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 1e-6);
  const int flags = (options.fix_k3 ? cv::CALIB_FIX_K3 : 0) | (options.square_pixels ? cv::CALIB_FIX_ASPECT_RATIO : 0);
  cv::Mat k = cv::Mat::eye(3, 3, CV_64F), d = cv::Mat::zeros(1, 5, CV_64F);
  std::vector<cv::Mat> r, t;
  Seed seed;
  try {
    seed.rms_px = cv::calibrateCamera(chosen_points, chosen_pixels, size, k, d, r, t, flags, until);
  } catch (const cv::Exception&) {
    seed.rms_px = std::nan("");
  }
  if (!std::isfinite(seed.rms_px) || !cv::checkRange(k) || !cv::checkRange(d))
    throw Fail("no camera explains these {} views: are they of one rigid board, tilted in different ways?",
               views.size());
  seed.unknowns.intrinsics = {k.at<double>(0, 0), k.at<double>(1, 1), k.at<double>(0, 2), k.at<double>(1, 2)};
  if (options.lens != LensFamily::kFisheye) std::copy_n(d.ptr<double>(), 5, seed.unknowns.distortion.begin());
  for (std::size_t i = 0; i < views.size(); ++i) {
    cv::Mat rotation, translation;
    cv::solvePnP(points[i], pixels[i], k, d, rotation, translation);
    Unknowns::Pose& pose = seed.unknowns.poses.emplace_back();
    std::copy_n(rotation.ptr<double>(), 3, pose.rotation.begin());
    std::copy_n(translation.ptr<double>(), 3, pose.translation.begin());
  }
  return seed;
}

// `loss` is not owned.
std::unique_ptr<ceres::Problem> MakeProblem(const Board& board, const std::vector<BoardView>& views,
                                            const CalibrationOptions& options, ceres::LossFunction* loss, Unknowns& u) {
  ceres::Problem::Options problem_options;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  auto problem = std::make_unique<ceres::Problem>(problem_options);
  const std::vector<Eigen::Vector2d> corners = BoardCorners(board);
  for (std::size_t v = 0; v < views.size(); ++v)
    for (std::size_t i = 0; i < views[v].corner.size(); ++i)
      problem->AddResidualBlock(
          CreateCornerError(options.lens, views[v].pixel[i], corners[static_cast<std::size_t>(views[v].corner[i])]),
          loss, u.intrinsics.data(), u.distortion.data(), u.poses[v].rotation.data(), u.poses[v].translation.data());
  if (options.square_pixels) problem->SetManifold(u.intrinsics.data(), new ceres::AutoDiffManifold<SquarePixels, 4, 3>);
  if (options.fix_k3)
    problem->SetManifold(u.distortion.data(), new ceres::SubsetManifold(CoefficientsOf(options.lens), {4}));
  return problem;
}

SolveSummary Solve(ceres::Problem& problem) {
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_SCHUR;  // what is left of a view's pose touches no other view's
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-12;
  options.gradient_tolerance = 1e-12;
  options.parameter_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return {.usable = summary.IsSolutionUsable(),
          .iterations = static_cast<int>(summary.iterations.size()),
          .cost_before = summary.initial_cost,
          .cost_after = summary.final_cost,
          .message = summary.message};
}

// Every corner's residual at the unknowns, view after view.
std::vector<Eigen::Vector2d> Residuals(ceres::Problem& problem) {
  ceres::Problem::EvaluateOptions options;
  options.apply_loss_function = false;
  std::vector<double> values;
  problem.Evaluate(options, nullptr, &values, nullptr, nullptr);
  std::vector<Eigen::Vector2d> residuals;
  for (std::size_t i = 0; i + 1 < values.size(); i += 2) residuals.emplace_back(values[i], values[i + 1]);
  return residuals;
}

double SigmaFromMedian(const std::vector<Eigen::Vector2d>& residuals) {
  std::vector<double> norms;
  for (const auto& r : residuals) norms.push_back(r.norm());
  return Median(std::move(norms)) / kMedianOfRayleigh;
}

// Solves with a Cauchy loss whose scale follows the residuals until it settles. The loss must outlive later uses of the
// problem.
SolveSummary SolveRobustly(ceres::Problem& problem, ceres::LossFunctionWrapper& loss) {
  constexpr double kScale = 3;       // of sigma; 95 % as precise as least squares if the noise is normal
  constexpr double kLeastPx = 1e-4;  // exact data have no scale
  constexpr int kMostRounds = 10;
  SolveSummary summary = Solve(problem);
  double sigma = 0;
  for (int round = 0; round < kMostRounds && summary.usable; ++round) {
    ThrowIfInterrupted();
    const double next = std::max(SigmaFromMedian(Residuals(problem)), kLeastPx);
    if (std::abs(next - sigma) < 1e-3 * next) break;
    sigma = next;
    loss.Reset(new ceres::CauchyLoss(kScale * sigma), ceres::TAKE_OWNERSHIP);
    const int iterations = summary.iterations;
    summary = Solve(problem);
    summary.iterations += iterations;
  }
  return summary;
}

// Huber's variance of one coordinate: sum |psi|² / (2n − p) / mean(psi')². For the squared loss the residual variance.
double EffectiveVariance(const std::vector<Eigen::Vector2d>& residuals, const ceres::LossFunction& loss,
                         int parameters) {
  const double n = 2 * static_cast<double>(residuals.size());
  double psi_squared = 0, slope = 0;
  for (const auto& r : residuals) {
    const double s = r.squaredNorm();
    double rho[3];
    loss.Evaluate(s, rho);
    psi_squared += rho[1] * rho[1] * s;
    slope += 2 * (rho[1] + s * rho[2]) / n;
  }
  return psi_squared / (n - parameters) / (slope * slope);
}

IntrinsicCovariance Covariance(ceres::Problem& problem, const Unknowns& u, LensFamily lens, double variance) {
  ceres::Covariance::Options options;
  options.apply_loss_function = false;
  ceres::Covariance covariance(options);
  const std::vector<const double*> blocks = {u.intrinsics.data(), u.distortion.data()};
  const int size = 4 + CoefficientsOf(lens), shared = std::min(size, 9);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values(size, size);
  if (!covariance.Compute(blocks, &problem) || !covariance.GetCovarianceMatrix(blocks, values.data()) ||
      !values.allFinite())
    throw Fail("the views do not fix the camera: tilt the board by 30 to 45 degrees in different directions");
  IntrinsicCovariance result = IntrinsicCovariance::Zero();
  result.topLeftCorner(shared, shared) = variance * values.topLeftCorner(shared, shared);
  return result;
}

// What the options ask of a family that has no k3.
void CheckLens(const CalibrationOptions& options) {
  if (options.fix_k3 && options.lens == LensFamily::kFisheye)
    throw UsageError("--fix-k3: a fisheye has no such k3; give --lens polynomial");
}

Camera CameraOf(const Unknowns& u, LensFamily lens, int width_px, int height_px) {
  const auto [fx, fy, cx, cy] = u.intrinsics;
  Camera camera = {width_px, height_px, fx, fy, cx, cy, {}};
  camera.model = ModelOf(lens);
  std::copy_n(u.distortion.begin(), 5, camera.distortion.begin());
  std::copy_n(u.distortion.begin() + 5, 9, camera.more.begin());
  return camera;
}

// The corners' errors in a view that took no part in the calibration: only the board's pose is free.
std::vector<double> ErrorsOf(const Camera& camera, const Board& board, const BoardView& view) {
  std::vector<double> errors;
  for (const Eigen::Vector2d& residual : FitPlaneToBoard(camera, board, view).residual_px)
    errors.push_back(residual.norm());
  return errors;
}

double CrossValidationError(const Board& board, const std::vector<BoardView>& views, int width_px, int height_px,
                            const CalibrationOptions& options) {
  std::vector<double> errors;
  for (const std::size_t left_out : {0, 1}) {
    const Camera camera = CalibrateCamera(board, EveryOther(views, 1 - left_out), width_px, height_px, options).camera;
    for (std::size_t v = left_out; v < views.size(); v += 2) {
      const std::vector<double> own = ErrorsOf(camera, board, views[v]);
      errors.insert(errors.end(), own.begin(), own.end());
    }
  }
  return Median(std::move(errors));
}

Eigen::Isometry3d PoseOf(const Unknowns::Pose& pose) {
  Eigen::Matrix3d rotation;
  ceres::AngleAxisToRotationMatrix(pose.rotation.data(), rotation.data());
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.linear() = rotation;
  transform.translation() = Eigen::Map<const Eigen::Vector3d>(pose.translation.data());
  return transform;
}

void FillResiduals(const std::vector<BoardView>& views, const std::vector<Eigen::Vector2d>& residuals,
                   CalibrationResult& result) {
  std::size_t next = 0;
  double sum = 0, inlier_sum = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    auto& list = result.residual_px.emplace_back();
    double view_sum = 0;
    for (const int corner : views[v].corner) {
      const Eigen::Vector2d& r = list.emplace_back(residuals[next++]);
      view_sum += r.squaredNorm();
      if (r.norm() > kOutlierSigmas * result.sigma_px)
        result.outliers.push_back({v, corner, r.norm()});
      else
        inlier_sum += r.squaredNorm();
    }
    sum += view_sum;
    result.view_rms_px.push_back(std::sqrt(view_sum / static_cast<double>(list.size())));
  }
  result.rms_px = std::sqrt(sum / static_cast<double>(next));
  result.inlier_rms_px = std::sqrt(inlier_sum / static_cast<double>(next - result.outliers.size()));
  std::sort(result.outliers.begin(), result.outliers.end(),
            [](const CornerOutlier& a, const CornerOutlier& b) { return a.error_px > b.error_px; });
}

}  // namespace

std::string ToString(LensFamily lens) {
  return lens == LensFamily::kPolynomial ? "polynomial" : lens == LensFamily::kRational ? "rational" : "fisheye";
}

std::vector<BoardView> EveryOther(const std::vector<BoardView>& views, std::size_t first) {
  std::vector<BoardView> chosen;
  for (std::size_t v = first; v < views.size(); v += 2) chosen.push_back(views[v]);
  return chosen;
}

LensChoice ChooseLens(const Board& board, const std::vector<BoardView>& views, int width_px, int height_px,
                      const CalibrationOptions& options) {
  constexpr std::size_t kLeastForChoice = 10;
  constexpr double kBetter = 0.97;
  LensChoice choice;
  if (views.size() < kLeastForChoice || options.fix_k3) return choice;
  double best = std::numeric_limits<double>::infinity();
  for (const LensFamily lens : {LensFamily::kPolynomial, LensFamily::kFisheye, LensFamily::kRational}) {
    CalibrationOptions tried = options;
    tried.lens = lens;
    try {
      const double error = CrossValidationError(board, views, width_px, height_px, tried);
      choice.error_px.emplace_back(lens, error);
      if (error < kBetter * best) {
        best = error;
        choice.lens = lens;
      }
    } catch (const Error&) {
      continue;  // a family that these views do not fix is no choice
    }
  }
  return choice;
}

CalibrationResult CalibrateCamera(const Board& board, const std::vector<BoardView>& views, int width_px, int height_px,
                                  const CalibrationOptions& options) {
  if (views.size() < kLeastViews)
    throw Fail("the board was given in {}; at least {} are needed, 12 to 25 are good", Counted(views.size(), "view"),
               kLeastViews);
  CheckLens(options);
  Seed seed = SeedOfOpenCv(board, views, {width_px, height_px}, options);
  ceres::LossFunctionWrapper loss(nullptr, ceres::TAKE_OWNERSHIP);
  const auto problem = MakeProblem(board, views, options, &loss, seed.unknowns);

  CalibrationResult result;
  result.seed_rms_px = seed.rms_px;
  result.summary = options.robust ? SolveRobustly(*problem, loss) : Solve(*problem);
  const Unknowns& u = seed.unknowns;
  result.camera = CameraOf(u, options.lens, width_px, height_px);
  for (const auto& pose : u.poses) result.camera_from_board.push_back(PoseOf(pose));

  const std::vector<Eigen::Vector2d> residuals = Residuals(*problem);
  result.sigma_px = SigmaFromMedian(residuals);
  FillResiduals(views, residuals, result);
  const int parameters =
      4 + CoefficientsOf(options.lens) - options.fix_k3 - options.square_pixels + 6 * static_cast<int>(views.size());
  if (result.summary.usable)
    result.covariance = Covariance(*problem, u, options.lens, EffectiveVariance(residuals, loss, parameters));
  return result;
}

CameraUncertainty UncertaintyOf(const CalibrationResult& result) {
  const Eigen::Matrix<double, 9, 1> sd = result.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  CameraUncertainty uncertainty{result.rms_px, sd.head<4>(), {}};
  std::copy_n(sd.data() + 4, 5, uncertainty.distortion_sd.begin());
  return uncertainty;
}

}  // namespace lake::camera
