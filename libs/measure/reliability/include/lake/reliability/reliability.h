// Repeatability of a measurement and difference of two conditions, over subjects. All intervals are of 95 %.
//
// Values stand in a table of n targets (subjects, rows) by k judges (sessions, repetitions or raters, columns) without
// a gap. What is not defined (no variation, too few values) is NaN.
//
// Shrout & Fleiss, Psychol. Bull. 86, 1979 (mean squares, ICC, their intervals); McGraw & Wong, Psychol. Methods 1,
// 1996; Weir, J. Strength Cond. Res. 19, 2005 (SEM, MDC); Bland & Altman, Stat. Methods Med. Res. 8, 1999.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace lake::reliability {

struct Interval {
  double low = 0, high = 0;
};

struct Estimate {
  double value = 0;
  Interval interval;
};

// Of the two-way layout: between targets, between judges, and the residual of both.
struct MeanSquares {
  Eigen::Index targets = 0, judges = 0;
  double between_targets = 0, between_judges = 0, residual = 0;
};

// Throws Error unless there are two targets and two judges at least, all values finite.
MeanSquares MeanSquaresOf(const Eigen::MatrixXd& values);

// Intraclass correlations of a single measurement: ICC(2,1), judges are a random sample, and their systematic
// differences count (agreement); ICC(3,1), these judges and no others, whose differences do not count (consistency).
Estimate Icc2Single(const MeanSquares& ms);
Estimate Icc3Single(const MeanSquares& ms);

// The standard error of measurement, in the values' unit: sqrt(residual mean square) (Weir's eq. 9), its interval by
// χ². The minimal detectable change of one subject between two measurements is 1.96 √2 SEM.
Estimate StandardErrorOfMeasurement(const MeanSquares& ms);
double MinimalDetectableChange(double standard_error);

// Second minus first: its mean, and the limits between which 95 % of differences lie (1.96 standard deviations), each
// with its interval (Bland & Altman's section 3).
struct LimitsOfAgreement {
  Estimate bias, lower, upper;
};
LimitsOfAgreement LimitsOfAgreementOf(const std::vector<double>& first, const std::vector<double>& second);

// Of values one per subject: mean, standard deviation (n − 1), and the mean's interval by Student's t.
struct MeanOfSubjects {
  std::size_t subjects = 0;
  double standard_deviation = 0;
  Estimate mean;
};
MeanOfSubjects MeanOf(const std::vector<double>& values);

// How far each value lies from the others, in robust standard deviations: (v − median) / (1.4826 median |v − median|).
// Beyond 3.5 it counts as an outlier (Iglewicz & Hoaglin, How to Detect and Handle Outliers, 1993). NaN where more than
// half of the values are the same, or where there are fewer than five.
std::vector<double> RobustScores(const std::vector<double>& values);
inline constexpr double kOutlierScore = 3.5;

}  // namespace lake::reliability
