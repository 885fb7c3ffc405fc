#include "lake/loads/spline_grid.h"

#include <algorithm>
#include <cmath>

#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"

namespace lake::loads {
namespace {

double Combine(std::size_t first, const std::array<double, 4>& weights, std::span<const double> coefficients) {
  double sum = 0;
  for (std::size_t a = 0; a < 4; ++a) sum += weights[a] * coefficients[first + a];
  return sum;
}

}  // namespace

SplineGrid::Place SplineGrid::At(double time_s) const {
  const double position = (time_s - start_s) / step_s;
  Place place;
  place.first = static_cast<std::size_t>(std::clamp(std::floor(position), 0.0, static_cast<double>(count - 4)));
  const double u = position - static_cast<double>(place.first), v = 1 - u;
  place.value = {v * v * v / 6, (3 * u * u * u - 6 * u * u + 4) / 6, (-3 * u * u * u + 3 * u * u + 3 * u + 1) / 6,
                 u * u * u / 6};
  place.slope = {-v * v / 2 / step_s, (3 * u * u - 4 * u) / 2 / step_s, (-3 * u * u + 2 * u + 1) / 2 / step_s,
                 u * u / 2 / step_s};
  const double step2 = step_s * step_s;
  place.curve = {v / step2, (3 * u - 2) / step2, (1 - 3 * u) / step2, u / step2};
  return place;
}

SplineGrid MakeSplineGrid(std::span<const double> time_s, double step_s) {
  const double length = time_s.back() - time_s.front(), pieces = std::max(1.0, std::ceil(length / step_s * (1 - 1e-9)));
  if (!(step_s > 0) || pieces > 50 * static_cast<double>(time_s.size()) + 50)
    throw Fail("loads: the time stamps run over {} s, but a step is {} s: they have holes too large to bridge",
               SignificantText(length, 4), SignificantText(step_s, 4));
  return {time_s.front(), step_s, static_cast<std::size_t>(pieces) + 3};
}

double ValueAt(const SplineGrid::Place& place, std::span<const double> coefficients) {
  return Combine(place.first, place.value, coefficients);
}

double SlopeAt(const SplineGrid::Place& place, std::span<const double> coefficients) {
  return Combine(place.first, place.slope, coefficients);
}

double CurveAt(const SplineGrid::Place& place, std::span<const double> coefficients) {
  return Combine(place.first, place.curve, coefficients);
}

}  // namespace lake::loads
