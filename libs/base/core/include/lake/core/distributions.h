// Quantiles of the distributions on which intervals rest; `p` between 0 and 1, from below.
#pragma once

namespace lake {

double NormalQuantile(double p);
// Student's t; the normal distribution's at infinitely many degrees of freedom.
double StudentQuantile(double freedom, double p);
double ChiSquaredQuantile(double freedom, double p);
// Not finite where there are hardly any degrees of freedom.
double FisherQuantile(double numerator_freedom, double denominator_freedom, double p);

}  // namespace lake
