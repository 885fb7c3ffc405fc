#include "lake/reliability/reliability.h"

#include <cmath>

#include "lake/core/distributions.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"

namespace lake::reliability {
namespace {

constexpr double kUpperTail = 0.975;  // of intervals of 95 %
constexpr double kNormalQuantile = 1.96;

Estimate Around(double value, double half_width) {
  return {value, {value - half_width, value + half_width}};
}

// a / b, NaN where nothing varies.
double Ratio(double a, double b) {
  return b > 0 ? a / b : kNaN;
}

}  // namespace

MeanSquares MeanSquaresOf(const Eigen::MatrixXd& values) {
  const Eigen::Index n = values.rows(), k = values.cols();
  if (n < 2 || k < 2) throw Fail("{} targets by {} judges: two of each are needed at least", n, k);
  if (!values.allFinite()) throw Error("a table of measurements has a gap");
  const Eigen::VectorXd of_target = values.rowwise().mean();
  const Eigen::RowVectorXd of_judge = values.colwise().mean();
  const double mean = values.mean();
  const Eigen::MatrixXd residual = (values.colwise() - of_target).rowwise() - (of_judge.array() - mean).matrix();
  return {
      .targets = n,
      .judges = k,
      .between_targets =
          static_cast<double>(k) * (of_target.array() - mean).square().sum() / static_cast<double>(n - 1),
      .between_judges = static_cast<double>(n) * (of_judge.array() - mean).square().sum() / static_cast<double>(k - 1),
      .residual = residual.squaredNorm() / static_cast<double>((n - 1) * (k - 1))};
}

Estimate Icc2Single(const MeanSquares& ms) {
  const auto n = static_cast<double>(ms.targets), k = static_cast<double>(ms.judges);
  const double bms = ms.between_targets, jms = ms.between_judges, ems = ms.residual;
  const double icc = Ratio(bms - ems, bms + (k - 1) * ems + k * (jms - ems) / n);
  if (!std::isfinite(icc) || ems == 0) return {icc, {kNaN, kNaN}};
  // Satterthwaite's degrees of freedom (Shrout & Fleiss, p. 424).
  const double f = jms / ems, a = n * (1 + (k - 1) * icc) - k * icc;
  const double b = k * icc * f;
  const double df = (k - 1) * (n - 1) * (b + a) * (b + a) / ((n - 1) * b * b + a * a);
  const double rest = k * jms + (k * n - k - n) * ems;
  const double f_low = FisherQuantile(n - 1, df, kUpperTail), f_high = FisherQuantile(df, n - 1, kUpperTail);
  if (!std::isfinite(f_low) || !std::isfinite(f_high)) return {icc, {kNaN, kNaN}};
  return {icc,
          {n * (bms - f_low * ems) / (f_low * rest + n * bms), n * (f_high * bms - ems) / (rest + n * f_high * bms)}};
}

Estimate Icc3Single(const MeanSquares& ms) {
  const auto n = static_cast<double>(ms.targets), k = static_cast<double>(ms.judges);
  const double icc = Ratio(ms.between_targets - ms.residual, ms.between_targets + (k - 1) * ms.residual);
  if (!std::isfinite(icc) || ms.residual == 0) return {icc, {kNaN, kNaN}};
  const double f = ms.between_targets / ms.residual, df = (n - 1) * (k - 1);
  const double low = f / FisherQuantile(n - 1, df, kUpperTail), high = f * FisherQuantile(df, n - 1, kUpperTail);
  return {icc, {(low - 1) / (low + k - 1), (high - 1) / (high + k - 1)}};
}

Estimate StandardErrorOfMeasurement(const MeanSquares& ms) {
  const auto df = static_cast<double>((ms.targets - 1) * (ms.judges - 1));
  const double sum = df * ms.residual;
  return {
      std::sqrt(ms.residual),
      {std::sqrt(sum / ChiSquaredQuantile(df, kUpperTail)), std::sqrt(sum / ChiSquaredQuantile(df, 1 - kUpperTail))}};
}

double MinimalDetectableChange(double standard_error) {
  return kNormalQuantile * std::sqrt(2.0) * standard_error;
}

LimitsOfAgreement LimitsOfAgreementOf(const std::vector<double>& first, const std::vector<double>& second) {
  if (first.size() != second.size()) throw Fail("{} values against {}", first.size(), second.size());
  std::vector<double> difference;
  for (std::size_t i = 0; i < first.size(); ++i) difference.push_back(second[i] - first[i]);
  const MeanOfSubjects mean = MeanOf(difference);
  const double sd = mean.standard_deviation, bias = mean.mean.value;
  if (mean.subjects < 2) return {mean.mean, {kNaN, {kNaN, kNaN}}, {kNaN, {kNaN, kNaN}}};
  const auto n = static_cast<double>(mean.subjects);
  const double half_width =
      StudentQuantile(n - 1, kUpperTail) * sd * std::sqrt(1 / n + kNormalQuantile * kNormalQuantile / (2 * (n - 1)));
  return {mean.mean, Around(bias - kNormalQuantile * sd, half_width), Around(bias + kNormalQuantile * sd, half_width)};
}

MeanOfSubjects MeanOf(const std::vector<double>& values) {
  MeanOfSubjects of{.subjects = values.size(),
                    .standard_deviation = values.size() < 2 ? kNaN : StandardDeviation(values),
                    .mean = {Mean(values), {kNaN, kNaN}}};
  if (values.size() < 2) return of;
  const auto n = static_cast<double>(values.size());
  of.mean = Around(of.mean.value, StudentQuantile(n - 1, kUpperTail) * of.standard_deviation / std::sqrt(n));
  return of;
}

std::vector<double> RobustScores(const std::vector<double>& values) {
  constexpr std::size_t kFewest = 5;
  const double middle = Median(values), deviation = RobustDeviation(values);
  std::vector<double> scores;
  for (const double value : values)
    scores.push_back(values.size() < kFewest || deviation == 0 ? kNaN : (value - middle) / deviation);
  return scores;
}

}  // namespace lake::reliability
