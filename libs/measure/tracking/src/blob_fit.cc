#include "lake/tracking/blob_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

namespace lake::tracking {
namespace {

// Order of a blob's parameters in the fit; the three of the background follow after the last blob.
enum BlobParameter { kX, kY, kM11, kM12, kM22, kEdge, kAmplitude, kBlobParameters };
constexpr int kBackgroundParameters = 3;
constexpr int kMostParameters = kMaxJointBlobs * kBlobParameters + kBackgroundParameters;

constexpr double kMinRadiusPx = 0.5;
constexpr double kMinEdgePx = 0.3;  // the pixel's own area: sqrt(1/12)
constexpr double kEdgeReach = 2.5;  // in edge widths: where the disc's light has ended

// Pixels are worked on some at a time, in arrays of fixed size: nothing is allocated, and all stays in the cache.
constexpr int kBlock = 32;
using Pixels = Eigen::Array<float, kBlock, 1>;  // one value per pixel

// Light of blobs of unit amplitude in each pixel, and its derivatives by x, y, m11, m12, m22, edge.
struct Light {
  Pixels value = Pixels::Zero();
  std::array<Pixels, kAmplitude> gradient;

  Light() { gradient.fill(Pixels::Zero()); }
};

// Adds a still blob's light. The edge's profile is the integrated triweight kernel of the same standard deviation:
// within 2 % of the normal distribution function, and a polynomial, so that whole vectors of pixels are evaluated at
// once.
void AddStillLight(const Blob& blob, const Pixels& x, const Pixels& y, float weight, Light& light) {
  constexpr float kReach = 3;  // of the triweight kernel in its standard deviations
  constexpr float kPeak = 35.F / 32, kTiny = 1e-6F;
  const Eigen::Matrix2f m = blob.unit_circle_from_px.cast<float>();
  const float edge = static_cast<float>(blob.edge_px);
  const Pixels mx = m(0, 0) * x + m(0, 1) * y, my = m(0, 1) * x + m(1, 1) * y;
  const Pixels rho = (mx * mx + my * my).sqrt().max(kTiny);
  const Pixels per_rho = rho.inverse();
  const Pixels slope_x = (m(0, 0) * mx + m(0, 1) * my) * per_rho,
               slope_y = (m(0, 1) * mx + m(1, 1) * my) * per_rho;  // of |M u|
  const Pixels per_width = (kReach * edge * (slope_x * slope_x + slope_y * slope_y).sqrt().max(kTiny)).inverse();
  const Pixels t = ((1 - rho) * per_width).max(-1.F).min(1.F);
  const Pixels t2 = t * t;
  light.value += weight * (0.5F + kPeak * t * (1 + t2 * (-1 + t2 * (0.6F - t2 / 7))));
  const Pixels by_t = weight * kPeak * (1 - t2).cube();
  const Pixels by_rho = -by_t * per_width;  // exact on the edge, where the light changes
  const Pixels by_m = by_rho * per_rho;
  light.gradient[kX] -= by_rho * slope_x;
  light.gradient[kY] -= by_rho * slope_y;
  light.gradient[kM11] += by_m * mx * x;
  light.gradient[kM12] += by_m * (mx * y + my * x);
  light.gradient[kM22] += by_m * my * y;
  light.gradient[kEdge] -= by_t * t / edge;
}

// Exposure: the midpoint rule; nodes 1.5 edge widths apart leave ripples of 2e-4 of the light.
int ExposureNodes(const Blob& blob) {
  constexpr int kMaxNodes = 24;
  return std::clamp(static_cast<int>(std::ceil(blob.blur_px.norm() / (1.5 * blob.edge_px))), 1, kMaxNodes);
}

// At pixels given relative to `origin`.
Light LightOf(const Blob& blob, const Eigen::Vector2d& origin, const Pixels& x, const Pixels& y) {
  Light light;
  const int nodes = ExposureNodes(blob);
  for (int i = 0; i < nodes; ++i) {
    const Eigen::Vector2f center = (blob.center - origin + ((i + 0.5) / nodes - 0.5) * blob.blur_px).cast<float>();
    AddStillLight(blob, x - center.x(), y - center.y(), 1.F / static_cast<float>(nodes), light);
  }
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

// Some of a fit's pixels; places relative to its origin. The last block is filled up with pixels that do not count.
struct PixelBlock {
  Pixels x = Pixels::Zero(), y = Pixels::Zero(), level = Pixels::Zero(), counts = Pixels::Zero();
};

// Fits of one blob to four blobs share these, whose sizes are known when running: the compiler takes a quarter of the
// time that it takes for four sizes of everything.
using AnyMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostParameters, kMostParameters>;
using AnyVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostParameters, 1>;

AnyVector SolveNormal(const AnyMatrix& normal, const AnyVector& right) {
  return normal.ldlt().solve(right);
}

AnyMatrix InverseNormal(const AnyMatrix& normal) {
  return normal.ldlt().solve(AnyMatrix::Identity(normal.rows(), normal.cols()));
}

// The least-squares problem at hand: the pixels of the blobs' surroundings, the blobs and one sloping background. Sizes
// are known when compiling, as most of the time of tracking goes into its sums. ceres::TinySolver has no robust loss
// and keeps all pixels' derivatives in double precision: its algebra alone takes 19 µs on 225 pixels and ten parameters
// with a model that costs nothing (nine steps of 2.1 µs), where this takes 23 µs with the model.
template <int kBlobs>
class JointFit {
 public:
  JointFit(const cv::Mat& grey, std::span<const Blob> starts, const BlobFitOptions& options)
      : grey_(grey), options_(options) {
    std::copy_n(starts.begin(), kBlobs, starts_.begin());
    blobs_ = starts_;
    origin_.setZero();
    for (const Blob& blob : blobs_) origin_ += blob.center / kBlobs;
    ChoosePixels();
    if (HasEnoughPixels()) StartBackground();
  }

  bool Solve() {
    if (!HasEnoughPixels()) return false;
    constexpr double kCostRounding = 1e-5;  // pixels are in single precision
    constexpr double kFullStep = 1e-3;      // damping up to which a step is Gauss and Newton's
    // By then a disc's fit takes small steps, or full ones; what still leaps and must be held back is no disc.
    constexpr int kSettled = 8;
    constexpr double kHeldBack = 1e-2;
    double damping = kFullStep;
    double cost = Accumulate(), last_px = INFINITY;
    for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
      const AnyVector step = Step(damping);
      last_px = CenterStep(step);
      if (iteration >= kSettled && last_px > options_.usable_px && damping > kHeldBack) return false;
      const State before = Save();
      Apply(step);
      // A full step as small as this needs no proof that it was downhill.
      if (iteration > 0 && damping <= kFullStep && last_px < options_.converged_px) return AllSane();
      const AnyMatrix normal_before = normal_;
      const AnyVector gradient_before = gradient_;
      const double new_cost = AllSane() ? Accumulate() : INFINITY;
      if (new_cost <= cost * (1 + kCostRounding)) {
        cost = new_cost;
        damping = std::max(damping * 0.1, 1e-9);
        if (last_px < options_.converged_px) return true;
        continue;
      }
      Restore(before);
      normal_ = normal_before, gradient_ = gradient_before;
      if (last_px < 0.1 * options_.converged_px) return AllSane();
      damping *= 10;
      if (damping > 1e6) return false;
    }
    return last_px < options_.usable_px;
  }

  std::vector<BlobFit> Result() const {
    const AnyMatrix covariance = InverseNormal(normal_);
    const double freedom = std::max(counting_ - kParameters, 1.0);
    const double chi_square = weighted_square_sum_ / freedom;
    const double residual = std::sqrt(square_sum_ / freedom);
    std::vector<BlobFit> fits;
    for (std::size_t i = 0; i < kBlobs; ++i) {
      const int at = static_cast<int>(i) * kBlobParameters;
      BlobFit fit;
      fit.blob = blobs_[i];
      fit.covariance = covariance.block<2, 2>(at, at) * chi_square;
      fit.background = background_[0] + background_.tail<2>().dot(blobs_[i].center - origin_);
      fit.chi_square = chi_square;
      fit.relative_residual = residual / blobs_[i].amplitude;
      fits.push_back(fit);
    }
    return fits;
  }

 private:
  static constexpr int kParameters = kBlobs * kBlobParameters + kBackgroundParameters;
  using Rows = std::array<Pixels, kParameters>;  // each pixel's derivatives by the parameters

  struct State {
    std::array<Blob, kBlobs> blobs;
    Eigen::Vector3d background;
  };
  State Save() const { return {blobs_, background_}; }
  void Restore(const State& state) { blobs_ = state.blobs, background_ = state.background; }
  bool HasEnoughPixels() const { return pixels_ > 2 * kParameters; }

  void ChoosePixels() {
    const cv::Rect picture(0, 0, grey_.cols, grey_.rows);
    for (std::size_t i = 0; i < blobs_.size(); ++i) {
      const Eigen::Vector2d half = HalfExtent(blobs_[i], options_.margin_px);
      const Eigen::Vector2d low = blobs_[i].center - half, high = blobs_[i].center + half;
      const cv::Rect box =
          cv::Rect(cv::Point(static_cast<int>(std::floor(low.x())), static_cast<int>(std::floor(low.y()))),
                   cv::Point(static_cast<int>(std::ceil(high.x())) + 1, static_cast<int>(std::ceil(high.y())) + 1)) &
          picture;
      blocks_.reserve(blocks_.size() + static_cast<std::size_t>(box.area() / kBlock + 1));
      for (int y = box.y; y < box.y + box.height; ++y)
        for (int x = box.x; x < box.x + box.width; ++x) {
          const Eigen::Vector2d place(x, y);
          if (Surrounds(blobs_[i], place) && !SeenBefore(i, place)) AddPixel(place - origin_, grey_.at<uchar>(y, x));
        }
    }
  }

  void AddPixel(const Eigen::Vector2d& place, uchar level) {
    const int at = pixels_++ % kBlock;
    if (at == 0) blocks_.emplace_back();
    PixelBlock& block = blocks_.back();
    block.x[at] = static_cast<float>(place.x()), block.y[at] = static_cast<float>(place.y());
    block.level[at] = level;
    block.counts[at] = 1;
    clipped_ |= level >= options_.saturation_level;
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

  // Amplitudes and background are linear: solve for them with the starts' geometry. The slope starts level. What is
  // clipped would make a blob too dark, from where the fit ends beside the best one with a wider edge.
  void StartBackground() {
    AnyVector levels = LinearLevels(clipped_ ? static_cast<float>(options_.saturation_level) : INFINITY);
    if (clipped_ && !(levels.allFinite() && levels.minCoeff() > 0 && levels.sum() >= options_.saturation_level))
      levels = LinearLevels(INFINITY);
    for (int i = 0; i < kBlobs; ++i) starts_[i].amplitude = blobs_[i].amplitude = std::max(levels[i], 1.0);
    background_ = {levels[kBlobs], 0, 0};
  }

  // The blobs' amplitudes and the background, from the pixels below a level.
  AnyVector LinearLevels(float below) const {
    AnyMatrix normal = AnyMatrix::Zero(kBlobs + 1, kBlobs + 1);
    AnyVector right = AnyVector::Zero(kBlobs + 1);
    for (const PixelBlock& block : blocks_) {
      const Pixels counts = (block.level < below).select(block.counts, Pixels::Zero());
      std::array<Pixels, kBlobs + 1> columns;
      for (int i = 0; i < kBlobs; ++i) columns[i] = LightOf(blobs_[i], origin_, block.x, block.y).value * counts;
      columns[kBlobs] = counts;
      for (int i = 0; i <= kBlobs; ++i) {
        right[i] += (columns[i] * block.level).sum();
        for (int k = 0; k <= i; ++k) normal(i, k) += (columns[i] * columns[k]).sum();
      }
    }
    return SolveNormal(normal, right);
  }

  // Normal equations at the current parameters; returns the robust cost.
  double Accumulate() {
    normal_.setZero(kParameters, kParameters), gradient_.setZero(kParameters);
    square_sum_ = weighted_square_sum_ = counting_ = 0;
    double cost = 0;
    for (const PixelBlock& block : blocks_) cost += Accumulate(block);
    return cost + AddPrior();
  }

  double Accumulate(const PixelBlock& block) {
    Rows rows;
    const Eigen::Vector3f background = background_.cast<float>();
    const Pixels slope = background[1] * block.x + background[2] * block.y;
    Pixels level = Pixels::Constant(background[0]);
    Pixels seen = Pixels::Ones();  // how much of the background is not hidden by a blob
    for (int i = 0; i < kBlobs; ++i) {
      const Light light = LightOf(blobs_[i], origin_, block.x, block.y);
      const float amplitude = static_cast<float>(blobs_[i].amplitude);
      level += amplitude * light.value;
      seen -= light.value;
      for (int p = 0; p < kAmplitude; ++p) rows[i * kBlobParameters + p] = (amplitude - slope) * light.gradient[p];
      rows[i * kBlobParameters + kAmplitude] = light.value;
    }
    level += slope * seen;
    rows[kParameters - 3].setOnes();
    rows[kParameters - 2] = seen * block.x;
    rows[kParameters - 1] = seen * block.y;
    return AddSums(block, rows, level);
  }

  // Adds a block's residuals from the model's levels to the normal equations, weighted (Huber), and to the sums of
  // squares; returns their robust cost.
  double AddSums(const PixelBlock& block, const Rows& rows, const Pixels& level) {
    const float saturation = static_cast<float>(options_.saturation_level), huber = static_cast<float>(options_.huber);
    const Pixels residual = block.level - level;
    const Pixels counts = (level >= saturation && block.level >= saturation).select(Pixels::Zero(), block.counts);
    Pixels weight = counts / (static_cast<float>(options_.noise.read_variance) +
                              static_cast<float>(options_.noise.gain) * level.max(0.F));
    const Pixels z = residual.abs() * weight.sqrt();
    const double cost = (z <= huber).select(z * z, 2 * huber * z - huber * huber).sum();
    weight *= (z > huber).select(huber / z.max(1e-6F), Pixels::Ones());
    counting_ += counts.sum();
    square_sum_ += (counts * residual * residual).sum();
    weighted_square_sum_ += (weight * residual * residual).sum();
    for (int p = 0; p < kParameters; ++p) {
      const Pixels weighted = weight * rows[p];
      gradient_[p] += (weighted * residual).sum();
      for (int q = 0; q <= p; ++q) normal_(p, q) += (weighted * rows[q]).sum();
    }
    return cost;
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
      const double axis_sd = options_.shape_freedom / start.RadiusPx(),
                   edge_sd = options_.shape_freedom * start.edge_px;
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

  AnyVector Step(double damping) const {
    AnyMatrix damped = normal_;
    damped.diagonal() *= 1 + damping;
    return SolveNormal(damped, gradient_);
  }

  void Apply(const AnyVector& step) {
    for (int i = 0; i < kBlobs; ++i) {
      const auto s = step.segment<kBlobParameters>(i * kBlobParameters);
      Blob& blob = blobs_[i];
      blob.center += s.segment<2>(kX);
      blob.unit_circle_from_px(0, 0) += s[kM11];
      blob.unit_circle_from_px(0, 1) += s[kM12];
      blob.unit_circle_from_px(1, 0) += s[kM12];
      blob.unit_circle_from_px(1, 1) += s[kM22];
      blob.edge_px = std::max(blob.edge_px + s[kEdge], kMinEdgePx);
      blob.amplitude += s[kAmplitude];
    }
    background_ += step.tail<3>();
  }

  bool AllSane() const {
    for (int i = 0; i < kBlobs; ++i)
      if (!IsSane(blobs_[i], starts_[i], grey_.size())) return false;
    return true;
  }

  double CenterStep(const AnyVector& step) const {
    double largest = 0;
    for (int i = 0; i < kBlobs; ++i) largest = std::max(largest, step.segment<2>(i * kBlobParameters).norm());
    return largest;
  }

  const cv::Mat& grey_;
  const BlobFitOptions& options_;
  std::array<Blob, kBlobs> starts_, blobs_;
  Eigen::Vector2d origin_;
  Eigen::Vector3d background_ = Eigen::Vector3d::Zero();
  std::vector<PixelBlock> blocks_;
  int pixels_ = 0;  // of all blocks
  bool clipped_ = false;
  AnyMatrix normal_;  // its lower triangle
  AnyVector gradient_;
  double square_sum_ = 0, weighted_square_sum_ = 0;
  double counting_ = 0;  // pixels in these sums
};

template <int kBlobs>
std::optional<std::vector<BlobFit>> Fit(const cv::Mat& grey, std::span<const Blob> starts,
                                        const BlobFitOptions& options) {
  JointFit<kBlobs> fit(grey, starts, options);
  if (!fit.Solve()) return std::nullopt;
  return fit.Result();
}

}  // namespace

double Blob::RadiusPx() const {
  return 1 / std::sqrt(std::max(unit_circle_from_px.determinant(), 1e-12));
}

double Blob::ApparentRadiusPx() const {
  constexpr double kLevel = 100;
  if (amplitude <= 2 * kLevel) return RadiusPx();
  return RadiusPx() + edge_px / 1.702 * std::log(amplitude / kLevel - 1);  // the edge as a logistic curve: within 1 %
}

double Blob::AspectRatio() const {
  const Eigen::Matrix2d& m = unit_circle_from_px;  // its eigenvalues are one over the semi-axes
  const double mean = 0.5 * m.trace(), half_difference = std::hypot(0.5 * (m(0, 0) - m(1, 1)), m(0, 1));
  return (mean + half_difference) / (mean - half_difference);
}

Blob DiscBlob(const Eigen::Vector2d& center, double radius_px) {
  Blob blob;
  blob.center = center;
  blob.unit_circle_from_px = Eigen::Matrix2d::Identity() / radius_px;
  return blob;
}

double BlobFit::SigmaPx() const {
  return std::sqrt(0.5 * covariance.trace());
}

std::optional<std::vector<BlobFit>> FitBlobs(const cv::Mat& grey, std::span<const Blob> starts,
                                             const BlobFitOptions& options) {
  static_assert(kMaxJointBlobs == 4);
  switch (starts.size()) {
    case 1:
      return Fit<1>(grey, starts, options);
    case 2:
      return Fit<2>(grey, starts, options);
    case 3:
      return Fit<3>(grey, starts, options);
    case 4:
      return Fit<4>(grey, starts, options);
    default:
      return std::nullopt;
  }
}

}  // namespace lake::tracking
