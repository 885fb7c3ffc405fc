#include "lake/compare/interval.h"

#include "lake/core/statistics.h"

namespace lake::compare {

Interval PercentileInterval(const std::vector<double>& draws) {
  return {Quantile(draws, 0.025), Quantile(draws, 0.975)};
}

}  // namespace lake::compare
