#include "lake/tracking/blob_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "blob_light.h"
#include "lake/core/wide_vectors.h"

namespace lake::tracking {
namespace {

// Those of the background follow after the last blob's.
constexpr int kBackgroundParameters = 3;
constexpr int kMostParameters = kMaxJointBlobs * kBlobParameters + kBackgroundParameters;
static_assert(kMostParameters == kMostRows);

constexpr double kMinRadiusPx = 0.5;
constexpr double kMinEdgePx = 0.3;  // the pixel's own area: sqrt(1/12)
constexpr double kEdgeReach = 2.5;  // in edge widths: where the disc's light has ended

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
  Pixels x, y, level, counts;
};

// The model's levels of a block's pixels, and their derivatives by the parameters.
struct Model {
  Pixels level, seen;  // seen: how much of the background is not hidden by a blob
  Pixels slope;        // of the background, over its level at the origin
  std::array<Pixels, kMostParameters> rows;
};

LAKE_WIDE_VECTORS void StartModel(const PixelBlock& block, float background, float by_x, float by_y, Model& model) {
  for (std::size_t i = 0; i < kBlock; ++i) {
    model.level.at[i] = background;
    model.seen.at[i] = 1;
    model.slope.at[i] = by_x * block.x.at[i] + by_y * block.y.at[i];
  }
}

LAKE_WIDE_VECTORS void AddBlob(const Light& light, float amplitude, bool is_streak_free, std::size_t row,
                               Model& model) {
  for (std::size_t i = 0; i < kBlock; ++i) {
    model.level.at[i] += amplitude * light.value.at[i];
    model.seen.at[i] -= light.value.at[i];
    model.rows[row + kAmplitude].at[i] = light.value.at[i];
  }
  for (std::size_t p = 0; p < kAmplitude; ++p)
    for (std::size_t i = 0; i < kBlock; ++i)
      model.rows[row + p].at[i] = (amplitude - model.slope.at[i]) * light.gradient[p].at[i];
  for (std::size_t axis = 0; axis < 2 && is_streak_free; ++axis)
    for (std::size_t i = 0; i < kBlock; ++i)
      model.rows[row + kBlurX + axis].at[i] = (amplitude - model.slope.at[i]) * light.by_blur[axis].at[i];
}

LAKE_WIDE_VECTORS void AddBackground(const PixelBlock& block, std::size_t row, Model& model) {
  for (std::size_t i = 0; i < kBlock; ++i) {
    model.level.at[i] += model.slope.at[i] * model.seen.at[i];
    model.rows[row].at[i] = 1;
    model.rows[row + 1].at[i] = model.seen.at[i] * block.x.at[i];
    model.rows[row + 2].at[i] = model.seen.at[i] * block.y.at[i];
  }
}

struct Weighting {
  float saturation, huber, read_variance, gain;
};

// Of a block's pixels. What is clipped does not count where the model is as bright.
struct Residuals {
  Pixels value, weight, counts, cost, square, weighted_square;
};

LAKE_WIDE_VECTORS void WeighResiduals(const PixelBlock& block, const Pixels& level, const Weighting& weighting,
                                      Residuals& residuals) {
  const auto [saturation, huber, read_variance, gain] = weighting;
  for (std::size_t i = 0; i < kBlock; ++i) {
    const float value = block.level.at[i] - level.at[i];
    const float counts = std::min(level.at[i], block.level.at[i]) >= saturation ? 0 : block.counts.at[i];
    const float plain = counts / (read_variance + gain * std::max(level.at[i], 0.F));
    const float z = std::abs(value) * std::sqrt(plain);
    const float weight = plain * (huber / std::max(z, huber));
    residuals.value.at[i] = value;
    residuals.weight.at[i] = weight;
    residuals.counts.at[i] = counts;
    residuals.cost.at[i] = z <= huber ? z * z : 2 * huber * z - huber * huber;
    residuals.square.at[i] = counts * value * value;
    residuals.weighted_square.at[i] = weight * value * value;
  }
}

struct ResidualSums {
  LaneSum counts = {}, cost = {}, square = {}, weighted_square = {};

  void Add(const Residuals& residuals) {
    AddSum(residuals.counts, counts);
    AddSum(residuals.cost, cost);
    AddSum(residuals.square, square);
    AddSum(residuals.weighted_square, weighted_square);
  }
};

// Marks the pixels x = first_x, first_x + 1, … of a row that lie within the streak or nearer to it than `reach_px`.
LAKE_WIDE_VECTORS void MarkSurroundings(const Blob& blob, double reach_px, int first_x, int y, std::size_t count,
                                        std::uint8_t* marks) {
  const double x0 = blob.center.x(), dy = y - blob.center.y();
  const double m11 = blob.unit_circle_from_px(0, 0), m12 = blob.unit_circle_from_px(0, 1),
               m22 = blob.unit_circle_from_px(1, 1);
  const double blur_x = blob.blur_px.x(), blur_y = blob.blur_px.y();
  const double length2 = blur_x * blur_x + blur_y * blur_y;
  const double per_length2 = length2 > 0 ? 1 / length2 : 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double dx = first_x + static_cast<int>(i) - x0;
    const double along = std::min(std::max((dx * blur_x + dy * blur_y) * per_length2, -0.5), 0.5);
    const double off_x = dx - along * blur_x, off_y = dy - along * blur_y;
    const double mx = m11 * off_x + m12 * off_y, my = m12 * off_x + m22 * off_y;
    const double rho = std::sqrt(mx * mx + my * my), off_px = std::sqrt(off_x * off_x + off_y * off_y);
    marks[i] = (rho - 1) * off_px <= reach_px * rho;
  }
}

// Of one blob or of some, which is known when running.
using AnyMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostParameters, kMostParameters>;
using AnyVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostParameters, 1>;

AnyVector SolveNormal(const AnyMatrix& normal, const AnyVector& right) {
  return normal.ldlt().solve(right);
}

AnyMatrix InverseNormal(const AnyMatrix& normal) {
  return normal.ldlt().solve(AnyMatrix::Identity(normal.rows(), normal.cols()));
}

// The least-squares problem at hand: the pixels of the blobs' surroundings, the blobs and one sloping background. Most
// of the time of tracking goes into its sums. ceres::TinySolver has no robust loss and keeps all pixels' derivatives in
// double precision: its algebra alone takes 19 µs on 225 pixels and ten parameters with a model that costs nothing
// (nine steps of 2.1 µs), where this takes 14 µs with the model.
class JointFit {
 public:
  JointFit(const cv::Mat& grey, std::span<const Blob> starts, const BlobFitOptions& options)
      : grey_(grey),
        options_(options),
        weighting_{static_cast<float>(options.saturation_level), static_cast<float>(options.huber),
                   static_cast<float>(options.noise.read_variance), static_cast<float>(options.noise.gain)},
        starts_(starts.begin(), starts.end()),
        blobs_(starts_),
        is_streak_free_(options.streak_freedom_px > 0),
        each_(is_streak_free_ ? kBlobParameters : kBlurX),
        parameters_(static_cast<int>(starts.size()) * each_ + kBackgroundParameters) {
    origin_.setZero();
    for (const Blob& blob : blobs_) origin_ += blob.center / static_cast<double>(blobs_.size());
    ChoosePixels();
    if (HasEnoughPixels()) StartBackground();
  }

  // A background that is not even pulls a blob that lies at the side of its pixels: where it is found farther than this
  // from their middle, it is fitted again with those round itself.
  bool SolveAround() {
    constexpr double kAside_px = 0.3;
    constexpr int kMost = 3;  // times
    bool is_aside = true;
    for (int round = 0; round <= kMost && is_aside; ++round) {
      if (round > 0) ChoosePixels();
      const std::vector<Blob> before = blobs_;
      if (!Solve()) return false;
      is_aside = false;
      for (std::size_t i = 0; i < blobs_.size(); ++i)
        is_aside |= (blobs_[i].center - before[i].center).norm() > kAside_px;
    }
    return true;
  }

  std::vector<BlobFit> Result() const {
    const AnyMatrix covariance = InverseNormal(normal_);
    const double freedom = std::max(counting_ - parameters_, 1.0);
    const double chi_square = weighted_square_sum_ / freedom;
    const double residual = std::sqrt(square_sum_ / freedom);
    std::vector<BlobFit> fits;
    for (std::size_t i = 0; i < blobs_.size(); ++i) {
      const int at = static_cast<int>(i) * each_;
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
      normal_ = normal_before;
      gradient_ = gradient_before;
      if (last_px < 0.1 * options_.converged_px) return AllSane();
      damping *= 10;
      if (damping > 1e6) return false;
    }
    return last_px < options_.usable_px;
  }

  struct State {
    std::vector<Blob> blobs;
    Eigen::Vector3d background;
  };
  State Save() const { return {blobs_, background_}; }
  void Restore(const State& state) {
    blobs_ = state.blobs;
    background_ = state.background;
  }
  bool HasEnoughPixels() const { return pixels_ > 2 * static_cast<std::size_t>(parameters_); }
  int Blobs() const { return static_cast<int>(blobs_.size()); }

  // A longer streak than is given goes on at both ends.
  double MarginPx() const { return options_.margin_px + 0.5 * options_.streak_freedom_px; }

  // Within reach of each blob's light plus the margin, each pixel once.
  void ChoosePixels() {
    const cv::Rect picture(0, 0, grey_.cols, grey_.rows);
    std::vector<std::uint8_t> marks, marks_of_others;
    blocks_.clear();
    pixels_ = 0;
    for (std::size_t i = 0; i < blobs_.size(); ++i) {
      const Eigen::Vector2d half = HalfExtent(blobs_[i], MarginPx());
      const Eigen::Vector2d low = blobs_[i].center - half, high = blobs_[i].center + half;
      const cv::Rect box =
          cv::Rect(cv::Point(static_cast<int>(std::floor(low.x())), static_cast<int>(std::floor(low.y()))),
                   cv::Point(static_cast<int>(std::ceil(high.x())) + 1, static_cast<int>(std::ceil(high.y())) + 1)) &
          picture;
      blocks_.reserve(blocks_.size() + static_cast<std::size_t>(box.area()) / kBlock + 1);
      const auto width = static_cast<std::size_t>(box.width);
      marks.resize(width);
      marks_of_others.resize(width);
      for (int y = box.y; y < box.y + box.height; ++y) {
        Mark(blobs_[i], box.x, y, marks);
        for (std::size_t other = 0; other < i; ++other) {
          Mark(blobs_[other], box.x, y, marks_of_others);
          for (std::size_t x = 0; x < width; ++x) marks[x] &= !marks_of_others[x];
        }
        const uchar* const levels = grey_.ptr(y) + box.x;
        for (std::size_t x = 0; x < width; ++x)
          if (marks[x]) AddPixel(Eigen::Vector2d(box.x + static_cast<int>(x), y) - origin_, levels[x]);
      }
    }
  }

  void Mark(const Blob& blob, int first_x, int y, std::vector<std::uint8_t>& marks) const {
    MarkSurroundings(blob, kEdgeReach * blob.edge_px + MarginPx(), first_x, y, marks.size(), marks.data());
  }

  void AddPixel(const Eigen::Vector2d& place, uchar level) {
    const auto at = pixels_++ % kBlock;
    if (at == 0) blocks_.push_back({});
    PixelBlock& block = blocks_.back();
    block.x.at[at] = static_cast<float>(place.x());
    block.y.at[at] = static_cast<float>(place.y());
    block.level.at[at] = level;
    block.counts.at[at] = 1;
    clipped_ |= level >= options_.saturation_level;
  }

  // Amplitudes and background are linear: solve for them with the starts' geometry. The slope starts level. What is
  // clipped would make a blob too dark, from where the fit ends beside the best one with a wider edge.
  void StartBackground() {
    AnyVector levels = LinearLevels(clipped_ ? static_cast<float>(options_.saturation_level) : INFINITY);
    if (clipped_ && !(levels.allFinite() && levels.minCoeff() > 0 && levels.sum() >= options_.saturation_level))
      levels = LinearLevels(INFINITY);
    for (std::size_t i = 0; i < blobs_.size(); ++i)
      starts_[i].amplitude = blobs_[i].amplitude = std::max(levels[static_cast<int>(i)], 1.0);
    background_ = {levels[Blobs()], 0, 0};
  }

  // The blobs' amplitudes and the background, from the pixels below a level.
  AnyVector LinearLevels(float below) const {
    const std::size_t unknowns = blobs_.size() + 1;
    std::array<Pixels, kMaxJointBlobs + 1> columns;
    columns[blobs_.size()].at.fill(1);
    NormalSums sums(unknowns);
    for (const PixelBlock& block : blocks_) {
      for (std::size_t i = 0; i < blobs_.size(); ++i) {
        Light light;
        ComputeLight(blobs_[i], origin_, block.x, block.y, false, light);
        columns[i] = light.value;
      }
      Pixels counts;
      for (std::size_t i = 0; i < kBlock; ++i) counts.at[i] = block.level.at[i] < below ? block.counts.at[i] : 0;
      sums.Add(counts, block.level, std::span(columns).first(unknowns));
    }
    AnyMatrix normal = AnyMatrix::Zero(Blobs() + 1, Blobs() + 1);
    AnyVector right = AnyVector::Zero(Blobs() + 1);
    sums.AddTo(normal, right);
    return SolveNormal(normal, right);
  }

  // Normal equations at the current parameters; returns the robust cost.
  double Accumulate() {
    normal_.setZero(parameters_, parameters_);
    gradient_.setZero(parameters_);
    square_sum_ = weighted_square_sum_ = counting_ = 0;
    double cost = 0;
    constexpr std::size_t kAtOnce = 16;  // blocks, 512 pixels, in sums of single precision
    for (std::size_t first = 0; first < blocks_.size(); first += kAtOnce)
      cost += Accumulate(std::span(blocks_).subspan(first, std::min(kAtOnce, blocks_.size() - first)));
    return cost + AddPrior();
  }

  double Accumulate(std::span<const PixelBlock> blocks) {
    const auto parameters = static_cast<std::size_t>(parameters_);
    NormalSums sums(parameters);
    ResidualSums residual_sums;
    for (const PixelBlock& block : blocks) {
      Model model;
      ComputeModel(block, model);
      Residuals residuals;
      WeighResiduals(block, model.level, weighting_, residuals);
      sums.Add(residuals.weight, residuals.value, std::span(model.rows).first(parameters));
      residual_sums.Add(residuals);
    }
    sums.AddTo(normal_, gradient_);
    counting_ += residual_sums.counts.Total();
    square_sum_ += residual_sums.square.Total();
    weighted_square_sum_ += residual_sums.weighted_square.Total();
    return residual_sums.cost.Total();
  }

  void ComputeModel(const PixelBlock& block, Model& model) const {
    const Eigen::Vector3f background = background_.cast<float>();
    StartModel(block, background[0], background[1], background[2], model);
    std::size_t row = 0;
    for (const Blob& blob : blobs_) {
      Light light;
      ComputeLight(blob, origin_, block.x, block.y, is_streak_free_, light);
      AddBlob(light, static_cast<float>(blob.amplitude), is_streak_free_, row, model);
      row += static_cast<std::size_t>(each_);
    }
    AddBackground(block, row, model);
  }

  // What is known of the shapes, as further residuals. Their noise is in units of the data's: variance 1.
  double AddPrior() {
    double cost = 0;
    const auto pull = [&](int parameter, double difference, double sd) {
      normal_(parameter, parameter) += 1 / (sd * sd);
      gradient_[parameter] -= difference / (sd * sd);
      cost += difference * difference / (sd * sd);
    };
    for (std::size_t i = 0; i < blobs_.size(); ++i) {
      const Blob &blob = blobs_[i], &start = starts_[i];
      const double axis_sd = options_.shape_freedom / start.RadiusPx(),
                   edge_sd = options_.shape_freedom * start.edge_px;
      const Eigen::Matrix2d off = blob.unit_circle_from_px - start.unit_circle_from_px;
      const int at = static_cast<int>(i) * each_;
      pull(at + kM11, off(0, 0), axis_sd);
      pull(at + kM12, off(0, 1), axis_sd);
      pull(at + kM22, off(1, 1), axis_sd);
      pull(at + kEdge, blob.edge_px - start.edge_px, edge_sd);
      for (int axis = 0; axis < 2 && is_streak_free_; ++axis)
        pull(at + kBlurX + axis, blob.blur_px[axis] - start.blur_px[axis], options_.streak_freedom_px);
    }
    const double slope_sd = options_.slope_freedom * starts_.front().amplitude;
    for (int axis = 1; axis <= 2; ++axis) pull(parameters_ - kBackgroundParameters + axis, background_[axis], slope_sd);
    return cost;
  }

  AnyVector Step(double damping) const {
    AnyMatrix damped = normal_;
    damped.diagonal() *= 1 + damping;
    return SolveNormal(damped, gradient_);
  }

  void Apply(const AnyVector& step) {
    for (std::size_t i = 0; i < blobs_.size(); ++i) {
      const auto s = step.segment(static_cast<Eigen::Index>(i) * each_, each_);
      Blob& blob = blobs_[i];
      blob.center += s.segment<2>(kX);
      blob.unit_circle_from_px(0, 0) += s[kM11];
      blob.unit_circle_from_px(0, 1) += s[kM12];
      blob.unit_circle_from_px(1, 0) += s[kM12];
      blob.unit_circle_from_px(1, 1) += s[kM22];
      blob.edge_px = std::max(blob.edge_px + s[kEdge], kMinEdgePx);
      blob.amplitude += s[kAmplitude];
      if (is_streak_free_) blob.blur_px += s.segment<2>(kBlurX);
    }
    background_ += step.tail<3>();
  }

  bool AllSane() const {
    for (std::size_t i = 0; i < blobs_.size(); ++i)
      if (!IsSane(blobs_[i], starts_[i], grey_.size())) return false;
    return true;
  }

  double CenterStep(const AnyVector& step) const {
    double largest = 0;
    for (Eigen::Index at = 0; at + kBackgroundParameters < step.size(); at += each_)
      largest = std::max(largest, step.segment<2>(at).norm());
    return largest;
  }

  const cv::Mat& grey_;
  const BlobFitOptions& options_;
  const Weighting weighting_;
  std::vector<Blob> starts_, blobs_;
  const bool is_streak_free_;
  const int each_;  // parameters of a blob
  const int parameters_;
  Eigen::Vector2d origin_;
  Eigen::Vector3d background_ = Eigen::Vector3d::Zero();
  std::vector<PixelBlock> blocks_;
  std::size_t pixels_ = 0;  // of all blocks
  bool clipped_ = false;
  AnyMatrix normal_;  // its lower triangle
  AnyVector gradient_;
  double square_sum_ = 0, weighted_square_sum_ = 0;
  double counting_ = 0;  // pixels in these sums
};

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
  if (starts.empty() || starts.size() > kMaxJointBlobs) return std::nullopt;
  JointFit fit(grey, starts, options);
  if (!fit.SolveAround()) return std::nullopt;
  return fit.Result();
}

}  // namespace lake::tracking
