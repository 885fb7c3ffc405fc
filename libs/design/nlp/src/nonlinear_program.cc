#include "lake/nlp/nonlinear_program.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "lake/core/error.h"

namespace lake::nlp {
namespace {

void CheckBounds(const std::string& name, double lower, double upper) {
  if (!(lower <= upper)) throw Fail("'{}': lower bound {} is not below upper bound {}", name, lower, upper);
}

}  // namespace

int NonlinearProgram::AddVariable(std::string name, double start, double lower, double upper) {
  CheckBounds(name, lower, upper);
  if (!std::isfinite(start)) throw Fail("'{}': start {} is not finite", name, start);
  variables_.push_back({std::move(name), start, lower, upper});
  return static_cast<int>(variables_.size()) - 1;
}

int NonlinearProgram::AddRow(std::string name, double lower, double upper) {
  CheckBounds(name, lower, upper);
  rows_.push_back({std::move(name), lower, upper});
  return static_cast<int>(rows_.size()) - 1;
}

void NonlinearProgram::AddTerm(int row, std::unique_ptr<Term> term) {
  assert(row >= NlpTerm::kCost && row < static_cast<int>(rows_.size()));
  terms_.push_back({row, std::move(term)});
}

double NonlinearProgram::Cost(const std::vector<double>& x) const {
  double cost = 0;
  for (const NlpTerm& term : terms_)
    if (term.row == NlpTerm::kCost) cost += term.term->Value(x.data());
  return cost;
}

std::vector<double> NonlinearProgram::RowValues(const std::vector<double>& x) const {
  std::vector<double> values(rows_.size(), 0.0);
  for (const NlpTerm& term : terms_)
    if (term.row != NlpTerm::kCost) values[term.row] += term.term->Value(x.data());
  return values;
}

double NonlinearProgram::Violation(const std::vector<double>& x) const {
  double worst = 0;
  const std::vector<double> values = RowValues(x);
  for (std::size_t i = 0; i < rows_.size(); ++i)
    worst = std::max({worst, rows_[i].lower - values[i], values[i] - rows_[i].upper});
  for (std::size_t j = 0; j < variables_.size(); ++j)
    worst = std::max({worst, variables_[j].lower - x[j], x[j] - variables_[j].upper});
  return worst;
}

}  // namespace lake::nlp
