#include "lake/compare/interval.h"

#include <cmath>

#include "lake/core/distributions.h"

namespace lake::compare {

Interval StudentInterval(double value, double variance, double freedom) {
  constexpr double kUpper = 0.975;
  const double reach = StudentQuantile(freedom, kUpper) * std::sqrt(variance);
  return {value - reach, value + reach};
}

}  // namespace lake::compare
