#include "lake/actuator/robust_slope.h"

#include <cmath>
#include <limits>
#include <vector>

#include "lake/core/statistics.h"

namespace lake {
namespace {

// Means of consecutive groups, at most `most` of them.
std::vector<double> Thinned(std::span<const double> values, std::size_t most) {
  const std::size_t group = (values.size() + most - 1) / most;
  std::vector<double> means;
  for (std::size_t i = 0; i + group <= values.size(); i += group) means.push_back(Mean(values.subspan(i, group)));
  return means;
}

double SumOfSquares(const std::vector<double>& values) {
  const double mean = Mean(values);
  double sum = 0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return sum;
}

}  // namespace

RobustSlope FitRobustSlope(std::span<const double> all_x, std::span<const double> all_y) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  if (all_x.size() < 3) return {kNaN, kNaN, kNaN};
  const std::vector<double> x = Thinned(all_x, kMostSlopePoints), y = Thinned(all_y, kMostSlopePoints);
  std::vector<double> slopes;
  for (std::size_t i = 0; i < x.size(); ++i)
    for (std::size_t j = i + 1; j < x.size(); ++j)
      if (x[j] != x[i]) slopes.push_back((y[j] - y[i]) / (x[j] - x[i]));
  if (slopes.empty()) return {kNaN, kNaN, kNaN};
  RobustSlope fit;
  fit.slope = Median(std::move(slopes));
  std::vector<double> rest;
  for (std::size_t i = 0; i < x.size(); ++i) rest.push_back(y[i] - fit.slope * x[i]);
  fit.intercept = Median(rest);
  fit.standard_error = RobustDeviation(rest) / std::sqrt(SumOfSquares(x));
  return fit;
}

}  // namespace lake
