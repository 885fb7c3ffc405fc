#include "lake/core/distributions.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace lake {

double NormalQuantile(double p) {
  return quantile(boost::math::normal(), p);
}

double StudentQuantile(double freedom, double p) {
  return quantile(boost::math::students_t(freedom), p);
}

double ChiSquaredQuantile(double freedom, double p) {
  return quantile(boost::math::chi_squared(freedom), p);
}

double FisherQuantile(double numerator_freedom, double denominator_freedom, double p) {
  using namespace boost::math::policies;
  using Quiet = policy<domain_error<ignore_error>, overflow_error<ignore_error>, evaluation_error<ignore_error>>;
  return quantile(boost::math::fisher_f_distribution<double, Quiet>(numerator_freedom, denominator_freedom), p);
}

}  // namespace lake
