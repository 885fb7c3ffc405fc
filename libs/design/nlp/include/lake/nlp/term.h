// One term of a nonlinear program: a function of a few of its variables, with exact gradient and Hessian.
#pragma once

#include <ceres/jet.h>

#include <array>
#include <span>
#include <vector>

// Numbers that carry exact first and second derivatives: dual numbers (Ceres' Jet) nested in dual numbers.
//
// Ceres mixes a Jet with its own scalar only: for nested ones that is a Jet, so `2.0 * x` would not compile. The
// operators below add plain doubles on either side.
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

namespace lake::nlp {

class Term {
 public:
  explicit Term(std::vector<int> variables) : variables_(std::move(variables)) {}
  virtual ~Term() = default;

  // The variables it depends on, by their index in the program.
  std::span<const int> Variables() const { return variables_; }

  // All take the whole vector x of the program. `gradient` has one entry per own variable; `hessian` the lower triangle
  // row by row, n (n + 1) / 2 entries.
  virtual double Value(const double* x) const = 0;
  virtual void Gradient(const double* x, double* gradient) const = 0;
  virtual void Hessian(const double* x, double* hessian) const = 0;

 private:
  std::vector<int> variables_;
};

// The term f(v), where f has `template <typename T> T operator()(const T* v) const` and v are the N variables in the
// order given.
template <int N, typename F>
class FunctorTerm final : public Term {
 public:
  FunctorTerm(const std::array<int, N>& variables, F f)
      : Term({variables.begin(), variables.end()}), f_(std::move(f)) {}

  double Value(const double* x) const override {
    std::array<double, N> v;
    for (int i = 0; i < N; ++i) v[i] = x[Variables()[i]];
    return f_(v.data());
  }

  void Gradient(const double* x, double* gradient) const override {
    using First = ceres::Jet<double, N>;
    std::array<First, N> v;
    for (int i = 0; i < N; ++i) v[i] = First(x[Variables()[i]], i);
    const First f = f_(v.data());
    for (int i = 0; i < N; ++i) gradient[i] = f.v[i];
  }

  void Hessian(const double* x, double* hessian) const override {
    using First = ceres::Jet<double, N>;
    std::array<SecondOrder<N>, N> v;
    for (int i = 0; i < N; ++i) v[i] = SecondOrder<N>(First(x[Variables()[i]], i), i);
    const SecondOrder<N> f = f_(v.data());
    for (int i = 0; i < N; ++i)
      for (int j = 0; j <= i; ++j) *hessian++ = f.v[i].v[j];
  }

 private:
  F f_;
};

}  // namespace lake::nlp
