#include "lake/compare/interval.h"

#include <algorithm>

#include "lake/core/statistics.h"

namespace lake::compare {

double DrawnQuantile(const std::vector<double>& draws, double fraction) {
  const auto n = static_cast<double>(draws.size());
  return n > 1 ? Quantile(draws, std::clamp((fraction * (n + 1) - 1) / (n - 1), 0.0, 1.0)) : Quantile(draws, fraction);
}

Interval PercentileInterval(const std::vector<double>& draws) {
  return {DrawnQuantile(draws, 0.025), DrawnQuantile(draws, 0.975)};
}

}  // namespace lake::compare
