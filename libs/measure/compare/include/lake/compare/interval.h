// An interval of confidence.
#pragma once

#include "lake/core/statistics.h"

namespace lake::compare {

// 95 %, two-sided.
struct Interval {
  double low = 0, high = 0;

  // Standard deviation of a normal quantity that has this interval.
  double Deviation() const { return (high - low) / (2 * kNormal95); }
};

// Around a value whose squared standard error was estimated with so many degrees of freedom.
Interval StudentInterval(double value, double variance, double freedom);

}  // namespace lake::compare
