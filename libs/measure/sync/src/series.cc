#include "lake/sync/series.h"

#include <algorithm>
#include <cmath>

#include "lake/core/statistics.h"
#include "lake/gait/butterworth.h"

namespace lake::sync {
namespace {

using Eigen::Index;

// Short gaps are bridged by straight lines.
constexpr double kGap_s = 0.25;

// Linear between what is known, the nearest beyond the ends.
std::vector<double> Filled(const std::vector<double>& time_s, const Eigen::VectorXd& column) {
  std::vector<double> filled(time_s.size(), 0);
  std::size_t last = time_s.size();
  for (std::size_t i = 0; i < time_s.size(); ++i) {
    const double value = column[static_cast<Index>(i)];
    if (!std::isfinite(value)) continue;
    const std::size_t from = last == time_s.size() ? 0 : last;
    for (std::size_t k = from; k <= i; ++k)
      filled[k] = last == time_s.size()
                      ? value
                      : std::lerp(filled[last], value, (time_s[k] - time_s[last]) / (time_s[i] - time_s[last]));
    last = i;
  }
  if (last != time_s.size()) std::fill(filled.begin() + static_cast<std::ptrdiff_t>(last), filled.end(), filled[last]);
  return filled;
}

}  // namespace

Band BandOf(const std::vector<double>& time_a_s, const std::vector<double>& time_b_s) {
  constexpr double kPerson_hz = 4, kOfRate = 0.2;
  const double slowest_hz = 1 / std::max(MedianInterval(time_a_s), MedianInterval(time_b_s));
  const double cutoff_hz = std::min(kPerson_hz, kOfRate * slowest_hz);
  return {cutoff_hz, 1 / (10 * cutoff_hz)};
}

Series Sample(const std::vector<double>& time_s, const Eigen::MatrixXd& values, const Band& band) {
  const double step_s = band.step_s;
  Series series{.step_s = step_s};
  const double first = std::ceil(time_s.front() / step_s), last = std::floor(time_s.back() / step_s);
  series.start_s = first * step_s;
  const Index rows = std::max<Index>(static_cast<Index>(last - first) + 1, 0);
  series.value = Eigen::MatrixXd::Zero(rows, values.cols());
  series.known.assign(static_cast<std::size_t>(rows), 0);
  std::vector<std::size_t> whole;
  for (std::size_t i = 0; i < time_s.size(); ++i)
    if (values.row(static_cast<Index>(i)).allFinite()) whole.push_back(i);
  if (whole.size() < 4) return series;
  for (Index c = 0; c < values.cols(); ++c) {
    const std::vector<double> filtered =
        gait::ZeroPhaseButterworthAtTimes(Filled(time_s, values.col(c)), time_s, band.cutoff_hz);
    std::size_t i = 0;
    for (Index row = 0; row < rows; ++row) {
      const double t = series.TimeAt(row);
      while (i + 2 < time_s.size() && time_s[i + 1] <= t) ++i;
      const std::size_t before = i == 0 ? 0 : i - 1, after = std::min(i + 2, time_s.size() - 1);
      const double h = time_s[i + 1] - time_s[i], u = std::clamp((t - time_s[i]) / h, 0.0, 1.0);
      const double p = filtered[i], q = filtered[i + 1],
                   mp = h * (q - filtered[before]) / (time_s[i + 1] - time_s[before]),
                   mq = h * (filtered[after] - p) / (time_s[after] - time_s[i]);
      series.value(row, c) = p + u * (mp + u * (3 * (q - p) - 2 * mp - mq + u * (2 * (p - q) + mp + mq)));
    }
  }
  std::size_t next = 0;
  for (Index row = 0; row < rows; ++row) {
    const double t = series.TimeAt(row);
    while (next < whole.size() && time_s[whole[next]] < t) ++next;
    const bool is_known = next < whole.size() && (next > 0 || time_s[whole[0]] == t) &&
                          (next == 0 || time_s[whole[next]] - time_s[whole[next - 1]] <= kGap_s);
    series.known[static_cast<std::size_t>(row)] = is_known ? 1 : 0;
  }
  return series;
}

Series Derivative(const Series& series) {
  Series slope{.start_s = series.start_s, .step_s = series.step_s};
  const Index rows = series.Rows();
  slope.value = Eigen::MatrixXd::Zero(rows, series.value.cols());
  slope.known.assign(series.known.size(), 0);
  for (Index i = 2; i + 2 < rows; ++i) {
    const auto at = static_cast<std::size_t>(i);
    if (!std::all_of(&series.known[at - 2], &series.known[at + 2] + 1, [](auto known) { return known != 0; })) continue;
    slope.known[at] = 1;
    slope.value.row(i) =
        (8 * (series.value.row(i + 1) - series.value.row(i - 1)) - series.value.row(i + 2) + series.value.row(i - 2)) /
        (12 * series.step_s);
  }
  return slope;
}

Series Thinned(const Series& series, Index stride) {
  Series thin{.start_s = series.start_s, .step_s = series.step_s * static_cast<double>(stride)};
  const Index rows = (series.Rows() + stride - 1) / stride;
  thin.value.resize(rows, series.value.cols());
  for (Index i = 0; i < rows; ++i) {
    thin.value.row(i) = series.value.row(i * stride);
    thin.known.push_back(series.known[static_cast<std::size_t>(i * stride)]);
  }
  return thin;
}

bool ValuesAt(const Series& series, double time_s, Eigen::RowVectorXd& value, Eigen::RowVectorXd& slope) {
  const double place = (time_s - series.start_s) / series.step_s;
  if (!(place >= 1) || !(place < static_cast<double>(series.Rows() - 2))) return false;
  const auto i = static_cast<Index>(place);
  const auto at = static_cast<std::size_t>(i);
  if (!series.known[at - 1] || !series.known[at] || !series.known[at + 1] || !series.known[at + 2]) return false;
  const double u = place - static_cast<double>(i);
  const auto &a = series.value.row(i - 1), &p = series.value.row(i), &q = series.value.row(i + 1),
             &b = series.value.row(i + 2);
  const Eigen::RowVectorXd mp = (q - a) / 2, mq = (b - p) / 2, square = 3 * (q - p) - 2 * mp - mq,
                           cube = 2 * (p - q) + mp + mq;
  value = p + u * (mp + u * (square + u * cube));
  slope = (mp + u * (2 * square + 3 * u * cube)) / series.step_s;
  return true;
}

}  // namespace lake::sync
