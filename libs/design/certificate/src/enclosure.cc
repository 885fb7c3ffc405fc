#include "lake/certificate/enclosure.h"

#include <algorithm>

namespace lake::certificate {
namespace {

// f(a) of its derivatives at a.
Enclosure Composed(const Enclosure& a, const Interval& value, const Interval& first, const Interval& second) {
  Enclosure f;
  f.value = value;
  f.count = a.count;
  for (int i = 0; i < a.count; ++i) {
    f.first[i] = first * a.first[i];
    for (int j = 0; j <= i; ++j)
      f.second[Enclosure::Place(i, j)] = first * a.Second(i, j) + second * a.first[i] * a.first[j];
  }
  return f;
}

// a + sign b.
Enclosure Sum(const Enclosure& a, const Enclosure& b, double sign) {
  Enclosure f;
  f.value = a.value + sign * b.value;
  f.count = std::max(a.count, b.count);
  for (int i = 0; i < f.count; ++i) f.first[i] = a.first[i] + sign * b.first[i];
  const std::size_t entries = Enclosure::Place(f.count, 0);
  for (std::size_t i = 0; i < entries; ++i) f.second[i] = a.second[i] + sign * b.second[i];
  return f;
}

}  // namespace

Enclosure Enclosure::Variable(int index, int count, const Interval& range) {
  Enclosure variable;
  variable.value = range;
  variable.count = count;
  variable.first[index] = 1;
  return variable;
}

Enclosure operator-(const Enclosure& a) {
  return Composed(a, -a.value, -1, 0);
}
Enclosure operator+(const Enclosure& a, const Enclosure& b) {
  return Sum(a, b, 1);
}
Enclosure operator-(const Enclosure& a, const Enclosure& b) {
  return Sum(a, b, -1);
}
Enclosure operator*(const Enclosure& a, const Enclosure& b) {
  if (b.count == 0) return Composed(a, a.value * b.value, b.value, 0);
  if (a.count == 0) return Composed(b, a.value * b.value, a.value, 0);
  Enclosure f;
  f.value = a.value * b.value;
  f.count = std::max(a.count, b.count);
  for (int i = 0; i < f.count; ++i) {
    f.first[i] = a.first[i] * b.value + a.value * b.first[i];
    for (int j = 0; j <= i; ++j)
      f.second[Enclosure::Place(i, j)] =
          a.Second(i, j) * b.value + a.value * b.Second(i, j) + a.first[i] * b.first[j] + a.first[j] * b.first[i];
  }
  return f;
}
Enclosure operator/(const Enclosure& a, const Enclosure& b) {
  const Interval inverse = 1.0 / b.value, slope = -Square(inverse);
  return a * Composed(b, inverse, slope, -2.0 * slope * inverse);
}
Enclosure& operator+=(Enclosure& a, const Enclosure& b) {
  return a = a + b;
}
Enclosure sin(const Enclosure& a) {  // NOLINT
  const Interval sine = Sin(a.value);
  return Composed(a, sine, Cos(a.value), -sine);
}
Enclosure cos(const Enclosure& a) {  // NOLINT
  const Interval cosine = Cos(a.value);
  return Composed(a, cosine, -Sin(a.value), -cosine);
}
Enclosure sqrt(const Enclosure& a) {  // NOLINT
  const Interval root = Sqrt(a.value), slope = 0.5 / root;
  return Composed(a, root, slope, -0.5 * slope / a.value);
}

}  // namespace lake::certificate
