// The paper's numbers, and random designs that satisfy a problem.
#pragma once

#include <random>

#include "lake/problem/evaluate.h"
#include "lake/synthesis/optimize.h"
#include "published_links.h"

namespace lake {

inline problem::SynthesisProblem WithMargins(double margin_mm) {
  problem::SynthesisProblem problem;
  problem.grashof_margin_mm = problem.singularity_margin_mm = margin_mm;
  return problem;
}

// A design that satisfies the link requirements, by rejection; near `centre` if given.
inline linkage::Links RandomFeasible(const problem::SynthesisProblem& problem, std::mt19937_64& random,
                                     const linkage::Links* centre = nullptr, double spread_mm = 3) {
  const auto requirements = problem::RequirementsOf(problem);
  while (true) {
    std::array<double, 6> values{};
    for (std::size_t i = 0; i < 6; ++i) {
      const problem::Bounds& bounds = problem.bounds[i];
      const double low = centre ? std::max(bounds.lower, centre->Values()[i] - spread_mm) : bounds.lower;
      const double high = centre ? std::min(bounds.upper, centre->Values()[i] + spread_mm) : bounds.upper;
      values[i] = std::uniform_real_distribution(low, high)(random);
    }
    const linkage::Links links = linkage::Links::FromValues(values);
    if (problem::MeetsLinkRequirements(links, problem, requirements)) return links;
  }
}

// With what a builder asks beside the margins.
inline problem::SynthesisProblem Buildable() {
  problem::SynthesisProblem problem = WithMargins(2);
  problem.standing_deg = 5;
  problem.limits["max_force_n"] = 2000;
  problem.limits["min_transmission_deg"] = 10;
  return problem;
}

inline synthesis::OptimizeOptions Starts(int count) {
  synthesis::OptimizeOptions options;
  options.starts = count;
  return options;
}

}  // namespace lake
