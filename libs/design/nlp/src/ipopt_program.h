// The bridge between a NonlinearProgram and Ipopt's TNLP; private to this room, as Ipopt is.
#pragma once

#include <IpTNLP.hpp>
#include <exception>
#include <functional>
#include <vector>

#include "lake/nlp/solve.h"

namespace lake::nlp {

class IpoptProgram final : public Ipopt::TNLP {
 public:
  // Both must outlive this.
  IpoptProgram(const NonlinearProgram& program, NlpSolution& solution);

  // What our own code threw while Ipopt called it, if it did.
  std::exception_ptr Failure() const { return failure_; }

  bool get_nlp_info(Ipopt::Index& n, Ipopt::Index& m, Ipopt::Index& jacobian_entries, Ipopt::Index& hessian_entries,
                    IndexStyleEnum& style) override;
  bool get_bounds_info(Ipopt::Index n, double* x_lower, double* x_upper, Ipopt::Index m, double* lower,
                       double* upper) override;
  bool get_starting_point(Ipopt::Index n, bool init_x, double* x, bool init_z, double* z_lower, double* z_upper,
                          Ipopt::Index m, bool init_lambda, double* lambda) override;
  bool eval_f(Ipopt::Index n, const double* x, bool new_x, double& cost) override;
  bool eval_grad_f(Ipopt::Index n, const double* x, bool new_x, double* gradient) override;
  bool eval_g(Ipopt::Index n, const double* x, bool new_x, Ipopt::Index m, double* values) override;
  bool eval_jac_g(Ipopt::Index n, const double* x, bool new_x, Ipopt::Index m, Ipopt::Index entries, Ipopt::Index* rows,
                  Ipopt::Index* columns, double* values) override;
  bool eval_h(Ipopt::Index n, const double* x, bool new_x, double cost_factor, Ipopt::Index m, const double* lambda,
              bool new_lambda, Ipopt::Index entries, Ipopt::Index* rows, Ipopt::Index* columns,
              double* values) override;
  bool intermediate_callback(Ipopt::AlgorithmMode mode, Ipopt::Index iteration, double cost, double violation,
                             double dual_infeasibility, double barrier, double step, double regularization,
                             double dual_step, double primal_step, Ipopt::Index trials, const Ipopt::IpoptData* data,
                             Ipopt::IpoptCalculatedQuantities* quantities) override;
  void finalize_solution(Ipopt::SolverReturn status, Ipopt::Index n, const double* x, const double* z_lower,
                         const double* z_upper, Ipopt::Index m, const double* values, const double* lambda, double cost,
                         const Ipopt::IpoptData* data, Ipopt::IpoptCalculatedQuantities* quantities) override;

 private:
  // Runs `work`; an exception is kept for later, as it must not pass through Ipopt. False if there was one or a value
  // is not finite.
  bool Guard(const std::function<bool()>& work);

  // grad f + J'y, by which the multipliers and the stationarity are judged.
  std::vector<double> LagrangianGradient(const double* x, const double* lambda) const;

  const NonlinearProgram& program_;
  NlpSolution& solution_;
  std::exception_ptr failure_;
  mutable std::vector<double> scratch_;
};

}  // namespace lake::nlp
