// Numbers that carry exact first and second derivatives: dual numbers (Ceres' Jet) nested in dual numbers.
//
// Ceres mixes a Jet with its own scalar only: for nested ones that is a Jet, so `2.0 * x` would not compile. The
// operators below add plain doubles on either side.
#pragma once

#include <ceres/jet.h>

namespace lake::nlp {

// f.a.a is the value, f.a.v[i] = f.v[i].a the gradient, f.v[i].v[j] the Hessian.
template <int N>
using SecondOrder = ceres::Jet<ceres::Jet<double, N>, N>;

}  // namespace lake::nlp

namespace ceres {

template <int N>
lake::nlp::SecondOrder<N> operator+(const lake::nlp::SecondOrder<N>& f, double s) {
  return f + Jet<double, N>(s);
}
template <int N>
lake::nlp::SecondOrder<N> operator+(double s, const lake::nlp::SecondOrder<N>& f) {
  return f + Jet<double, N>(s);
}
template <int N>
lake::nlp::SecondOrder<N> operator-(const lake::nlp::SecondOrder<N>& f, double s) {
  return f - Jet<double, N>(s);
}
template <int N>
lake::nlp::SecondOrder<N> operator-(double s, const lake::nlp::SecondOrder<N>& f) {
  return Jet<double, N>(s) - f;
}
template <int N>
lake::nlp::SecondOrder<N> operator*(const lake::nlp::SecondOrder<N>& f, double s) {
  return f * Jet<double, N>(s);
}
template <int N>
lake::nlp::SecondOrder<N> operator*(double s, const lake::nlp::SecondOrder<N>& f) {
  return f * Jet<double, N>(s);
}
template <int N>
lake::nlp::SecondOrder<N> operator/(const lake::nlp::SecondOrder<N>& f, double s) {
  return f / Jet<double, N>(s);
}
template <int N>
lake::nlp::SecondOrder<N> operator/(double s, const lake::nlp::SecondOrder<N>& f) {
  return Jet<double, N>(s) / f;
}

}  // namespace ceres
