// Verified interval arithmetic: every operation returns an interval that contains all exact results for all points of
// its operands.
//
// Computed in the default rounding to nearest, then widened outwards: a sum, product, quotient or square root by one
// step to the neighbouring double (Rump, Zimmermann, Boldo & Melquiond, "Computing predecessor and successor in
// rounding to nearest", BIT 49, 2009), sine, cosine, arc cosine and arc tangent by kLibmUlps steps. IEEE 754 fixes the
// former; for the latter the bound is an assumption about the C library: glibc documents at most 1 ulp for these
// functions on x86-64 ("Known Maximum Errors in Math Functions"). Boost's intervals do not widen the library functions,
// hence this class. Needs IEEE doubles: no -ffast-math.
#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "lake/core/numbers.h"

namespace lake::certificate {

struct Interval {
  double lower = 0, upper = 0;

  constexpr Interval() = default;
  constexpr Interval(double value) : lower(value), upper(value) {}  // NOLINT: a number is an interval
  constexpr Interval(double lower_end, double upper_end) : lower(lower_end), upper(upper_end) {}

  double Width() const { return upper - lower; }
  double Middle() const { return lower + (upper - lower) / 2; }
  bool Contains(double value) const { return lower <= value && value <= upper; }
  bool IsEmpty() const { return !(lower <= upper); }
};

namespace interval_detail {

inline constexpr int kLibmUlps = 4;

// At least the neighbouring double above / below.
inline double Above(double value) {
  constexpr double kUnit = 0x1p-53 * (1 + 0x1p-52);
  return value + (std::abs(value) * kUnit + std::numeric_limits<double>::denorm_min());
}
inline double Below(double value) {
  return -Above(-value);
}

inline Interval Widened(double lower, double upper, int steps = 1) {
  for (int i = 0; i < steps; ++i) {
    lower = Below(lower);
    upper = Above(upper);
  }
  return {lower, upper};
}

// Of two ends: an end at infinity stands for numbers beyond every bound, and zero times each of them is zero.
inline double Product(double x, double y) {
  return x == 0 || y == 0 ? 0 : x * y;
}
// Likewise what is over numbers beyond every bound comes as near to zero as it likes.
inline double Quotient(double x, double y) {
  return std::isinf(y) ? 0 : x / y;
}

}  // namespace interval_detail

// Contains pi.
inline constexpr Interval kPiInterval{3.141592653589793, 3.1415926535897936};

inline Interval operator-(const Interval& a) {
  return {-a.upper, -a.lower};
}
inline Interval operator+(const Interval& a, const Interval& b) {
  return interval_detail::Widened(a.lower + b.lower, a.upper + b.upper);
}
inline Interval operator-(const Interval& a, const Interval& b) {
  return a + (-b);
}
inline Interval operator*(const Interval& a, const Interval& b) {
  using interval_detail::Product;
  const double products[] = {Product(a.lower, b.lower), Product(a.lower, b.upper), Product(a.upper, b.lower),
                             Product(a.upper, b.upper)};
  const auto [least, most] = std::minmax_element(std::begin(products), std::end(products));
  return interval_detail::Widened(*least, *most);
}
// The whole line if the divisor contains zero.
inline Interval operator/(const Interval& a, const Interval& b) {
  if (b.Contains(0)) return {-kInfinity, kInfinity};
  using interval_detail::Quotient;
  const double quotients[] = {Quotient(a.lower, b.lower), Quotient(a.lower, b.upper), Quotient(a.upper, b.lower),
                              Quotient(a.upper, b.upper)};
  const auto [least, most] = std::minmax_element(std::begin(quotients), std::end(quotients));
  return interval_detail::Widened(*least, *most);
}

inline Interval Hull(const Interval& a, const Interval& b) {
  return {std::min(a.lower, b.lower), std::max(a.upper, b.upper)};
}
inline Interval Intersection(const Interval& a, const Interval& b) {
  return {std::max(a.lower, b.lower), std::min(a.upper, b.upper)};
}
inline Interval Max(const Interval& a, const Interval& b) {
  return {std::max(a.lower, b.lower), std::max(a.upper, b.upper)};
}

Interval Square(const Interval& a);
// Of the part of the operand where the function is defined; empty if there is none.
Interval Sqrt(const Interval& a);
Interval ArcCos(const Interval& a);
Interval Sin(const Interval& a);
Interval Cos(const Interval& a);

// The angle of (x, y) from the +y axis for x >= 0, in [0, pi]; a lower end of x below zero counts as zero. [0, pi] if
// the box contains the origin.
Interval AngleFromY(const Interval& x, const Interval& y);

}  // namespace lake::certificate
