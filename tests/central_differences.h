// Compares the derivatives of a nonlinear program's terms with central differences.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "lake/nlp/nonlinear_program.h"

namespace lake {

// A line for each entry of gradient and Hessian that differs by more than `tolerance` of it, or of 1 where it is
// smaller.
inline std::string WrongDerivatives(const nlp::Term& term, std::vector<double> x, double tolerance = 1e-6) {
  const std::size_t n = term.Variables().size();
  std::vector<double> gradient(n), below(n), above(n), hessian(n * (n + 1) / 2);
  term.Gradient(x.data(), gradient.data());
  term.Hessian(x.data(), hessian.data());
  std::string wrong;
  const auto compare = [&](const std::string& what, double exact, double difference) {
    if (!(std::abs(exact - difference) <= tolerance * std::max(1.0, std::abs(exact))))
      wrong += fmt::format("{} of {}: {} ~ {}\n", what, term.Value(x.data()), exact, difference);
  };
  for (std::size_t i = 0, entry = 0; i < n; ++i) {
    double& moved = x[static_cast<std::size_t>(term.Variables()[i])];
    const double at = moved, step = 1e-5 * std::max(1.0, std::abs(at));
    moved = at - step;
    const double value_below = term.Value(x.data());
    term.Gradient(x.data(), below.data());
    moved = at + step;
    const double value_above = term.Value(x.data());
    term.Gradient(x.data(), above.data());
    moved = at;
    compare(fmt::format("d/d{}", i), gradient[i], (value_above - value_below) / (2 * step));
    for (std::size_t j = 0; j <= i; ++j)
      compare(fmt::format("d2/d{}d{}", i, j), hessian[entry++], (above[j] - below[j]) / (2 * step));
  }
  return wrong;
}

inline std::vector<double> StartOf(const nlp::NonlinearProgram& program) {
  std::vector<double> start;
  for (const nlp::NlpVariable& variable : program.Variables()) start.push_back(variable.start);
  return start;
}

// Of all terms, at the program's start.
inline std::string WrongDerivatives(const nlp::NonlinearProgram& program, double tolerance = 1e-6) {
  const std::vector<double> start = StartOf(program);
  std::string wrong;
  for (const nlp::NlpTerm& term : program.Terms())
    if (const std::string of_term = WrongDerivatives(*term.term, start, tolerance); !of_term.empty())
      wrong += (term.row == nlp::NlpTerm::kCost ? "cost" : program.Rows()[static_cast<std::size_t>(term.row)].name) +
               ": " + of_term;
  return wrong;
}

}  // namespace lake
