// Why no design satisfies a problem, and the smallest change that would allow one.
//
// Every limit gets a slack and the sum of slacks is minimised (elastic program, l1 penalty; Chinneck, "Feasibility and
// Infeasibility in Optimization", 2008). First the requirements give way; if that is not enough, bounds and d_min too.
// The limits with a nonzero multiplier at that optimum are in conflict: the multipliers are a local proof that they
// cannot hold together.
#pragma once

#include <string>
#include <vector>

#include "lake/synthesis/optimize.h"

namespace lake::synthesis {

struct Relaxation {
  std::string text;  // the limit as posed
  double limit = 0, relaxed = 0;
  std::string unit;
};

struct InfeasibilityReport {
  bool solved = false;                  // false: not even the elastic program has a solution that holds
  linkage::Links links;                 // the design nearest to feasible
  std::vector<Relaxation> relaxations;  // the smallest change; empty: the problem is feasible after all
  std::vector<std::string> fighting;    // limits that cannot hold together
  std::string sentence;                 // all of it in words
};

// Three significant digits, upwards, with room for the solver: what a message proposes.
double RoundedUp(double value);

InfeasibilityReport AnalyseInfeasibility(const problem::SynthesisProblem& problem, const OptimizeOptions& options = {});

}  // namespace lake::synthesis
