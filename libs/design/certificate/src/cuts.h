// Linear inequalities that hold over a box, and what follows from them together: a smaller box, and a bound on a linear
// function by the duality of linear programs. Multipliers come from plain floating point, the bound that they give is
// computed in verified arithmetic and holds for any multipliers >= 0 (Neumaier & Shcherbina, Math. Program. 99, 2004).
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "lake/certificate/interval.h"

namespace lake::certificate {

// An interval function over a box of l1..l6 and the bar angle phi, with its first derivatives: what it takes, and how
// steeply it changes with each, anywhere in the box (forward differentiation in interval arithmetic).

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

using AxisBox = std::array<Interval, kAxes>;

// constant + coefficients . y, y the distances from the lower ends of a box; `spread` is how wide the derivative was
// that each coefficient stands for, so what the inequality gives away grows with it.
struct Cut {
  double constant = 0;
  std::array<double, kAxes> coefficients{}, spread{};
};

using AxisPoint = std::array<double, kAxes>;
AxisBox BoxOf(const AxisPoint& point);

// A linear function nowhere below f in the box, at the points that a segment from the anchor reaches along which the
// slopes hold: f at the anchor, and for each axis the chord over the steepest of its slopes on either side (at a corner
// of the box: Araya, Trombettoni & Neveu, "A contractor based on convex interval Taylor", CPAIOR 2012). nullopt where
// the slopes are unbounded.
std::optional<Cut> UpperCut(const Slope& slope, const Interval& at_anchor, const AxisPoint& anchor, const AxisBox& box);

// Removes of the box what has cut < 0; false if nothing is left. `lower_ends`: the box that the cut was made for.
bool Contract(const Cut& cut, const AxisBox& lower_ends, AxisBox& box);

struct LinearBound {
  double upper = 0;                     // of the goal where all cuts are >= 0; -infinity: proved that they nowhere are
  Cut combined;                         // goal + sum of multipliers x cuts, which is nowhere below the goal there
  std::vector<double> multipliers;      // of the cuts
  std::array<double, kAxes> optimum{};  // of the linear program, approximately: 0 at the lower end, 1 at the upper
};
LinearBound BoundBy(const Cut& goal, const std::vector<Cut>& cuts, const AxisBox& box);

}  // namespace lake::certificate
