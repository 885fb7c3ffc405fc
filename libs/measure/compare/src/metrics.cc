#include "lake/compare/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lake/compare/pointwise_error.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"

namespace lake::compare {
namespace {

using Eigen::Vector2d;

template <typename T>
std::vector<T> Select(const std::vector<T>& values, const std::vector<bool>& use) {
  std::vector<T> selected;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (use[i]) selected.push_back(values[i]);
  return selected;
}

double Largest(const std::vector<double>& values) {
  return values.empty() ? kNaN : *std::max_element(values.begin(), values.end());
}

double DirectedHausdorff(const std::vector<Vector2d>& a, const std::vector<Vector2d>& b) {
  double largest = 0;
  for (const Vector2d& point : a) largest = std::max(largest, DistanceToPath(point, b));
  return largest;
}

void ComputeAngleMetrics(const std::vector<double>& human_deg, const std::vector<double>& exo_deg,
                         MisalignmentMetrics& metrics) {
  std::vector<double> difference;
  for (std::size_t i = 0; i < human_deg.size(); ++i) difference.push_back(exo_deg[i] - human_deg[i]);
  metrics.knee_rmse_deg = RootMeanSquare(difference);
  metrics.cmc = CoefficientOfMultipleCorrelation({human_deg, exo_deg});
  metrics.linear_fit = FitLine(human_deg, exo_deg);
}

}  // namespace

double PaperMisalignment(const Vector2d& exo_knee, const Vector2d& human_knee) {
  return std::abs(exo_knee.y() - human_knee.y()) / std::abs(human_knee.y());
}

MisalignmentMetrics ComputeMetrics(const StsCurve& human, const StsCurve& exo, const std::vector<bool>& use) {
  const std::vector<Vector2d> h = Select(human.knee, use), e = Select(exo.knee, use);
  const std::vector<double> shank_mm = Select(ShankLengths(human), use);
  MisalignmentMetrics metrics;
  metrics.samples = static_cast<int>(h.size());
  std::vector<double> distance, relative, paper, closest;
  for (std::size_t i = 0; i < h.size(); ++i) {
    distance.push_back(std::sqrt(SquaredDistance(e[i], h[i])));
    relative.push_back(std::sqrt(SquaredMisalignment(e[i], h[i], shank_mm[i])));
    paper.push_back(PaperMisalignment(e[i], h[i]));
    closest.push_back(DistanceToPath(e[i], h));
  }
  metrics.rms_mm = RootMeanSquare(distance);
  metrics.mean_mm = Mean(distance);
  metrics.max_mm = Largest(distance);
  metrics.p95_mm = Quantile(distance, 0.95);
  metrics.relative_rms = h.empty() ? kNaN : std::sqrt(MeanSquaredMisalignment(e, h, shank_mm));
  metrics.relative_max = Largest(relative);
  metrics.relative_p95 = Quantile(relative, 0.95);
  metrics.relative_paper_rms = RootMeanSquare(paper);
  metrics.relative_paper_max = Largest(paper);
  metrics.closest_point_rms_mm = RootMeanSquare(closest);
  metrics.hausdorff_mm = HausdorffDistance(h, e);
  metrics.frechet_mm = DiscreteFrechetDistance(h, e);
  ComputeAngleMetrics(Select(human.knee_deg, use), Select(exo.knee_deg, use), metrics);
  return metrics;
}

double DistanceToPath(const Vector2d& point, const std::vector<Vector2d>& path) {
  if (path.empty()) return kNaN;
  double least = (point - path.front()).norm();
  for (std::size_t i = 1; i < path.size(); ++i) {
    const Vector2d step = path[i] - path[i - 1];
    const double length2 = step.squaredNorm();
    const double along = length2 > 0 ? std::clamp((point - path[i - 1]).dot(step) / length2, 0.0, 1.0) : 0;
    least = std::min(least, (point - path[i - 1] - along * step).norm());
  }
  return least;
}

double HausdorffDistance(const std::vector<Vector2d>& a, const std::vector<Vector2d>& b) {
  if (a.empty() || b.empty()) return kNaN;
  return std::max(DirectedHausdorff(a, b), DirectedHausdorff(b, a));
}

double DiscreteFrechetDistance(const std::vector<Vector2d>& a, const std::vector<Vector2d>& b) {
  if (a.empty() || b.empty()) return kNaN;
  std::vector<double> above(b.size()), row(b.size());  // the least leash for the pairs up to (i − 1, j) and (i, j)
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < b.size(); ++j) {
      double before = std::numeric_limits<double>::infinity();
      if (i == 0 && j == 0) before = 0;
      if (i > 0) before = above[j];
      if (j > 0) before = std::min(before, row[j - 1]);
      if (i > 0 && j > 0) before = std::min(before, above[j - 1]);
      row[j] = std::max(before, (a[i] - b[j]).norm());
    }
    std::swap(above, row);
  }
  return above.back();
}

double CoefficientOfMultipleCorrelation(const std::vector<std::vector<double>>& curves) {
  const double count = static_cast<double>(curves.size()), samples = static_cast<double>(curves.front().size());
  if (count < 2 || samples < 2) return kNaN;
  double grand = 0;
  for (const auto& curve : curves) grand += Mean(curve) / count;
  double about_frame = 0, about_grand = 0;
  for (std::size_t i = 0; i < curves.front().size(); ++i) {
    double mean = 0;
    for (const auto& curve : curves) mean += curve[i] / count;
    for (const auto& curve : curves) {
      about_frame += std::pow(curve[i] - mean, 2);
      about_grand += std::pow(curve[i] - grand, 2);
    }
  }
  const double square = 1 - (about_frame / (samples * (count - 1))) / (about_grand / (samples * count - 1));
  return square >= 0 ? std::sqrt(square) : kNaN;
}

LinearFit FitLine(const std::vector<double>& x, const std::vector<double>& y) {
  const double mean_x = Mean(x), mean_y = Mean(y);
  double xx = 0, xy = 0, yy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += std::pow(x[i] - mean_x, 2);
    xy += (x[i] - mean_x) * (y[i] - mean_y);
    yy += std::pow(y[i] - mean_y, 2);
  }
  if (!(xx > 0 && yy > 0)) return {kNaN, kNaN, kNaN};
  return {xy / xx, mean_y - xy / xx * mean_x, xy * xy / (xx * yy)};
}

}  // namespace lake::compare
