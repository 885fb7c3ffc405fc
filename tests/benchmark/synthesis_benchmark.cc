// The synthesis problem by Ipopt on the loop equations (ours) and by NLopt on the closed form, from the same 20 starts:
// SLSQP (gradient), ISRES (global, with constraints) and CRS2 (global, constraints as a penalty). Counters: best
// feasible range, how many of the starts came within 0.01 deg of the best that is known, evaluations per start; time is
// per start. Then the certificate's time on one core, of margins, of random problems, and of those with limits over the
// used range.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <nlopt.hpp>
#include <vector>

#include "lake/certificate/certificate.h"
#include "lake/core/angles.h"
#include "lake/problem/problem_file.h"
#include "lake/synthesis/optimize.h"
#include "linkage/independent_routes.h"
#include "places.h"
#include "synthesis/random_problem.h"

namespace {

using namespace lake;
constexpr int kStarts = 20, kMostEvaluations = 20000;

problem::SynthesisProblem WithMargins(double margin_mm) {
  problem::SynthesisProblem problem;
  problem.grashof_margin_mm = problem.singularity_margin_mm = margin_mm;
  return problem;
}

std::vector<linkage::Links> Starts(const problem::SynthesisProblem& problem) {
  std::vector<linkage::Links> starts = synthesis::RandomStarts(problem, kStarts - 1, 1);
  starts.insert(starts.begin(), problem.start);
  return starts;
}

// theta(X, d_min) in degrees for NLopt. Where the linkage cannot be assembled there is no angle: minus the gap instead.
struct ClosedForm {
  problem::SynthesisProblem problem;
  std::vector<problem::Requirement> requirements;
  bool penalty = false;  // constraints become part of the objective
  int evaluations = 0;

  static double Slack(const problem::Requirement& requirement, const problem::SynthesisProblem& problem,
                      const std::vector<double>& x, std::vector<double>* gradient) {
    if (requirement.name == "singularity") {
      const double l7 = std::hypot(x[4], x[5]);
      if (gradient && !gradient->empty()) *gradient = {0, 1, 0, 0, -x[4] / l7, -x[5] / l7};
      return x[1] + problem.d_min_mm - l7 - requirement.limit;
    }
    double sum = -requirement.limit;
    for (int i = 0; i < 6; ++i) sum += requirement.Info().coefficients[i] * x[i];
    if (gradient && !gradient->empty())
      gradient->assign(requirement.Info().coefficients.begin(), requirement.Info().coefficients.end());
    return sum;
  }

  static double Objective(const std::vector<double>& x, std::vector<double>& gradient, void* self_pointer) {
    auto& self = *static_cast<ClosedForm*>(self_pointer);
    ++self.evaluations;
    const linkage::Links links{x[0], x[1], x[2], x[3], x[4], x[5]};
    const auto pose = linkage::SolvePose(links, self.problem.d_min_mm);
    std::ranges::fill(gradient, 0.0);
    double value =
        pose ? DegreesFromRadians(pose->theta_rad) : -linkage::FindAssemblyGap(links, self.problem.d_min_mm)->gap_mm;
    if (pose && !gradient.empty()) {
      const AngleDerivatives slopes = AngleDerivativesOf(links, *pose);
      for (int i = 0; i < 6; ++i) {
        const double slope = DegreesFromRadians(slopes.link[i]);
        gradient[i] = std::isfinite(slope) ? slope : 0;
      }
    }
    constexpr double kPenalty_deg_per_mm = 100;
    for (const problem::Requirement& requirement : self.requirements)
      if (self.penalty) value += kPenalty_deg_per_mm * std::min(0.0, Slack(requirement, self.problem, x, nullptr));
    return value;
  }
};

struct Constraint {
  const problem::Requirement* requirement;
  const problem::SynthesisProblem* problem;
  static double Value(const std::vector<double>& x, std::vector<double>& gradient, void* self_pointer) {
    const auto& self = *static_cast<Constraint*>(self_pointer);
    const double slack = ClosedForm::Slack(*self.requirement, *self.problem, x, &gradient);
    for (double& slope : gradient) slope = -slope;
    return -slack;
  }
};

// The end of one NLopt run.
linkage::Links SolveWithNlopt(ClosedForm& form, nlopt::algorithm algorithm, const linkage::Links& start) {
  nlopt::opt solver(algorithm, 6);
  std::vector<double> lower, upper, x;
  for (int i = 0; i < 6; ++i) {
    lower.push_back(form.problem.bounds[i].lower);
    upper.push_back(form.problem.bounds[i].upper);
    x.push_back(start.Values()[i]);
  }
  solver.set_lower_bounds(lower);
  solver.set_upper_bounds(upper);
  solver.set_max_objective(ClosedForm::Objective, &form);
  std::vector<Constraint> constraints;
  constraints.reserve(form.requirements.size());
  if (!form.penalty)
    for (const problem::Requirement& requirement : form.requirements) {
      constraints.push_back({&requirement, &form.problem});
      solver.add_inequality_constraint(Constraint::Value, &constraints.back(), 1e-8);
    }
  solver.set_xtol_rel(1e-9);
  solver.set_maxeval(kMostEvaluations);
  double value = 0;
  try {
    solver.optimize(x, value);
  } catch (const std::exception&) {
    // NLopt throws when rounding stops progress; x is its best point.
  }
  return {x[0], x[1], x[2], x[3], x[4], x[5]};
}

void Report(benchmark::State& state, const std::vector<double>& ranges, double known_best, double evaluations) {
  constexpr double kReached_deg = 0.01;
  state.counters["best_deg"] = ranges.empty() ? NAN : *std::ranges::max_element(ranges);
  state.counters["reached"] = static_cast<double>(
      std::ranges::count_if(ranges, [&](double range) { return range > known_best - kReached_deg; }));
  state.counters["evaluations"] = evaluations / kStarts;
  state.counters["s_per_start"] =
      benchmark::Counter(kStarts, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

double KnownBest(const problem::SynthesisProblem& problem) {
  return synthesis::SolveFrom(problem, problem.start).evaluation.range_deg;
}

void Ipopt(benchmark::State& state) {
  const problem::SynthesisProblem problem = WithMargins(static_cast<double>(state.range(0)));
  std::vector<double> ranges;
  double iterations = 0;
  for (auto _ : state) {
    ranges.clear();
    iterations = 0;
    for (const linkage::Links& start : Starts(problem)) {
      const synthesis::LocalSolve solve = synthesis::SolveFrom(problem, start);
      if (solve.IsUsable()) ranges.push_back(solve.evaluation.range_deg);
      iterations += solve.iterations;
    }
  }
  Report(state, ranges, KnownBest(problem), iterations);
}

void Nlopt(benchmark::State& state, nlopt::algorithm algorithm, bool penalty) {
  ClosedForm form{WithMargins(static_cast<double>(state.range(0))), {}, penalty};
  form.requirements = problem::RequirementsOf(form.problem);
  std::vector<double> ranges;
  for (auto _ : state) {
    ranges.clear();
    form.evaluations = 0;
    nlopt::srand(1);
    for (const linkage::Links& start : Starts(form.problem)) {
      const problem::DesignEvaluation end = problem::Evaluate(SolveWithNlopt(form, algorithm, start), form.problem);
      if (end.IsFeasible()) ranges.push_back(end.range_deg);
    }
  }
  Report(state, ranges, KnownBest(form.problem), form.evaluations);
}

void Certify(benchmark::State& state, const problem::SynthesisProblem& problem, double range_deg) {
  certificate::Certificate certificate;
  for (auto _ : state) certificate = certificate::CertifyRange(problem, range_deg, {.threads = 1});
  state.counters["gap_deg"] = certificate.gap_deg;
  state.counters["boxes"] = static_cast<double>(certificate.boxes);
}

void CertificateTime(benchmark::State& state) {
  const problem::SynthesisProblem problem = WithMargins(static_cast<double>(state.range(0)));
  Certify(state, problem, KnownBest(problem));
}

void CertificateOfRandomProblem(benchmark::State& state) {
  static const std::vector<SolvedProblem> kProblems = RandomSolvedProblems(15);
  const SolvedProblem& solved = kProblems.at(static_cast<std::size_t>(state.range(0)));
  Certify(state, solved.problem, solved.range_deg);
}

void CertificateOfFile(benchmark::State& state, const char* name) {
  const problem::SynthesisProblem problem = problem::ReadProblem(SourceDir() / "calibration/problems" / name);
  synthesis::OptimizeOptions options;
  options.starts = 3;
  Certify(state, problem, synthesis::Optimize(problem, options).Best().evaluation.range_deg);
}

void Margins(benchmark::internal::Benchmark* benchmark) {
  for (const int margin : {0, 1, 5, 20}) benchmark->Arg(margin);
  benchmark->Unit(benchmark::kMillisecond)->Iterations(1)->UseRealTime();
}

BENCHMARK(Ipopt)->Apply(Margins);
BENCHMARK_CAPTURE(Nlopt, SLSQP, nlopt::LD_SLSQP, false)->Apply(Margins);
BENCHMARK_CAPTURE(Nlopt, ISRES, nlopt::GN_ISRES, false)->Apply(Margins);
BENCHMARK_CAPTURE(Nlopt, CRS2, nlopt::GN_CRS2_LM, true)->Apply(Margins);
BENCHMARK(CertificateTime)->Apply(Margins);
BENCHMARK(CertificateOfRandomProblem)->DenseRange(0, 14)->Unit(benchmark::kMillisecond)->Iterations(1)->UseRealTime();
BENCHMARK_CAPTURE(CertificateOfFile, buildable, "buildable.yaml")
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1)
    ->UseRealTime();
BENCHMARK_CAPTURE(CertificateOfFile, wearable, "wearable.yaml")
    ->Unit(benchmark::kMillisecond)
    ->Iterations(1)
    ->UseRealTime();

}  // namespace

BENCHMARK_MAIN();
