#include "ipopt_program.h"

#include <algorithm>
#include <cmath>

#include "lake/core/interrupt.h"

namespace lake::nlp {
namespace {

using Ipopt::Index;

constexpr double kIpoptInfinity = 2e19;  // beyond Ipopt's nlp_lower/upper_bound_inf

double ForIpopt(double bound) {
  return std::clamp(bound, -kIpoptInfinity, kIpoptInfinity);
}

std::size_t HessianSize(const Term& term) {
  const std::size_t n = term.Variables().size();
  return n * (n + 1) / 2;
}

bool IsFinite(const double* values, std::size_t count) {
  return std::all_of(values, values + count, [](double value) { return std::isfinite(value); });
}

// multiplier x distance, zero for a bound that is not there.
double Complementarity(double multiplier, double distance) {
  return std::isfinite(distance) ? std::abs(multiplier * distance) : 0.0;
}

}  // namespace

IpoptProgram::IpoptProgram(const NonlinearProgram& program, NlpSolution& solution)
    : program_(program), solution_(solution) {
  std::size_t largest = 1;
  for (const NlpTerm& term : program.Terms()) largest = std::max(largest, HessianSize(*term.term));
  scratch_.resize(largest);
}

bool IpoptProgram::Guard(const std::function<bool()>& work) {
  try {
    return work();
  } catch (...) {
    failure_ = std::current_exception();
    return false;
  }
}

bool IpoptProgram::get_nlp_info(Index& n, Index& m, Index& jacobian_entries, Index& hessian_entries,
                                IndexStyleEnum& style) {
  n = static_cast<Index>(program_.Variables().size());
  m = static_cast<Index>(program_.Rows().size());
  jacobian_entries = hessian_entries = 0;
  for (const NlpTerm& term : program_.Terms()) {
    if (term.row != NlpTerm::kCost) jacobian_entries += static_cast<Index>(term.term->Variables().size());
    hessian_entries += static_cast<Index>(HessianSize(*term.term));
  }
  style = C_STYLE;
  return true;
}

bool IpoptProgram::get_bounds_info(Index n, double* x_lower, double* x_upper, Index m, double* lower, double* upper) {
  for (Index j = 0; j < n; ++j) {
    x_lower[j] = ForIpopt(program_.Variables()[j].lower);
    x_upper[j] = ForIpopt(program_.Variables()[j].upper);
  }
  for (Index i = 0; i < m; ++i) {
    lower[i] = ForIpopt(program_.Rows()[i].lower);
    upper[i] = ForIpopt(program_.Rows()[i].upper);
  }
  return true;
}

bool IpoptProgram::get_starting_point(Index n, bool init_x, double* x, bool init_z, double* /*z_lower*/,
                                      double* /*z_upper*/, Index /*m*/, bool init_lambda, double* /*lambda*/) {
  for (Index j = 0; j < n; ++j) x[j] = program_.Variables()[j].start;
  return init_x && !init_z && !init_lambda;
}

bool IpoptProgram::eval_f(Index n, const double* x, bool /*new_x*/, double& cost) {
  return Guard([&] {
    cost = program_.Cost({x, x + n});
    return std::isfinite(cost);
  });
}

bool IpoptProgram::eval_grad_f(Index n, const double* x, bool /*new_x*/, double* gradient) {
  return Guard([&] {
    std::fill(gradient, gradient + n, 0.0);
    for (const NlpTerm& term : program_.Terms()) {
      if (term.row != NlpTerm::kCost) continue;
      term.term->Gradient(x, scratch_.data());
      const auto variables = term.term->Variables();
      for (std::size_t k = 0; k < variables.size(); ++k) gradient[variables[k]] += scratch_[k];
    }
    return IsFinite(gradient, n);
  });
}

bool IpoptProgram::eval_g(Index n, const double* x, bool /*new_x*/, Index m, double* values) {
  return Guard([&] {
    const std::vector<double> rows = program_.RowValues({x, x + n});
    std::copy(rows.begin(), rows.end(), values);
    return IsFinite(values, m);
  });
}

// Several terms may touch the same entry; Ipopt sums them.
bool IpoptProgram::eval_jac_g(Index /*n*/, const double* x, bool /*new_x*/, Index /*m*/, Index entries, Index* rows,
                              Index* columns, double* values) {
  return Guard([&] {
    Index entry = 0;
    for (const NlpTerm& term : program_.Terms()) {
      if (term.row == NlpTerm::kCost) continue;
      const auto variables = term.term->Variables();
      if (values) {
        term.term->Gradient(x, values + entry);
      } else {
        std::fill_n(rows + entry, variables.size(), term.row);
        std::copy(variables.begin(), variables.end(), columns + entry);
      }
      entry += static_cast<Index>(variables.size());
    }
    return !values || IsFinite(values, entries);
  });
}

bool IpoptProgram::eval_h(Index /*n*/, const double* x, bool /*new_x*/, double cost_factor, Index /*m*/,
                          const double* lambda, bool /*new_lambda*/, Index entries, Index* rows, Index* columns,
                          double* values) {
  return Guard([&] {
    Index entry = 0;
    for (const NlpTerm& term : program_.Terms()) {
      const auto variables = term.term->Variables();
      const auto size = static_cast<Index>(HessianSize(*term.term));
      if (values) {
        const double factor = term.row == NlpTerm::kCost ? cost_factor : lambda[term.row];
        term.term->Hessian(x, values + entry);
        for (Index k = 0; k < size; ++k) values[entry + k] *= factor;
      } else {
        Index k = entry;
        for (std::size_t i = 0; i < variables.size(); ++i)
          for (std::size_t j = 0; j <= i; ++j, ++k) {
            rows[k] = std::max(variables[i], variables[j]);
            columns[k] = std::min(variables[i], variables[j]);
          }
      }
      entry += size;
    }
    return !values || IsFinite(values, entries);
  });
}

bool IpoptProgram::intermediate_callback(Ipopt::AlgorithmMode /*mode*/, Index iteration, double cost, double violation,
                                         double dual_infeasibility, double barrier, double step,
                                         double /*regularization*/, double /*dual_step*/, double /*primal_step*/,
                                         Index /*trials*/, const Ipopt::IpoptData* /*data*/,
                                         Ipopt::IpoptCalculatedQuantities* /*quantities*/) {
  return Guard([&] {
    solution_.iterations.push_back({iteration, cost, violation, dual_infeasibility, barrier, step});
    ThrowIfInterrupted();
    return true;
  });
}

std::vector<double> IpoptProgram::LagrangianGradient(const double* x, const double* lambda) const {
  std::vector<double> gradient(program_.Variables().size(), 0.0);
  for (const NlpTerm& term : program_.Terms()) {
    term.term->Gradient(x, scratch_.data());
    const double factor = term.row == NlpTerm::kCost ? 1.0 : lambda[term.row];
    const auto variables = term.term->Variables();
    for (std::size_t k = 0; k < variables.size(); ++k) gradient[variables[k]] += factor * scratch_[k];
  }
  return gradient;
}

void IpoptProgram::finalize_solution(Ipopt::SolverReturn /*status*/, Index n, const double* x, const double* z_lower,
                                     const double* z_upper, Index m, const double* values, const double* lambda,
                                     double cost, const Ipopt::IpoptData* /*data*/,
                                     Ipopt::IpoptCalculatedQuantities* /*quantities*/) {
  Guard([&] {
    solution_.x.assign(x, x + n);
    solution_.cost = cost;
    solution_.violation = program_.Violation(solution_.x);
    solution_.row_marginal_costs.resize(m);
    solution_.variable_marginal_costs.resize(n);
    double worst = solution_.violation;
    const std::vector<double> gradient = LagrangianGradient(x, lambda);
    for (Index j = 0; j < n; ++j) {
      const NlpVariable& variable = program_.Variables()[j];
      const bool fixed = variable.lower == variable.upper;  // Ipopt gives no multiplier: stationarity does
      solution_.variable_marginal_costs[j] = fixed ? gradient[j] : z_lower[j] - z_upper[j];
      worst = std::max(worst, std::abs(gradient[j] - solution_.variable_marginal_costs[j]));
      if (fixed) continue;
      worst = std::max(worst, Complementarity(z_lower[j], x[j] - variable.lower));
      worst = std::max(worst, Complementarity(z_upper[j], variable.upper - x[j]));
    }
    for (Index i = 0; i < m; ++i) {
      const NlpRow& row = program_.Rows()[i];
      solution_.row_marginal_costs[i] = -lambda[i];
      const double distance = lambda[i] < 0 ? values[i] - row.lower : row.upper - values[i];
      if (row.lower != row.upper) worst = std::max(worst, Complementarity(lambda[i], distance));
    }
    solution_.kkt_error = worst;
    return true;
  });
}

}  // namespace lake::nlp
