// Statistics of residuals. All take values in any order; an empty input gives NaN.
#pragma once

#include <span>
#include <vector>

namespace lake {

// Standard deviations of the normal distribution on either side of its mean between which 95 % lie.
inline constexpr double kNormal95 = 1.959964;

double Mean(std::span<const double> values);

// The sample standard deviation, divisor n − 1.
double StandardDeviation(std::span<const double> values);

// sqrt(mean(v²)).
double RootMeanSquare(std::span<const double> values);

// Linear interpolation between order statistics (type 7 of Hyndman & Fan 1996); `fraction` in 0..1.
double Quantile(std::vector<double> values, double fraction);

double Median(std::vector<double> values);

// The median time from each value to the next, as times are recorded; NaN of fewer than two.
double MedianInterval(std::span<const double> time_s);

// 1.4826 × median |v − median|: for normal values an estimate of their standard deviation that half of them cannot
// spoil.
double RobustDeviation(const std::vector<double>& values);
// The same about a known mean in place of the median.
double RobustDeviation(std::vector<double> values, double mean);

}  // namespace lake
