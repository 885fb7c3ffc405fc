#include "lake/gait/butterworth.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"

namespace lake::gait {
namespace {

// y_n = b0 x_n + b1 x_{n−1} + b2 x_{n−2} − a1 y_{n−1} − a2 y_{n−2}
struct Biquad {
  double b0, b1, b2, a1, a2;
};

Biquad DesignPass(double rate_hz, double cutoff_hz) {
  // The bilinear transform of 1 / (s² + √2 s + 1); the cutoff is prewarped, then moved out for the second pass.
  const double k = std::tan(std::numbers::pi * cutoff_hz / rate_hz) / std::pow(std::numbers::sqrt2 - 1, 0.25);
  const double norm = 1 / (1 + std::numbers::sqrt2 * k + k * k);
  return {k * k * norm, 2 * k * k * norm, k * k * norm, 2 * (k * k - 1) * norm,
          (1 - std::numbers::sqrt2 * k + k * k) * norm};
}

// Starts as if the first value had always been there.
void RunPass(const Biquad& f, std::vector<double>& values) {
  double x1 = values.front(), x2 = x1, y1 = x1, y2 = x1;
  for (double& value : values) {
    const double x = value;
    value = f.b0 * x + f.b1 * x1 + f.b2 * x2 - f.a1 * y1 - f.a2 * y2;
    x2 = x1;
    x1 = x;
    y2 = y1;
    y1 = value;
  }
}

void Check(std::span<const double> values, double rate_hz, double cutoff_hz) {
  if (!(rate_hz > 0) || !std::isfinite(rate_hz)) throw Fail("filter: a rate of {} Hz is not positive", rate_hz);
  CheckCutoff(cutoff_hz, rate_hz);
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i])) throw Fail("filter: value {} is not finite; fill the gaps first", i);
}

std::vector<double> Intervals(std::span<const double> time_s) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < time_s.size(); ++i) steps.push_back(time_s[i] - time_s[i - 1]);
  return steps;
}

}  // namespace

void CheckCutoff(double cutoff_hz, double rate_hz) {
  if (cutoff_hz > 0 && cutoff_hz < 0.4 * rate_hz) return;
  constexpr double kSlowest_hz = 5;  // that anybody records movement with
  throw Fail("filter: a cutoff of {} Hz must lie between 0 and {} Hz (0.4 of the frame rate){}", cutoff_hz,
             SignificantText(0.4 * rate_hz, 3),
             rate_hz < kSlowest_hz ? fmt::format("; the samples are {} s apart: times are in seconds, are these in ms?",
                                                 SignificantText(1 / rate_hz, 3))
                                   : "");
}

std::vector<double> ZeroPhaseButterworth(std::span<const double> values, double rate_hz, double cutoff_hz) {
  Check(values, rate_hz, cutoff_hz);
  const std::size_t n = values.size();
  if (n < 2) return {values.begin(), values.end()};
  // Two periods of the cutoff: the filter's memory of the continuation's start has died out by then.
  const auto pad = std::min(n - 1, static_cast<std::size_t>(std::ceil(2 * rate_hz / cutoff_hz)));
  std::vector<double> padded;
  padded.reserve(n + 2 * pad);
  for (std::size_t i = pad; i > 0; --i) padded.push_back(2 * values[0] - values[i]);
  padded.insert(padded.end(), values.begin(), values.end());
  for (std::size_t i = 1; i <= pad; ++i) padded.push_back(2 * values[n - 1] - values[n - 1 - i]);

  const Biquad pass = DesignPass(rate_hz, cutoff_hz);
  for (int direction = 0; direction < 2; ++direction) {
    RunPass(pass, padded);
    std::reverse(padded.begin(), padded.end());
  }
  const auto first = padded.begin() + static_cast<std::ptrdiff_t>(pad);
  return {first, first + static_cast<std::ptrdiff_t>(n)};
}

std::vector<double> ZeroPhaseButterworthAtTimes(std::span<const double> values, std::span<const double> time_s,
                                                double cutoff_hz) {
  if (values.size() < 3) return {values.begin(), values.end()};
  const std::vector<double> steps = Intervals(time_s);
  const double step = Median(steps);
  const auto [shortest, longest] = std::minmax_element(steps.begin(), steps.end());
  if (*longest - *shortest < 0.01 * step) return ZeroPhaseButterworth(values, 1 / step, cutoff_hz);

  const double length = time_s.back() - time_s.front();
  constexpr double kMostCellsPerValue = 100;
  if (length / step > kMostCellsPerValue * static_cast<double>(values.size()))
    throw Fail("filter: the time stamps leave holes of up to {} s between steps of {} s", SignificantText(*longest, 3),
               SignificantText(step, 3));
  const auto cells = static_cast<std::size_t>(std::ceil(length / step));
  std::vector<double> grid(cells + 1);
  for (std::size_t i = 0; i <= cells; ++i)
    grid[i] = time_s.front() + length * static_cast<double>(i) / static_cast<double>(cells);
  const std::vector<double> filtered =
      ZeroPhaseButterworth(InterpolateCubic(values, time_s, grid), static_cast<double>(cells) / length, cutoff_hz);
  return InterpolateCubic(filtered, grid, time_s);
}

std::vector<double> InterpolateCubic(std::span<const double> values, std::span<const double> from,
                                     std::span<const double> to) {
  const std::size_t n = values.size();
  const auto slope = [&](std::size_t i) {
    const std::size_t a = i == 0 ? 0 : i - 1, b = std::min(i + 1, n - 1);
    if (a == i || b == i) return (values[b] - values[a]) / (from[b] - from[a]);
    const double before = from[i] - from[a], after = from[b] - from[i];
    return ((values[i] - values[a]) / before * after + (values[b] - values[i]) / after * before) / (before + after);
  };
  std::vector<double> result;
  std::size_t i = 0;
  for (const double t : to) {
    while (i + 2 < n && from[i + 1] <= t) ++i;
    const double h = from[i + 1] - from[i], u = std::clamp((t - from[i]) / h, 0.0, 1.0);
    const double p = values[i], q = values[i + 1], mp = slope(i) * h, mq = slope(i + 1) * h;
    result.push_back(p + u * (mp + u * (3 * (q - p) - 2 * mp - mq + u * (2 * (p - q) + mp + mq))));
  }
  return result;
}

}  // namespace lake::gait
