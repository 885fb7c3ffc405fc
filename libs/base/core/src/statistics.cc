#include "lake/core/statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "lake/core/numbers.h"

namespace lake {
double Mean(std::span<const double> values) {
  if (values.empty()) return kNaN;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double StandardDeviation(std::span<const double> values) {
  if (values.size() < 2) return kNaN;
  const double mean = Mean(values);
  double sum = 0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

double RootMeanSquare(std::span<const double> values) {
  if (values.empty()) return kNaN;
  return std::sqrt(std::inner_product(values.begin(), values.end(), values.begin(), 0.0) /
                   static_cast<double>(values.size()));
}

double Quantile(std::vector<double> values, double fraction) {
  if (values.empty()) return kNaN;
  const double place = std::clamp(fraction, 0.0, 1.0) * static_cast<double>(values.size() - 1);
  const auto below = values.begin() + static_cast<std::ptrdiff_t>(place);
  std::nth_element(values.begin(), below, values.end());
  const double low = *below;
  if (below + 1 == values.end()) return low;
  const double high = *std::min_element(below + 1, values.end());
  return std::lerp(low, high, place - std::floor(place));
}

double Median(std::vector<double> values) {
  return Quantile(std::move(values), 0.5);
}

double MedianInterval(std::span<const double> time_s) {
  std::vector<double> intervals;
  for (std::size_t i = 1; i < time_s.size(); ++i) intervals.push_back(time_s[i] - time_s[i - 1]);
  return Median(std::move(intervals));
}

double RobustDeviation(const std::vector<double>& values) {
  return RobustDeviation(values, Median(values));
}

double RobustDeviation(std::vector<double> values, double mean) {
  for (double& value : values) value = std::abs(value - mean);
  return 1.4826 * Median(std::move(values));
}

}  // namespace lake
