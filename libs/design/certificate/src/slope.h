// An interval function over a box of l1..l6 and the bar angle phi, with its first derivatives: what it takes, and how
// steeply it changes with each, anywhere in the box (forward differentiation in interval arithmetic).
#pragma once

#include <array>

#include "lake/certificate/interval.h"

namespace lake::certificate {

enum Axis : std::size_t { kL1, kL2, kL3, kL4, kL5, kL6, kPhi };  // mm, phi in rad
inline constexpr std::size_t kAxes = 7;

struct Slope {
  Interval value;
  std::array<Interval, kAxes> by{};

  Slope() = default;
  Slope(const Interval& constant) : value(constant) {}  // NOLINT: an interval is a function that does not change

  static Slope Axis(std::size_t axis, const Interval& range) {
    Slope slope(range);
    slope.by[axis] = 1;
    return slope;
  }
};

// Most functions depend on few axes: of the others the derivative is exactly zero, which is not multiplied or widened.
inline bool IsZero(const Interval& a) {
  return a.lower == 0 && a.upper == 0;
}
inline Interval Times(const Interval& factor, const Interval& derivative) {
  return IsZero(derivative) ? derivative : factor * derivative;
}
inline Interval Sum(const Interval& a, const Interval& b) {
  return IsZero(a) ? b : IsZero(b) ? a : a + b;
}

// f(a) with the derivative of f at a.
inline Slope Chain(const Slope& a, const Interval& value, const Interval& derivative) {
  Slope result(value);
  for (std::size_t i = 0; i < kAxes; ++i) result.by[i] = Times(derivative, a.by[i]);
  return result;
}
// f(a, b) with its derivatives.
inline Slope Chain(const Slope& a, const Slope& b, const Interval& value, const Interval& by_a, const Interval& by_b) {
  Slope result(value);
  for (std::size_t i = 0; i < kAxes; ++i) result.by[i] = Sum(Times(by_a, a.by[i]), Times(by_b, b.by[i]));
  return result;
}

inline Slope operator-(const Slope& a) {
  Slope result(-a.value);
  for (std::size_t i = 0; i < kAxes; ++i) result.by[i] = -a.by[i];
  return result;
}
inline Slope operator+(const Slope& a, const Slope& b) {
  Slope result(a.value + b.value);
  for (std::size_t i = 0; i < kAxes; ++i) result.by[i] = Sum(a.by[i], b.by[i]);
  return result;
}
inline Slope operator-(const Slope& a, const Slope& b) {
  return a + -b;
}
inline Slope operator*(const Slope& a, const Slope& b) {
  return Chain(a, b, a.value * b.value, b.value, a.value);
}
inline Slope operator/(const Slope& a, const Slope& b) {
  const Interval quotient = a.value / b.value;
  return Chain(a, b, quotient, 1.0 / b.value, -quotient / b.value);
}
inline Slope operator+(const Interval& a, const Slope& b) {
  return Slope(a) + b;
}
inline Slope operator+(const Slope& a, const Interval& b) {
  return a + Slope(b);
}
inline Slope operator-(const Interval& a, const Slope& b) {
  return Slope(a) - b;
}
inline Slope operator-(const Slope& a, const Interval& b) {
  return a - Slope(b);
}
inline Slope operator*(const Interval& a, const Slope& b) {
  return Chain(b, a * b.value, a);
}
inline Slope operator*(const Slope& a, const Interval& b) {
  return b * a;
}
inline Slope Square(const Slope& a) {
  return Chain(a, Square(a.value), 2.0 * a.value);
}
inline Slope Sin(const Slope& a) {
  return Chain(a, Sin(a.value), Cos(a.value));
}
inline Slope Cos(const Slope& a) {
  return Chain(a, Cos(a.value), -Sin(a.value));
}
inline Slope Sqrt(const Slope& a) {
  const Interval root = Sqrt(a.value);
  return Chain(a, root, 0.5 / root);
}

}  // namespace lake::certificate
