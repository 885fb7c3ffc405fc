#include "lake/certificate/interval.h"

#include "lake/core/numbers.h"

namespace lake::certificate {

using interval_detail::kLibmUlps;
using interval_detail::Widened;

Interval Square(const Interval& a) {
  const double low = a.lower * a.lower, high = a.upper * a.upper;
  Interval square = Widened(a.Contains(0) ? 0 : std::min(low, high), std::max(low, high));
  square.lower = std::max(square.lower, 0.0);
  return square;
}

Interval Sqrt(const Interval& a) {
  if (a.upper < 0) return {1, 0};
  Interval root = Widened(std::sqrt(std::max(a.lower, 0.0)), std::sqrt(a.upper));
  root.lower = std::max(root.lower, 0.0);
  return root;
}

Interval ArcCos(const Interval& a) {
  if (a.upper < -1 || a.lower > 1) return {1, 0};
  const Interval angle = Widened(std::acos(std::min(a.upper, 1.0)), std::acos(std::max(a.lower, -1.0)), kLibmUlps);
  return Intersection(angle, {0, kPiInterval.upper});
}

Interval Cos(const Interval& a) {
  if (!(a.Width() < 2 * kPi) || std::abs(a.lower) > 1e6) return {-1, 1};
  Interval value = Widened(std::min(std::cos(a.lower), std::cos(a.upper)),
                           std::max(std::cos(a.lower), std::cos(a.upper)), kLibmUlps);
  // Extrema at multiples of pi; a multiple this close outside is taken as inside, which only widens.
  constexpr double kNear = 1e-9;
  for (double n = std::ceil((a.lower - kNear) / kPi); n * kPi <= a.upper + kNear; ++n)
    value = Hull(value, std::fmod(std::abs(n), 2.0) == 0 ? 1.0 : -1.0);
  return Intersection(value, {-1, 1});
}

Interval Sin(const Interval& a) {
  return Cos(a - kPiInterval / 2.0);
}

Interval AngleFromY(const Interval& x, const Interval& y) {
  const Interval right{std::max(x.lower, 0.0), x.upper};
  const Interval all{0, kPiInterval.upper};
  if (right.IsEmpty()) return {1, 0};
  if (right.lower == 0 && y.Contains(0)) return all;
  // The angle falls with y, and with x it rises where y > 0 and falls where y < 0: extremes are at the corners, and at
  // y = 0 the angle does not depend on x.
  const double corners[] = {std::atan2(right.lower, y.lower), std::atan2(right.lower, y.upper),
                            std::atan2(right.upper, y.lower), std::atan2(right.upper, y.upper)};
  const auto [least, most] = std::minmax_element(std::begin(corners), std::end(corners));
  return Intersection(Widened(*least, *most, kLibmUlps), all);
}

}  // namespace lake::certificate
