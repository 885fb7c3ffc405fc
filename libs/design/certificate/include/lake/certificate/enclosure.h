// A function of a few variables over a box, with first and second derivatives, in verified arithmetic: what the terms
// of a nonlinear program are templates over, so that they can be enclosed as well as differentiated.
#pragma once

#include <array>
#include <span>

#include "lake/certificate/interval.h"
#include "lake/nlp/nonlinear_program.h"

namespace lake::certificate {

class Enclosure {
 public:
  static constexpr int kMost = 14;  // variables of one term

  Enclosure() = default;
  Enclosure(double constant) : value(constant) {}  // NOLINT: a number is a function that does not change
  static Enclosure Variable(int index, int count, const Interval& range);

  const Interval& Second(int i, int j) const { return second[Place(i, j)]; }

  Interval value;
  int count = 0;  // of variables; the derivatives of a constant are left out
  std::array<Interval, kMost> first{};
  std::array<Interval, kMost*(kMost + 1) / 2> second{};

  static std::size_t Place(int i, int j) {
    return static_cast<std::size_t>(i >= j ? i * (i + 1) / 2 + j : j * (j + 1) / 2 + i);
  }
};

Enclosure operator-(const Enclosure& a);
Enclosure operator+(const Enclosure& a, const Enclosure& b);
Enclosure operator-(const Enclosure& a, const Enclosure& b);
Enclosure operator*(const Enclosure& a, const Enclosure& b);
Enclosure operator/(const Enclosure& a, const Enclosure& b);
Enclosure& operator+=(Enclosure& a, const Enclosure& b);
Enclosure sin(const Enclosure& a);   // NOLINT: as the terms call it
Enclosure cos(const Enclosure& a);   // NOLINT
Enclosure sqrt(const Enclosure& a);  // NOLINT

// A term that can be enclosed.
class Enclosable {
 public:
  virtual ~Enclosable() = default;
  // `x`: a box of the whole program.
  virtual Enclosure Enclose(std::span<const Interval> x) const = 0;
};

template <int N, typename F>
class EnclosedTerm final : public nlp::FunctorTerm<N, F>, public Enclosable {
  static_assert(N <= Enclosure::kMost);

 public:
  EnclosedTerm(const std::array<int, N>& variables, F f) : nlp::FunctorTerm<N, F>(variables, f), f_(std::move(f)) {}

  Enclosure Enclose(std::span<const Interval> x) const override {
    std::array<Enclosure, N> v;
    for (int i = 0; i < N; ++i) v[i] = Enclosure::Variable(i, N, x[this->Variables()[i]]);
    return f_(v.data());
  }

 private:
  F f_;
};

}  // namespace lake::certificate
