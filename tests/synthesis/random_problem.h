// Problems with bounds and margins unlike the paper's.
#pragma once

#include <random>
#include <vector>

#include "lake/synthesis/optimize.h"

namespace lake {

// Most are not feasible.
inline problem::SynthesisProblem RandomProblem(std::mt19937_64& random) {
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  problem::SynthesisProblem problem;
  for (std::size_t i = 0; i < 4; ++i) {
    problem.bounds[i].lower = uniform(30, 75);
    problem.bounds[i].upper = problem.bounds[i].lower + uniform(0, 40);
  }
  problem.bounds[4].lower = uniform(20, 100);
  problem.bounds[4].upper = problem.bounds[4].lower + uniform(0, 60);
  problem.bounds[5].lower = uniform(150, 280);
  problem.bounds[5].upper = problem.bounds[5].lower + uniform(0, 80);
  problem.grashof_margin_mm = uniform(0, 5) * (random() % 2);
  problem.singularity_margin_mm = uniform(0, 5) * (random() % 2);
  problem.d_min_mm = uniform(200, 270);
  return problem;
}

struct SolvedProblem {
  problem::SynthesisProblem problem;
  double range_deg;
};

// The first feasible ones of a fixed sequence, with the best range that six starts find.
inline std::vector<SolvedProblem> RandomSolvedProblems(std::size_t count) {
  std::mt19937_64 random(20261137);
  std::vector<SolvedProblem> solved;
  synthesis::OptimizeOptions options;
  options.starts = 6;
  while (solved.size() < count) {
    const problem::SynthesisProblem problem = RandomProblem(random);
    const synthesis::SynthesisResult result = synthesis::Optimize(problem, options);
    if (result.IsSolved()) solved.push_back({problem, result.Best().evaluation.range_deg});
  }
  return solved;
}

}  // namespace lake
