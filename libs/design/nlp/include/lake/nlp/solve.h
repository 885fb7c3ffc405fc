// Solves a nonlinear program with Ipopt (Wächter & Biegler, Math. Program. 106, 2006), a primal-dual interior-point
// method, with the exact Hessian of the Lagrangian. Not thread-safe: its linear solver MUMPS keeps global state, so
// solve one at a time.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lake/nlp/nonlinear_program.h"

namespace lake::nlp {

struct NlpOptions {
  double tolerance = 1e-9;     // of Ipopt's scaled optimality error
  int max_iterations = 500;    // no limit in seconds: that would make the result depend on the machine
  double start_push = 1e-2;    // a start on a bound is moved inside by this (Ipopt's bound_push); small for warm starts
  double start_barrier = 0.1;  // first barrier parameter; small for warm starts
  // Limit of consecutive iterations of the restoration phase; a solve that ends there has reached its iteration limit.
  // Absent: none.
  std::optional<int> max_restoration_iterations;

  // From near a solution.
  void StartWarm() {
    start_push = 1e-6;
    start_barrier = 1e-4;
  }

  // Throws Error for values that make no sense.
  void Check() const;
};

enum class NlpStatus { kSolved, kLocallyInfeasible, kIterationLimit, kStalled, kFailed };
std::string_view NameOf(NlpStatus status);

// One line of Ipopt's progress.
struct NlpIteration {
  int iteration;
  double cost, violation, dual_infeasibility, barrier, step;
};

struct NlpSolution {
  NlpStatus status = NlpStatus::kFailed;
  std::string message;    // one line: what Ipopt said, with the numbers that matter
  std::vector<double> x;  // the last point, feasible or not
  double cost = 0;
  double violation = 0;  // worst violation of a row or bound at x
  // Worst of stationarity |grad f + J'y - z|, complementarity and violation, in the program's own units; not Ipopt's
  // scaled error.
  double kkt_error = 0;
  // d cost / d bound at the optimum, in cost per unit of the row or variable. A row at its lower bound has a positive
  // one (raising the bound costs), at its upper bound a negative one.
  std::vector<double> row_marginal_costs, variable_marginal_costs;
  std::vector<NlpIteration> iterations;

  // Only a point that met the full tolerance is a solution; Ipopt's "acceptable level" is not.
  bool IsUsable() const { return status == NlpStatus::kSolved; }
};

// Throws Interrupted on a signal, and Error for a program that has no variable or more equality rows than free
// variables.
NlpSolution SolveNlp(const NonlinearProgram& program, const NlpOptions& options = {});

}  // namespace lake::nlp
