#include "lake/compare/interval.h"

#include <boost/math/distributions/students_t.hpp>
#include <cmath>

namespace lake::compare {

Interval StudentInterval(double value, double variance, double freedom) {
  constexpr double kUpper = 0.975;
  const double reach = quantile(boost::math::students_t(freedom), kUpper) * std::sqrt(variance);
  return {value - reach, value + reach};
}

}  // namespace lake::compare
