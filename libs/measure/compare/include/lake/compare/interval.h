// An interval of confidence.
#pragma once

#include <vector>

#include "lake/core/statistics.h"

namespace lake::compare {

// 95 %, two-sided.
struct Interval {
  double low = 0, high = 0;

  // Standard deviation of a normal quantity that has this interval.
  double Deviation() const { return (high - low) / (2 * kNormal95); }
};

// Below which another draw is with this probability, however few draws there are (type 6 of Hyndman & Fan 1996).
double DrawnQuantile(const std::vector<double>& draws, double fraction);

// From the 2.5 % to the 97.5 % quantile of draws.
Interval PercentileInterval(const std::vector<double>& draws);

}  // namespace lake::compare
