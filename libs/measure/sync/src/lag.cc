#include "lake/sync/lag.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "lake/core/distributions.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"

namespace lake::sync {
namespace {

using Eigen::Index, Eigen::Matrix2d, Eigen::MatrixXd, Eigen::Vector2d, Eigen::VectorXd;

constexpr Index kStride = 3;  // y's step in x's

// y and x at the times at which both are known.
struct Rows {
  std::vector<Index> row;  // of y
  MatrixXd y, x, slope;    // slope: of x, per s

  Index Count() const { return y.rows(); }
};

Rows RowsAt(const Series& y, const Series& x, const Lag& lag) {
  Rows rows;
  rows.y.resize(y.Rows(), y.value.cols());
  rows.x.resize(y.Rows(), x.value.cols());
  rows.slope = rows.x;
  Eigen::RowVectorXd value, slope;
  Index n = 0;
  for (Index i = 0; i < y.Rows(); ++i) {
    if (!y.known[static_cast<std::size_t>(i)] || !ValuesAt(x, lag.At(y.TimeAt(i)), value, slope)) continue;
    rows.row.push_back(i);
    rows.y.row(n) = y.value.row(i);
    rows.x.row(n) = value;
    rows.slope.row(n++) = slope;
  }
  for (MatrixXd* matrix : {&rows.y, &rows.x, &rows.slope}) matrix->conservativeResize(n, Eigen::NoChange);
  return rows;
}

// y where x is known to either side as well, so that small changes of the offset compare the same times.
Series Inner(const Series& y, const Series& x, const Lag& lag) {
  constexpr double kReach_s = 0.1;
  Series inner = y;
  Eigen::RowVectorXd value, slope;
  for (Index i = 0; i < y.Rows(); ++i)
    for (const double to_s : {-kReach_s, kReach_s})
      if (!ValuesAt(x, lag.At(y.TimeAt(i)) + to_s, value, slope)) inner.known[static_cast<std::size_t>(i)] = 0;
  return inner;
}

// Sums of the products of the columns (1, x, y).
MatrixXd Products(const MatrixXd& x, const MatrixXd& y) {
  MatrixXd columns(x.rows(), 1 + x.cols() + y.cols());
  columns << VectorXd::Ones(x.rows()), x, y;
  return columns.transpose() * columns;
}

// U, from these sums.
double Unexplained(const MatrixXd& products, Index x_columns) {
  const Index p = x_columns + 1, q = products.cols() - p;
  MatrixXd xx = products.topLeftCorner(p, p);
  xx.diagonal() *= 1 + 1e-9;
  const MatrixXd xy = products.topRightCorner(p, q);
  const double square = products.bottomRightCorner(q, q).trace(),
               about_mean = square - xy.row(0).squaredNorm() / products(0, 0),
               about_map = square - xy.cwiseProduct(xx.ldlt().solve(xy)).sum();
  return about_mean > 0 ? std::clamp(about_map / about_mean, 1e-9, 1.0) : 1;
}

// The coarse search: offsets a step of x apart.
struct Search {
  std::vector<double> offset_s, unexplained, overlap_s;
  std::size_t best = 0;

  // Per independent value in a second, over that of no map.
  double Likelihood(std::size_t i) const { return -overlap_s[i] / 2 * std::log(unexplained[i]); }
};

VectorXd Mask(const Series& series) {
  return Eigen::Map<const Eigen::Matrix<unsigned char, Eigen::Dynamic, 1>>(series.known.data(), series.Rows())
      .cast<double>();
}

// Both with a column of ones before, and 0 where not known.
MatrixXd WithOnes(const Series& series) {
  MatrixXd columns(series.Rows(), series.value.cols() + 1);
  columns << VectorXd::Ones(series.Rows()), series.value;
  return Mask(series).asDiagonal() * columns;
}

Search SearchOffsets(const Series& y, const Series& x, const LagOptions& options) {
  constexpr double kLeastShare = 0.2;  // of the movement of one
  const MatrixXd ys = WithOnes(y), xs = WithOnes(x);
  const Index p = xs.cols(), q = ys.cols() - 1;
  const auto variation = [](const MatrixXd& sums) {
    const double n = sums(0, 0);
    return n > 0 ? sums.trace() - n - sums.row(0).tail(sums.cols() - 1).squaredNorm() / n : 0;
  };
  const double y_whole = variation(ys.transpose() * ys), x_whole = variation(xs.transpose() * xs) / kStride;
  Search search;
  for (Index shift = -kStride * (ys.rows() - 1); shift < xs.rows(); ++shift) {
    const double offset_s = x.start_s - y.start_s + static_cast<double>(shift) * x.step_s;
    if (options.reach_s > 0 && std::abs(offset_s) > options.reach_s) continue;
    const Index first = shift < 0 ? (kStride - 1 - shift) / kStride : 0, at = kStride * first + shift,
                n = std::min(ys.rows() - first, (xs.rows() - at + kStride - 1) / kStride);
    const MatrixXd x_now = xs(Eigen::seqN(at, n, kStride), Eigen::all);
    const auto y_now = ys.middleRows(first, n);
    search.offset_s.push_back(offset_s);
    search.unexplained.push_back(1);
    search.overlap_s.push_back(y.step_s * y_now.col(0).dot(x_now.col(0)));
    if (search.overlap_s.back() < options.least_overlap_s) continue;
    const MatrixXd yy = y_now.transpose() * x_now.col(0).asDiagonal() * y_now,
                   xx = x_now.transpose() * y_now.col(0).asDiagonal() * x_now;
    if (variation(yy) < kLeastShare * y_whole && variation(xx) < kLeastShare * x_whole) continue;
    MatrixXd products(p + q, p + q);
    products.topLeftCorner(p, p) = xx;
    products.topRightCorner(p, q) = x_now.transpose() * y_now.rightCols(q);
    products.bottomRightCorner(q, q) = yy.bottomRightCorner(q, q);
    search.unexplained.back() = Unexplained(products, p - 1);
    if (search.Likelihood(search.offset_s.size() - 1) > search.Likelihood(search.best))
      search.best = search.offset_s.size() - 1;
  }
  return search;
}

// The likeliest offset elsewhere.
std::size_t SecondBest(const Search& search) {
  constexpr double kApart_s = 0.3;
  std::size_t second = search.best;
  for (std::size_t i = 1; i + 1 < search.offset_s.size(); ++i) {
    const double likelihood = search.Likelihood(i);
    if (std::abs(search.offset_s[i] - search.offset_s[search.best]) > kApart_s &&
        likelihood >= search.Likelihood(i - 1) && likelihood >= search.Likelihood(i + 1) &&
        (second == search.best || likelihood > search.Likelihood(second)))
      second = i;
  }
  return second;
}

// How many values of a signal in a second are independent of one another (Bartlett 1946): 1 / ∫ ρ(τ)² dτ, of its
// autocorrelation ρ.
double IndependentRateHz(const Rows& rows, double step_s) {
  const MatrixXd y = rows.y.rowwise() - rows.y.colwise().mean();
  double sum = 1;
  for (Index k = 1; k <= rows.Count() / 2; ++k) {
    const double correlation =
        y.topRows(rows.Count() - k).cwiseProduct(y.bottomRows(rows.Count() - k)).sum() / y.squaredNorm();
    sum += 2 * correlation * correlation;
  }
  return 1 / (step_s * sum);
}

// Blocks of as many rows each, none shorter than this: where each begins. Empty where there are fewer than four.
std::vector<Index> Blocks(const Rows& rows, double least_s, double step_s) {
  constexpr Index kFewest = 4, kMost = 20;
  const Index count = std::min(static_cast<Index>(static_cast<double>(rows.Count()) * step_s / least_s), kMost);
  std::vector<Index> begins;
  if (count < kFewest) return begins;
  for (Index b = 0; b < count; ++b) begins.push_back(rows.row[static_cast<std::size_t>(b * rows.Count() / count)]);
  return begins;
}

std::size_t BlockOf(const std::vector<Index>& blocks, Index row) {
  return static_cast<std::size_t>(
      std::max<std::ptrdiff_t>(std::ranges::upper_bound(blocks, row) - blocks.begin() - 1, 0));
}

std::vector<MatrixXd> BlockProducts(const Rows& rows, const std::vector<Index>& blocks) {
  std::vector<MatrixXd> products;
  for (Index first = 0, next = 0; first < rows.Count(); first = next) {
    const std::size_t block = BlockOf(blocks, rows.row[static_cast<std::size_t>(first)]);
    while (next < rows.Count() && BlockOf(blocks, rows.row[static_cast<std::size_t>(next)]) == block) ++next;
    products.push_back(Products(rows.x.middleRows(first, next - first), rows.y.middleRows(first, next - first)));
  }
  return products;
}

// Six places of (offset, drift) in steps, through which one parabola goes, and its least; none where it has no least.
constexpr std::array<std::pair<int, int>, 6> kPlaces = {{{0, 0}, {1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}}};

Vector2d LeastOfParabola(const std::array<double, 6>& u) {
  Matrix2d bend;
  bend(0, 0) = u[1] - 2 * u[0] + u[2];
  bend(1, 1) = u[3] - 2 * u[0] + u[4];
  bend(0, 1) = bend(1, 0) = u[5] - u[1] - u[3] + u[0];
  if (!(bend(0, 0) > 0) || !(bend.determinant() > 0)) return Vector2d::Constant(kNaN);
  return -bend.inverse() * Vector2d((u[1] - u[2]) / 2, (u[3] - u[4]) / 2);
}

// Offset and drift less those of `lag` where U is least: of all blocks, and of all but one each.
struct Estimates {
  Vector2d of_all;
  std::vector<Vector2d> without;
};

Estimates EstimatesNear(const Lag& lag, const Series& y, const Series& x, const std::vector<Index>& blocks) {
  constexpr double kStep_s = 0.01;
  const Vector2d step(kStep_s, 2 * kStep_s / lag.overlap_s);
  std::array<double, 6> all;
  std::vector<std::array<double, 6>> without(blocks.size());
  for (std::size_t k = 0; k < kPlaces.size(); ++k) {
    Lag place = lag;
    place.offset_s += step[0] * kPlaces[k].first;
    place.drift += step[1] * kPlaces[k].second;
    const std::vector<MatrixXd> products = BlockProducts(RowsAt(y, x, place), blocks);
    if (products.size() < blocks.size()) return {Vector2d::Constant(kNaN), {}};
    const MatrixXd sum = std::accumulate(products.begin() + 1, products.end(), products.front());
    all[k] = Unexplained(sum, x.value.cols());
    for (std::size_t b = 0; b < blocks.size(); ++b) without[b][k] = Unexplained(sum - products[b], x.value.cols());
  }
  Estimates estimates{LeastOfParabola(all).cwiseProduct(step), {}};
  for (const auto& u : without) estimates.without.push_back(LeastOfParabola(u).cwiseProduct(step));
  return estimates;
}

Matrix2d JackknifeCovariance(const std::vector<Vector2d>& without) {
  const auto n = static_cast<double>(without.size());
  const Vector2d mean = std::accumulate(without.begin(), without.end(), Vector2d(0, 0)) / n;
  Matrix2d square = Matrix2d::Zero();
  for (const Vector2d& estimate : without) square += (estimate - mean) * (estimate - mean).transpose();
  const double student = StudentQuantile(n - 1, 0.975) / kNormal95;
  return student * student * (n - 1) / n * square;
}

// The estimate with the drift's prior: the product of two normal distributions. False where U has no least.
bool Refine(const Series& y, const Series& x, double drift_sd, const std::vector<Index>& blocks, Lag& lag) {
  constexpr int kMostSteps = 10;
  constexpr double kLongest_s = 0.05, kSettled_s = 1e-7;
  bool has_settled = false;
  for (int i = 0; i < kMostSteps; ++i) {
    const Estimates estimates = EstimatesNear(lag, y, x, blocks);
    if (!estimates.of_all.allFinite()) return false;
    const Matrix2d covariance = JackknifeCovariance(estimates.without);
    has_settled = covariance.allFinite();
    if (!has_settled) {  // still too far from the least for a parabola without each block
      lag.offset_s += std::clamp(estimates.of_all[0], -kLongest_s, kLongest_s);
      continue;
    }
    lag.free_drift = lag.drift + estimates.of_all[1];
    const double variance = covariance(1, 1) + drift_sd * drift_sd;
    lag.free_drift_deviations = variance > 0 ? std::abs(lag.free_drift) / std::sqrt(variance) : 0;
    const Vector2d gain = variance > 0 ? Vector2d(covariance.col(1) / variance) : Vector2d(0, 0);
    const Vector2d change = estimates.of_all - gain * lag.free_drift;
    lag.covariance = covariance - gain * covariance.row(1);
    lag.offset_s += std::clamp(change[0], -kLongest_s, kLongest_s);
    lag.drift += change[1];
    if (std::abs(change[0]) < kSettled_s) break;
  }
  return has_settled;
}

// Each block's own offset, and whether these differ by more than noise. The noise is measured by how much y's size
// varies from block to block: of one movement it varies as much as the offset, of two that are alike it varies less, as
// these differ in their times. False if they do.
bool CompareBlocks(const Rows& rows, const Series& y, const std::vector<Index>& blocks, double tolerance_s, Lag& lag) {
  const MatrixXd x = rows.x.rowwise() - rows.x.colwise().mean(), y_about = rows.y.rowwise() - rows.y.colwise().mean();
  const MatrixXd map = x.colPivHouseholderQr().solve(y_about);
  const MatrixXd predicted = x * map, residual = y_about - predicted, slope = rows.slope * map;
  const auto count = static_cast<Index>(blocks.size());
  // By block and column: of y's size and its offset, the weighted sums and the weights.
  MatrixXd size = MatrixXd::Zero(count, y_about.cols()), size_weight = size, late = size, late_weight = size;
  for (Index i = 0; i < rows.Count(); ++i) {
    const auto b = static_cast<Index>(BlockOf(blocks, rows.row[static_cast<std::size_t>(i)]));
    size.row(b) += residual.row(i).cwiseProduct(predicted.row(i));
    size_weight.row(b) += predicted.row(i).cwiseAbs2();
    late.row(b) += residual.row(i).cwiseProduct(slope.row(i));
    late_weight.row(b) += slope.row(i).cwiseAbs2();
  }
  const Eigen::RowVectorXd share = late_weight.colwise().sum() / late_weight.sum();
  const double noise = (size.cwiseAbs2().array() / size_weight.array().max(1e-12 * size_weight.sum()))
                           .matrix()
                           .colwise()
                           .sum()
                           .dot(share) /
                       static_cast<double>(count - 1);
  const VectorXd weight = late_weight.rowwise().sum().cwiseMax(1e-12 * late_weight.sum()),
                 of_block = late.rowwise().sum().cwiseQuotient(weight);
  constexpr double kLeastShare = 0.1;  // of what a block has on average, else it says nothing of its own
  for (Index b = 0; b < count; ++b) {
    const Index first = blocks[static_cast<std::size_t>(b)],
                last = b + 1 < count ? blocks[static_cast<std::size_t>(b + 1)] : rows.row.back();
    if (weight[b] > kLeastShare * weight.mean())
      lag.blocks.push_back({(y.TimeAt(first) + y.TimeAt(last)) / 2, of_block[b], std::sqrt(noise / weight[b])});
  }
  const double scatter =
      weight.dot(of_block.cwiseAbs2()) / weight.sum() * static_cast<double>(count) / static_cast<double>(count - 1);
  constexpr double kFactor = 1.4;
  return scatter < kFactor * kFactor * (noise / weight.mean() + tolerance_s * tolerance_s);
}

void Show(const Rows& rows, const Series& y, Lag& lag) {
  const MatrixXd products = Products(rows.x, rows.y);
  const Index p = rows.x.cols() + 1;
  const VectorXd map = products.topLeftCorner(p, p).ldlt().solve(products.col(p).head(p));
  const VectorXd predicted = (rows.x * map.tail(p - 1)).array() + map[0];
  for (Index i = 0; i < rows.Count(); ++i) {
    const auto at = static_cast<std::size_t>(i);
    const bool follows = i == 0 || rows.row[at] == rows.row[at - 1] + 1;
    lag.time_s.push_back(y.TimeAt(rows.row[at]));
    lag.measured.push_back(follows ? rows.y(i, 0) : kNaN);
    lag.predicted.push_back(follows ? predicted[i] : kNaN);
  }
}

}  // namespace

double Lag::LargestSdS() const {
  const double half_s = overlap_s / 2;
  return std::sqrt(covariance(0, 0) + 2 * half_s * std::abs(covariance(0, 1)) + half_s * half_s * covariance(1, 1));
}

Lag FindLag(const Series& y_whole, const Series& x, const LagOptions& options) {
  Series y = Thinned(y_whole, kStride);
  const Search search = SearchOffsets(y, x, options);
  Lag lag{.refusal = LagRefusal::kTooShort};
  if (search.offset_s.empty() || !(search.Likelihood(search.best) > 0)) return lag;
  lag.offset_s = search.offset_s[search.best];
  lag.unexplained = search.unexplained[search.best];
  y = Inner(y, x, lag);
  Rows rows = RowsAt(y, x, lag);
  if (rows.row.empty()) return lag;
  const double first_s = y.TimeAt(rows.row.front()), last_s = y.TimeAt(rows.row.back());
  lag.from_s = (first_s + last_s) / 2;
  lag.overlap_s = last_s - first_s;
  const double rate_hz = IndependentRateHz(rows, y.step_s);
  const std::vector<Index> blocks = Blocks(rows, 1 / rate_hz, y.step_s);
  if (blocks.empty() || !Refine(y, x, options.drift_sd, blocks, lag)) return lag;

  rows = RowsAt(y, x, lag);
  lag.unexplained = Unexplained(Products(rows.x, rows.y), rows.x.cols());
  Show(rows, y, lag);
  lag.search_s = search.offset_s;
  for (std::size_t i = 0; i < search.offset_s.size(); ++i) lag.log_likelihood.push_back(rate_hz * search.Likelihood(i));
  const std::size_t second = SecondBest(search);
  lag.second_s = search.offset_s[second];
  const double odds =
      -rate_hz * search.overlap_s[search.best] / 2 * std::log(lag.unexplained) - lag.log_likelihood[second];
  const bool is_one_movement = CompareBlocks(rows, y, blocks, options.tolerance_s, lag);
  constexpr double kMostUnexplained = 0.3, kLeastOdds = 3, kDriftDeviations = 4;  // odds: a logarithm
  if (lag.unexplained > kMostUnexplained)
    lag.refusal = LagRefusal::kUnexplained;
  else if (second != search.best && odds < kLeastOdds)
    lag.refusal = LagRefusal::kAnother;
  else if (options.drift_sd > 0 && lag.free_drift_deviations > kDriftDeviations)
    lag.refusal = LagRefusal::kDrift;
  else if (!is_one_movement)
    lag.refusal = LagRefusal::kContradiction;
  else if (lag.LargestSdS() > options.most_sd_s)
    lag.refusal = LagRefusal::kUncertain;
  else
    lag.refusal = LagRefusal::kNone;
  return lag;
}

}  // namespace lake::sync
