#include "lake/nlp/solve.h"

#include <malloc.h>

#include <IpIpoptApplication.hpp>

#include "ipopt_program.h"
#include "lake/core/error.h"

namespace lake::nlp {
namespace {

using Ipopt::SmartPtr;

template <typename Value>
void Set(Ipopt::IpoptApplication& ipopt, const std::string& option, const Value& value) {
  bool known = false;
  if constexpr (std::is_same_v<Value, double>)
    known = ipopt.Options()->SetNumericValue(option, value);
  else if constexpr (std::is_same_v<Value, int>)
    known = ipopt.Options()->SetIntegerValue(option, value);
  else
    known = ipopt.Options()->SetStringValue(option, value);
  if (!known) throw Fail("Ipopt does not take its option {} = {}", option, value);
}

// By default the C library gives the heap's free end back to the system soon, which clears its pages anew when they are
// next asked for. MUMPS takes and frees its workspace in each factorization: a third of the processor time was this.
void KeepFreedMemory() {
  constexpr int kLargestFromHeap = 32 << 20, kMostKept = 64 << 20;  // bytes; the first is the largest glibc takes
  mallopt(M_MMAP_THRESHOLD, kLargestFromHeap);
  mallopt(M_TRIM_THRESHOLD, kMostKept);
}

SmartPtr<Ipopt::IpoptApplication> CreateIpopt() {
  KeepFreedMemory();
  SmartPtr<Ipopt::IpoptApplication> ipopt = new Ipopt::IpoptApplication(false);
  // An empty name: an ipopt.opt that happens to lie in the working directory must not change results.
  if (ipopt->Initialize("") != Ipopt::Solve_Succeeded) throw Fail("Ipopt cannot be set up");
  Set(*ipopt, "sb", std::string("yes"));
  Set(*ipopt, "nlp_scaling_method", std::string("none"));  // programs come in natural units
  // Bounds are kept as they are: a relaxed bound would let lengths leave their range.
  Set(*ipopt, "bound_relax_factor", 0.0);
  Set(*ipopt, "honor_original_bounds", std::string("yes"));
  return ipopt;
}

NlpStatus StatusOf(Ipopt::ApplicationReturnStatus status) {
  switch (status) {
    case Ipopt::Solve_Succeeded:
      return NlpStatus::kSolved;
    case Ipopt::Infeasible_Problem_Detected:
      return NlpStatus::kLocallyInfeasible;
    case Ipopt::Maximum_Iterations_Exceeded:
      return NlpStatus::kIterationLimit;
    case Ipopt::Solved_To_Acceptable_Level:
    case Ipopt::Search_Direction_Becomes_Too_Small:
    case Ipopt::Restoration_Failed:
      return NlpStatus::kStalled;
    default:
      return NlpStatus::kFailed;
  }
}

// A program that Ipopt would refuse with a status that says little.
void CheckDegreesOfFreedom(const NonlinearProgram& program) {
  std::size_t free = 0, equalities = 0;
  for (const NlpVariable& variable : program.Variables()) free += variable.lower < variable.upper;
  for (const NlpRow& row : program.Rows()) equalities += row.lower == row.upper;
  if (free == 0 || equalities > free)
    throw Fail("the program has {} free variables for {} equations", free, equalities);
}

}  // namespace

void NlpOptions::Check() const {
  if (!(tolerance > 0 && tolerance < 1)) throw Fail("solver tolerance {} must be between 0 and 1", tolerance);
  if (max_iterations < 0) throw Fail("iteration limit {} is negative", max_iterations);
  if (max_restoration_iterations && *max_restoration_iterations < 0)
    throw Fail("limit {} of iterations of the restoration phase is negative", *max_restoration_iterations);
  if (!(start_push > 0) || !(start_barrier > 0)) throw Fail("start_push and start_barrier must be positive");
}

std::string_view NameOf(NlpStatus status) {
  switch (status) {
    case NlpStatus::kSolved:
      return "solved";
    case NlpStatus::kLocallyInfeasible:
      return "locally infeasible";
    case NlpStatus::kIterationLimit:
      return "iteration limit";
    case NlpStatus::kStalled:
      return "stalled";
    case NlpStatus::kFailed:
      return "failed";
  }
  return "";
}

NlpSolution SolveNlp(const NonlinearProgram& program, const NlpOptions& options) {
  options.Check();
  CheckDegreesOfFreedom(program);
  const auto ipopt = CreateIpopt();
  Set(*ipopt, "print_level", 0);
  Set(*ipopt, "tol", options.tolerance);
  Set(*ipopt, "constr_viol_tol", options.tolerance);
  Set(*ipopt, "acceptable_iter", 0);  // no early end at a looser tolerance
  Set(*ipopt, "max_iter", options.max_iterations);
  if (options.max_restoration_iterations) Set(*ipopt, "max_resto_iter", *options.max_restoration_iterations);
  Set(*ipopt, "bound_push", options.start_push);
  Set(*ipopt, "bound_frac", options.start_push);
  Set(*ipopt, "mu_init", options.start_barrier);
  // Of many people, whose parts meet in the links alone: MUMPS's own choice of ordering does not see these dense
  // columns and fills 3 GB for a hundred people, where quasi-dense minimum degree takes 0.14 GB; and of what it expects
  // to need Ipopt has it take eleven times as much.
  constexpr std::size_t kMany = 2000;
  constexpr int kQuasiDense = 6;
  if (program.Variables().size() > kMany) {
    Set(*ipopt, "mumps_pivot_order", kQuasiDense);
    Set(*ipopt, "mumps_mem_percent", 100);
  }

  NlpSolution solution;
  const SmartPtr<IpoptProgram> bridge = new IpoptProgram(program, solution);
  const Ipopt::ApplicationReturnStatus status = ipopt->OptimizeTNLP(GetRawPtr(bridge));
  if (bridge->Failure()) std::rethrow_exception(bridge->Failure());
  solution.status = StatusOf(status);
  if (solution.x.empty())  // ended before its first iteration
    for (const NlpVariable& variable : program.Variables()) solution.x.push_back(variable.start);
  solution.message =
      fmt::format("{} after {} iterations: cost {:.9g}, violation {:.1e}, KKT error {:.1e}", NameOf(solution.status),
                  solution.iterations.size(), solution.cost, solution.violation, solution.kkt_error);
  return solution;
}

}  // namespace lake::nlp
