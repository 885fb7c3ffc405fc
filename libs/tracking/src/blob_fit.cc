#include "lake/tracking/blob_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace lake {
namespace {

// Order of a blob's parameters in the fit; the three of the background follow after the last blob.
enum BlobParameter { kX, kY, kM11, kM12, kM22, kEdge, kAmplitude, kBlobParameters };
constexpr int kBackgroundParameters = 3;

constexpr double kMinRadiusPx = 0.5;
constexpr double kMinEdgePx = 0.3;  // the pixel's own area: sqrt(1/12)
constexpr double kEdgeReach = 2.5;  // in edge widths: where the disc's light has ended

// Phi and its density by linear interpolation in a table; the error, under 1e-5, is far below a grey level.
class NormalTable {
 public:
  NormalTable() {
    for (int i = 0; i < kSize; ++i) {
      const double z = (i - kSize / 2) / kStepsPerUnit;
      cumulative_[i] = 0.5 * std::erfc(-z * M_SQRT1_2);
      density_[i] = std::exp(-0.5 * z * z) * (0.5 * M_2_SQRTPI * M_SQRT1_2);
    }
  }
  struct Value {
    double cumulative, density;
  };
  Value operator()(double z) const {
    const double place = z * kStepsPerUnit + kSize / 2;
    if (place <= 0) return {0, 0};
    if (place >= kSize - 1) return {1, 0};
    const int i = static_cast<int>(place);
    const double t = place - i;
    return {cumulative_[i] + t * (cumulative_[i + 1] - cumulative_[i]), density_[i] + t * (density_[i + 1] - density_[i])};
  }

 private:
  static constexpr double kStepsPerUnit = 128;
  static constexpr int kSize = 2 * 5 * 128 + 1;  // -5 .. 5
  std::array<double, kSize> cumulative_, density_;
};
const NormalTable kNormal;

// Light of one blob of unit amplitude at an offset from its centre, and its derivatives by x, y, m11, m12, m22, edge.
using LightGradient = Eigen::Matrix<double, kAmplitude, 1>;
struct Light {
  double value = 0;
  LightGradient gradient = LightGradient::Zero();
};

void AddStillLight(const Blob& blob, const Eigen::Vector2d& u, double weight, Light& light) {
  const Eigen::Matrix2d& m = blob.unit_circle_from_px;
  const Eigen::Vector2d mu = m * u;
  const double rho = mu.norm();
  if (rho < 1e-9) {
    light.value += weight * kNormal(blob.RadiusPx() / blob.edge_px).cumulative;
    return;
  }
  const Eigen::Vector2d slope = m * mu / rho;  // gradient of |M u|
  const double steepness = slope.norm();
  const double distance = (1 - rho) / steepness;
  const double z = distance / blob.edge_px;
  if (z < -5) return;
  const auto [cumulative, density] = kNormal(z);
  light.value += weight * cumulative;
  if (density < 1e-9) return;
  const double by_rho = -weight * density / (blob.edge_px * steepness);  // exact on the edge, where the light changes
  light.gradient[kX] -= by_rho * slope.x();
  light.gradient[kY] -= by_rho * slope.y();
  light.gradient[kM11] += by_rho * mu.x() * u.x() / rho;
  light.gradient[kM12] += by_rho * (mu.x() * u.y() + mu.y() * u.x()) / rho;
  light.gradient[kM22] += by_rho * mu.y() * u.y() / rho;
  light.gradient[kEdge] -= weight * density * z / blob.edge_px;
}

// Exposure: the midpoint rule; nodes 1.5 edge widths apart leave ripples of 2e-4 of the light.
int ExposureNodes(const Blob& blob) {
  constexpr int kMaxNodes = 24;
  return std::clamp(static_cast<int>(std::ceil(blob.blur_px.norm() / (1.5 * blob.edge_px))), 1, kMaxNodes);
}

Light LightAt(const Blob& blob, int nodes, const Eigen::Vector2d& u) {
  Light light;
  for (int i = 0; i < nodes; ++i)
    AddStillLight(blob, u - ((i + 0.5) / nodes - 0.5) * blob.blur_px, 1.0 / nodes, light);
  return light;
}

// Half the size of the box round the centre outside which the blob sheds no light, widened by a margin.
Eigen::Vector2d HalfExtent(const Blob& blob, double margin_px) {
  const Eigen::Matrix2d shape = (blob.unit_circle_from_px * blob.unit_circle_from_px).inverse();
  return Eigen::Vector2d(std::sqrt(shape(0, 0)), std::sqrt(shape(1, 1))) + 0.5 * blob.blur_px.cwiseAbs() +
         Eigen::Vector2d::Constant(kEdgeReach * blob.edge_px + margin_px);
}

bool IsSane(const Blob& blob, const Blob& start, const cv::Size& size) {
  if (!blob.center.allFinite() || !blob.unit_circle_from_px.allFinite()) return false;
  const double determinant = blob.unit_circle_from_px.determinant();
  if (!(determinant > 0) || blob.unit_circle_from_px.trace() <= 0) return false;
  const double radius = blob.RadiusPx();
  const double reach = std::max(start.RadiusPx(), 2.0) + 0.5 * start.blur_px.norm();
  return radius >= kMinRadiusPx && radius <= 3 * start.RadiusPx() + 1 && blob.amplitude > 0 &&
         (blob.center - start.center).norm() <= reach && blob.center.x() >= 0 && blob.center.y() >= 0 &&
         blob.center.x() <= size.width - 1 && blob.center.y() <= size.height - 1;
}

// The least-squares problem at hand: the pixels of the blobs' surroundings, the blobs and one sloping background. Sizes are known
// when compiling, as most of the time of tracking goes into its sums.
template <int kBlobs>
class JointFit {
 public:
  JointFit(const cv::Mat& grey, std::span<const Blob> starts, const BlobFitOptions& options) : grey_(grey), options_(options) {
    std::copy_n(starts.begin(), kBlobs, starts_.begin());
    blobs_ = starts_;
    origin_.setZero();
    for (const Blob& blob : blobs_) origin_ += blob.center / kBlobs;
    ChoosePixels();
    if (HasEnoughPixels()) StartBackground();
  }

  bool Solve() {
    if (!HasEnoughPixels()) return false;
    double damping = 1e-3;
    double cost = Accumulate();
    for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
      const Vector step = Step(damping);
      const State before = Save();
      Apply(step);
      const Matrix normal_before = normal_;
      const Vector gradient_before = gradient_;
      const double new_cost = AllSane() ? Accumulate() : INFINITY;
      if (new_cost <= cost * (1 + 1e-9)) {
        cost = new_cost;
        damping = std::max(damping * 0.1, 1e-9);
        if (CenterStep(step) < options_.converged_px) return true;
        continue;
      }
      Restore(before);
      normal_ = normal_before, gradient_ = gradient_before;
      if (CenterStep(step) < 0.1 * options_.converged_px) return AllSane();
      damping *= 10;
      if (damping > 1e6) return false;
    }
    return false;
  }

  std::vector<BlobFit> Result() const {
    const Matrix covariance = normal_.ldlt().solve(Matrix::Identity());
    const double freedom = static_cast<double>(pixels_.size()) - kParameters;
    const double chi_square = weighted_square_sum_ / freedom;
    const double residual = std::sqrt(square_sum_ / freedom);
    std::vector<BlobFit> fits;
    for (std::size_t i = 0; i < kBlobs; ++i) {
      const int at = static_cast<int>(i) * kBlobParameters;
      BlobFit fit;
      fit.blob = blobs_[i];
      fit.covariance = covariance.template block<2, 2>(at, at) * chi_square;
      fit.background = background_[0] + background_.template tail<2>().dot(blobs_[i].center - origin_);
      fit.chi_square = chi_square;
      fit.relative_residual = residual / blobs_[i].amplitude;
      fits.push_back(fit);
    }
    return fits;
  }

 private:
  static constexpr int kParameters = kBlobs * kBlobParameters + kBackgroundParameters;
  using Vector = Eigen::Matrix<double, kParameters, 1>;
  using Matrix = Eigen::Matrix<double, kParameters, kParameters>;

  struct State {
    std::array<Blob, kBlobs> blobs;
    Eigen::Vector3d background;
  };
  State Save() const { return {blobs_, background_}; }
  void Restore(const State& state) { blobs_ = state.blobs, background_ = state.background; }
  bool HasEnoughPixels() const { return pixels_.size() > 2 * kParameters; }

  struct Pixel {
    Eigen::Vector2d place;
    double level;
  };

  void ChoosePixels() {
    const cv::Rect picture(0, 0, grey_.cols, grey_.rows);
    for (std::size_t i = 0; i < blobs_.size(); ++i) {
      const Eigen::Vector2d half = HalfExtent(blobs_[i], options_.margin_px);
      const Eigen::Vector2d low = blobs_[i].center - half, high = blobs_[i].center + half;
      const cv::Rect box = cv::Rect(cv::Point(static_cast<int>(std::floor(low.x())), static_cast<int>(std::floor(low.y()))),
                                    cv::Point(static_cast<int>(std::ceil(high.x())) + 1, static_cast<int>(std::ceil(high.y())) + 1)) &
                           picture;
      for (int y = box.y; y < box.y + box.height; ++y)
        for (int x = box.x; x < box.x + box.width; ++x) {
          const Eigen::Vector2d place(x, y);
          if (Surrounds(blobs_[i], place) && !SeenBefore(i, place)) pixels_.push_back({place, double(grey_.at<uchar>(y, x))});
        }
    }
  }

  // Within reach of the streak's light plus the margin.
  bool Surrounds(const Blob& blob, const Eigen::Vector2d& place) const {
    const Eigen::Vector2d u = place - blob.center;
    const double length2 = blob.blur_px.squaredNorm();
    const double tau = length2 > 0 ? std::clamp(u.dot(blob.blur_px) / length2, -0.5, 0.5) : 0;
    const Eigen::Vector2d off = u - tau * blob.blur_px;
    const double rho = (blob.unit_circle_from_px * off).norm();
    if (rho <= 1) return true;
    return (1 - 1 / rho) * off.norm() <= kEdgeReach * blob.edge_px + options_.margin_px;
  }

  bool SeenBefore(std::size_t blob, const Eigen::Vector2d& place) const {
    for (std::size_t i = 0; i < blob; ++i)
      if (Surrounds(blobs_[i], place)) return true;
    return false;
  }

  // Amplitudes and background are linear: solve for them with the starts' geometry. The slope starts level.
  void StartBackground() {
    Eigen::Matrix<double, kBlobs + 1, kBlobs + 1> normal = decltype(normal)::Zero();
    Eigen::Matrix<double, kBlobs + 1, 1> right = decltype(right)::Zero(), row;
    for (const Pixel& pixel : pixels_) {
      for (int i = 0; i < kBlobs; ++i)
        row[i] = LightAt(blobs_[i], ExposureNodes(blobs_[i]), pixel.place - blobs_[i].center).value;
      row[kBlobs] = 1;
      normal += row * row.transpose();
      right += row * pixel.level;
    }
    const auto solution = normal.ldlt().solve(right).eval();
    for (int i = 0; i < kBlobs; ++i) starts_[i].amplitude = blobs_[i].amplitude = std::max(solution[i], 1.0);
    background_ = {solution[kBlobs], 0, 0};
  }

  // Normal equations at the current parameters; returns the robust cost.
  double Accumulate() {
    normal_.setZero();
    gradient_.setZero();
    square_sum_ = weighted_square_sum_ = 0;
    double cost = 0;
    Vector row;
    std::array<int, kBlobs> nodes;
    for (int i = 0; i < kBlobs; ++i) nodes[i] = ExposureNodes(blobs_[i]);
    for (const Pixel& pixel : pixels_) {
      const Eigen::Vector2d off = pixel.place - origin_;
      const double slope = background_.template tail<2>().dot(off);
      double level = background_[0], seen = 1;  // `seen`: how much of the background is not hidden by a blob
      for (int i = 0; i < kBlobs; ++i) {
        const Light light = LightAt(blobs_[i], nodes[i], pixel.place - blobs_[i].center);
        const int at = i * kBlobParameters;
        level += blobs_[i].amplitude * light.value;
        seen -= light.value;
        row.template segment<kAmplitude>(at) = (blobs_[i].amplitude - slope) * light.gradient;
        row[at + kAmplitude] = light.value;
      }
      level += slope * seen;
      if (level >= options_.saturation_level && pixel.level >= options_.saturation_level) continue;
      row[kParameters - 3] = 1;
      row.template tail<2>() = seen * off;
      const double residual = pixel.level - level;
      double weight = 1 / options_.noise.Variance(level);
      const double z = std::abs(residual) * std::sqrt(weight);
      const double huber = options_.huber;
      cost += z <= huber ? z * z : 2 * huber * z - huber * huber;
      square_sum_ += residual * residual;
      if (z > huber) weight *= huber / z;
      weighted_square_sum_ += weight * residual * residual;
      const Vector weighted = weight * row;
      normal_.noalias() += weighted * row.transpose();
      gradient_ += residual * weighted;
    }
    return cost + AddPrior();
  }

  // What is known of the shapes, as further residuals. Their noise is in units of the data's: variance 1.
  double AddPrior() {
    double cost = 0;
    const auto pull = [&](int parameter, double difference, double sd) {
      normal_(parameter, parameter) += 1 / (sd * sd);
      gradient_[parameter] -= difference / (sd * sd);
      cost += difference * difference / (sd * sd);
    };
    for (int i = 0; i < kBlobs; ++i) {
      const Blob &blob = blobs_[i], &start = starts_[i];
      const double axis_sd = options_.shape_freedom / start.RadiusPx(), edge_sd = options_.shape_freedom * start.edge_px;
      const Eigen::Matrix2d off = blob.unit_circle_from_px - start.unit_circle_from_px;
      const int at = i * kBlobParameters;
      pull(at + kM11, off(0, 0), axis_sd);
      pull(at + kM12, off(0, 1), axis_sd);
      pull(at + kM22, off(1, 1), axis_sd);
      pull(at + kEdge, blob.edge_px - start.edge_px, edge_sd);
    }
    const double slope_sd = options_.slope_freedom * starts_.front().amplitude;
    for (int axis = 1; axis <= 2; ++axis) pull(kParameters - kBackgroundParameters + axis, background_[axis], slope_sd);
    return cost;
  }

  Vector Step(double damping) const {
    Matrix damped = normal_;
    damped.diagonal() *= 1 + damping;
    return damped.ldlt().solve(gradient_);
  }

  void Apply(const Vector& step) {
    for (int i = 0; i < kBlobs; ++i) {
      const auto s = step.template segment<kBlobParameters>(i * kBlobParameters);
      Blob& blob = blobs_[i];
      blob.center += s.template segment<2>(kX);
      blob.unit_circle_from_px(0, 0) += s[kM11];
      blob.unit_circle_from_px(0, 1) += s[kM12];
      blob.unit_circle_from_px(1, 0) += s[kM12];
      blob.unit_circle_from_px(1, 1) += s[kM22];
      blob.edge_px = std::max(blob.edge_px + s[kEdge], kMinEdgePx);
      blob.amplitude += s[kAmplitude];
    }
    background_ += step.template tail<3>();
  }

  bool AllSane() const {
    for (int i = 0; i < kBlobs; ++i)
      if (!IsSane(blobs_[i], starts_[i], grey_.size())) return false;
    return true;
  }

  double CenterStep(const Vector& step) const {
    double largest = 0;
    for (int i = 0; i < kBlobs; ++i) largest = std::max(largest, step.template segment<2>(i * kBlobParameters).norm());
    return largest;
  }

  const cv::Mat& grey_;
  const BlobFitOptions& options_;
  std::array<Blob, kBlobs> starts_, blobs_;
  Eigen::Vector2d origin_;
  Eigen::Vector3d background_ = Eigen::Vector3d::Zero();
  std::vector<Pixel> pixels_;
  Matrix normal_;
  Vector gradient_;
  double square_sum_ = 0, weighted_square_sum_ = 0;
};

template <int kBlobs>
std::optional<std::vector<BlobFit>> Fit(const cv::Mat& grey, std::span<const Blob> starts, const BlobFitOptions& options) {
  JointFit<kBlobs> fit(grey, starts, options);
  if (!fit.Solve()) return std::nullopt;
  return fit.Result();
}

}  // namespace

double Blob::RadiusPx() const { return 1 / std::sqrt(std::max(unit_circle_from_px.determinant(), 1e-12)); }

double Blob::AspectRatio() const {
  const Eigen::Vector2d inverse_axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(unit_circle_from_px).eigenvalues();
  return inverse_axes[1] / inverse_axes[0];
}

Blob DiscBlob(const Eigen::Vector2d& center, double radius_px) {
  Blob blob;
  blob.center = center;
  blob.unit_circle_from_px = Eigen::Matrix2d::Identity() / radius_px;
  return blob;
}

double BlobFit::SigmaPx() const { return std::sqrt(0.5 * covariance.trace()); }

std::optional<std::vector<BlobFit>> FitBlobs(const cv::Mat& grey, std::span<const Blob> starts, const BlobFitOptions& options) {
  static_assert(kMaxJointBlobs == 4);
  switch (starts.size()) {
    case 1: return Fit<1>(grey, starts, options);
    case 2: return Fit<2>(grey, starts, options);
    case 3: return Fit<3>(grey, starts, options);
    case 4: return Fit<4>(grey, starts, options);
    default: return std::nullopt;
  }
}

}  // namespace lake
