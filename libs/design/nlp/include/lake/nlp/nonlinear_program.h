// A sparse nonlinear program in standard form,
//
//   min  f(x) = sum of cost terms
//    x
//   s.t. lower_i <= c_i(x) <= upper_i      rows: constraints, each a sum of terms
//        lower_j <=   x_j  <= upper_j      variables
//
// built from named variables, rows and terms; every term brings its exact derivatives (term.h), so a program is changed
// by adding or leaving out pieces, never by editing a solver (the idea of ifopt and towr: Winkler et al., RA-L 2018).
#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "lake/nlp/term.h"

namespace lake::nlp {

inline constexpr double kUnbounded = std::numeric_limits<double>::infinity();

struct NlpVariable {
  std::string name;
  double start, lower, upper;
};

struct NlpRow {
  std::string name;
  double lower, upper;
};

// A term and the row it belongs to; kCost for the cost.
struct NlpTerm {
  static constexpr int kCost = -1;
  int row;
  std::unique_ptr<Term> term;
};

class NonlinearProgram {
 public:
  // Return the index. Throw Error if a number is NaN or lower > upper. A variable with lower = upper is held fixed.
  int AddVariable(std::string name, double start, double lower, double upper);
  int AddRow(std::string name, double lower, double upper);

  // Adds f(variables) to a row, or to the cost.
  template <std::size_t N, typename F>
  void AddTerm(int row, const std::array<int, N>& variables, F f) {
    AddTerm(row, std::make_unique<FunctorTerm<static_cast<int>(N), F>>(variables, std::move(f)));
  }
  template <std::size_t N, typename F>
  void AddCost(const std::array<int, N>& variables, F f) {
    AddTerm(NlpTerm::kCost, variables, std::move(f));
  }

  // A row of a single term; returns its index.
  template <std::size_t N, typename F>
  int AddConstraint(std::string name, double lower, double upper, const std::array<int, N>& variables, F f) {
    const int row = AddRow(std::move(name), lower, upper);
    AddTerm(row, variables, std::move(f));
    return row;
  }

  const std::vector<NlpVariable>& Variables() const { return variables_; }
  const std::vector<NlpRow>& Rows() const { return rows_; }
  const std::vector<NlpTerm>& Terms() const { return terms_; }

  double Cost(const std::vector<double>& x) const;
  std::vector<double> RowValues(const std::vector<double>& x) const;

  // The worst violation of a row or a bound at x.
  double Violation(const std::vector<double>& x) const;

 private:
  void AddTerm(int row, std::unique_ptr<Term> term);
  std::vector<NlpVariable> variables_;
  std::vector<NlpRow> rows_;
  std::vector<NlpTerm> terms_;
};

}  // namespace lake::nlp
