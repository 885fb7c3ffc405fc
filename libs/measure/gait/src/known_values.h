// Statistics of values per frame of which some are not known (NaN). Not part of the interface.
#pragma once

#include <cmath>
#include <vector>

#include "lake/core/numbers.h"
#include "lake/core/statistics.h"

namespace lake::gait {

// NaN if none is known.
inline double QuantileOfKnown(std::vector<double> values, double fraction) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  return values.empty() ? kNaN : Quantile(std::move(values), fraction);
}

inline double MedianOfKnown(std::vector<double> values) {
  return QuantileOfKnown(std::move(values), 0.5);
}

}  // namespace lake::gait
