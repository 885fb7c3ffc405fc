#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "lake/compare/metrics.h"
#include "lake/core/statistics.h"

namespace lake::compare {
namespace {

double Square(double value) {
  return value * value;
}

// (1 − u²)² inside −1..1
double Bisquare(double u) {
  return std::abs(u) < 1 ? Square(1 - u * u) : 0;
}

// The value at `at` of the parabola that fits its neighbours, weighted by nearness and trust.
double LocalQuadratic(const std::vector<double>& values, const std::vector<double>& trust, int at, int half_window) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  const int last = static_cast<int>(values.size()) - 1;
  for (int i = std::max(0, at - half_window); i <= std::min(last, at + half_window); ++i) {
    const double u = static_cast<double>(i - at) / (half_window + 1);
    const double nearness = std::pow(1 - std::pow(std::abs(u), 3), 3);
    const double weight = nearness * trust[static_cast<std::size_t>(i)];
    const Eigen::Vector3d basis(1, u, u * u);
    normal += weight * basis * basis.transpose();
    right += weight * values[static_cast<std::size_t>(i)] * basis;
  }
  normal += 1e-9 * Eigen::Matrix3d::Identity();  // a window that is trusted nowhere
  return normal.ldlt().solve(right)[0];
}

// What is left of the values after smoothing. Residuals well below `harmless` keep their weight: else curves without
// noise, whose rests leave nothing, would lose all trust in their motion.
std::vector<double> SmoothingResidual(const std::vector<double>& values, int half_window, double harmless) {
  constexpr int kRounds = 6;  // of robust reweighting: a spike loses its pull on the smooth course
  std::vector<double> trust(values.size(), 1), residual(values.size());
  for (int round = 0; round < kRounds; ++round) {
    std::vector<double> sizes;
    for (std::size_t i = 0; i < values.size(); ++i) {
      residual[i] = values[i] - LocalQuadratic(values, trust, static_cast<int>(i), half_window);
      sizes.push_back(std::abs(residual[i]));
    }
    const double scale = std::max(6 * Median(sizes), 2 * harmless);
    for (std::size_t i = 0; i < values.size(); ++i) trust[i] = Bisquare(residual[i] / scale);
  }
  return residual;
}

}  // namespace

std::vector<bool> FindSpikes(const StsCurve& human, const StsCurve& exo, const SpikeOptions& options) {
  std::vector<bool> spike(human.knee.size(), false);
  for (int axis = 0; axis < 2; ++axis) {
    std::vector<double> difference;
    for (std::size_t i = 0; i < human.knee.size(); ++i) difference.push_back((exo.knee[i] - human.knee[i])[axis]);
    const std::vector<double> residual = SmoothingResidual(difference, options.half_window, options.least_mm);
    const double median = Median(residual);
    std::vector<double> distances;
    for (const double r : residual) distances.push_back(std::abs(r - median));
    const double limit = std::max(options.deviations * Median(distances), options.least_mm);
    for (std::size_t i = 0; i < residual.size(); ++i)
      if (distances[i] > limit) spike[i] = true;
  }
  return spike;
}

}  // namespace lake::compare
