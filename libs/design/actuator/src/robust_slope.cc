// The slope of a plateau.
#include <algorithm>
#include <cmath>
#include <vector>

#include "lake/actuator/duty_calibration.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"

namespace lake::actuator {
namespace {

// Means of consecutive groups, at most `most` of them.
std::vector<double> Thinned(std::span<const double> values, std::size_t most) {
  const std::size_t group = (values.size() + most - 1) / most;
  std::vector<double> means;
  for (std::size_t i = 0; i + group <= values.size(); i += group) means.push_back(Mean(values.subspan(i, group)));
  return means;
}

// The median of the slopes of all pairs; NaN if all x are one.
double MedianOfPairs(const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<double> slopes;
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t j = i + 1; j < x.size(); ++j)
      if (x[j] != x[i]) slopes.push_back((y[j] - y[i]) / (x[j] - x[i]));
  return Median(std::move(slopes));
}

// The step of the readings, as far as their changes show it: the least change, or the least difference of two changes.
double StepOf(const std::vector<double>& y) {
  std::vector<double> changes = {0};
  for (std::size_t i = 1; i < y.size(); ++i) changes.push_back(std::abs(y[i] - y[i - 1]));
  std::sort(changes.begin(), changes.end());
  const double rounding = 1e-9 * (std::abs(y.front()) + changes.back());  // of a step computed from its neighbours
  double step = changes.back();
  for (std::size_t i = 1; i < changes.size(); ++i)
    if (const double gap = changes[i] - changes[i - 1]; gap > rounding) step = std::min(step, gap);
  return step;
}

// The error is at least that of readings rounded to the step: where a speed is a whole number of steps per reading, the
// residuals say nothing of it.
RobustSlope LeastSquares(const std::vector<double>& x, const std::vector<double>& y, double step) {
  const double mean_x = Mean(x), mean_y = Mean(y);
  double xx = 0, xy = 0, residual = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    xx += (x[i] - mean_x) * (x[i] - mean_x);
    xy += (x[i] - mean_x) * (y[i] - mean_y);
  }
  const double slope = xy / xx;
  for (std::size_t i = 0; i < x.size(); ++i) residual += std::pow(y[i] - mean_y - slope * (x[i] - mean_x), 2);
  const double variance = std::max(residual / static_cast<double>(x.size() - 2), step * step / 12);
  return {slope, std::sqrt(variance / xx)};
}

}  // namespace

RobustSlope FitRobustSlope(std::span<const double> all_x, std::span<const double> all_y) {
  constexpr double kDeviations = 4;
  if (all_x.size() < 3) return {kNaN, kNaN};
  const std::vector<double> x = Thinned(all_x, kMostSlopePoints), y = Thinned(all_y, kMostSlopePoints);
  const double slope = MedianOfPairs(x, y);
  if (std::isnan(slope)) return {kNaN, kNaN};
  std::vector<double> rest, good_x, good_y;
  for (std::size_t i = 0; i < x.size(); ++i) rest.push_back(y[i] - slope * x[i]);
  const double step = StepOf(y), middle = Median(rest), limit = std::max(kDeviations * RobustDeviation(rest), step);
  for (std::size_t i = 0; i < x.size(); ++i)
    if (std::abs(rest[i] - middle) <= limit) {
      good_x.push_back(x[i]);
      good_y.push_back(y[i]);
    }
  return good_x.size() < 3 ? RobustSlope{slope, kNaN} : LeastSquares(good_x, good_y, step);
}

}  // namespace lake::actuator
