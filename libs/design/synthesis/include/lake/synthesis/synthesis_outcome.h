// The outcome of a synthesis problem: its optimum with proof, sensitivity, margins, yield and rounding, or the reason
// why there is none.
#pragma once

#include <optional>
#include <vector>

#include "lake/certificate/certificate.h"
#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/problem/robustness.h"
#include "lake/synthesis/infeasibility.h"
#include "lake/synthesis/optimize.h"

namespace lake::synthesis {

struct SynthesisOptions {
  OptimizeOptions optimize;
  std::optional<double> certify_gap_deg;     // absent: no certificate
  std::optional<double> certify_time_s;      // absent: the search for a bound ends by its gap or its boxes alone
  std::optional<double> yield_tolerance_mm;  // absent: no yield
  std::optional<double> round_mm;            // absent: no rounding
  bool quiet = true;

  void Check() const;  // throws UsageError naming the option
};

// The problem's optimum with both margins set to one value, all else the same.
struct MarginPoint {
  double margin_mm = 0;
  bool solved = false;
  linkage::Links links;
  double range_deg = 0;         // NaN if not solved
  std::optional<double> yield;  // builds that keep every limit of the problem, if asked for
};

// A design whose limits hold for every build within a tolerance (robust_mm), and the yield of the tolerance asked for.
struct TolerantDesign {
  double robust_mm = 0;
  linkage::Links links;
  problem::DesignEvaluation evaluation;  // of the exact links, by the problem itself
  problem::Yield yield;
};

struct SynthesisOutcome {
  problem::SynthesisProblem problem;
  SynthesisOptions options;
  problem::DesignEvaluation start;  // of problem.start
  SynthesisResult result;
  std::optional<InfeasibilityReport> infeasible;  // if no start is usable
  // The rest is there if a start is usable.
  ActiveSet active;
  std::optional<certificate::Certificate> certificate;
  std::vector<problem::SensitivityPoint> sensitivity;
  std::vector<MarginPoint> margins;  // none where the duration is what is sought, or with a tolerance
  std::optional<problem::Yield> yield, start_yield;
  std::optional<TolerantDesign> tolerant;  // with a yield: whose builds keep the limits most often
  std::optional<problem::RoundedDesign> rounded;

  bool IsSolved() const { return result.IsSolved(); }
  // The optimum, or the design nearest to feasible.
  linkage::Links BestLinks() const { return IsSolved() ? result.Best().end : infeasible->links; }
};

// The options of an optimum: how it is sought, and with those how it is proved and judged.
void Describe(OptimizeOptions& o, OptionList& options);
void Describe(SynthesisOptions& o, OptionList& options);

// Throws Error for a problem or options that fail Check(), Interrupted on a signal.
SynthesisOutcome RunSynthesis(const problem::SynthesisProblem& problem, const SynthesisOptions& options);

// Of the tolerance that is asked for.
problem::Yield YieldOf(const linkage::Links& links, const problem::SynthesisProblem& problem,
                       const SynthesisOptions& options);

// A certificate for the range of an optimum. Where the bound does without requirements (certificate::NotInBound), the
// search aims at the optimum without these, as it cannot come below that.
certificate::Certificate CertifyOptimum(const problem::SynthesisProblem& problem, const linkage::Links& optimum,
                                        double range_deg, const certificate::CertificateOptions& certificate_options,
                                        const OptimizeOptions& options);

}  // namespace lake::synthesis
