#include "lake/synthesis/at_its_pace.h"

#include <cmath>

#include "lake/problem/assistance.h"

namespace lake::synthesis {

void SolveAtItsPace(problem::SynthesisProblem& problem,
                    const std::function<std::optional<linkage::Links>(const problem::SynthesisProblem&)>& solve) {
  constexpr int kMostRounds = 12;
  constexpr double kSame = 2e-6;
  const bool has_pace = problem.HasLoadProfile() && problem.profile->HasPace();
  const auto take = [&](double duration_s) { problem.profile = problem::AtPace(*problem.profile, duration_s); };
  if (has_pace && problem.duration_s) take(*problem.duration_s);
  std::optional<linkage::Links> links = solve(problem);
  if (!has_pace || problem.duration_s) return;
  if (!links) {
    const double given_s = problem.profile->moments_s;
    take(problem::SynthesisProblem::kLongestDuration_s);
    links = solve(problem);
    if (!links) {
      take(given_s);
      solve(problem);
      return;
    }
  }
  for (int round = 1; links && round < kMostRounds; ++round) {
    const double shortest_s = problem::DurationUnderMoments(*links, problem);
    const double duration_s = std::isfinite(shortest_s) && shortest_s > 0 ? shortest_s : problem.profile->duration_s;
    if (std::abs(duration_s / problem.profile->moments_s - 1) < kSame) return;
    take(duration_s);
    links = solve(problem);
  }
}

}  // namespace lake::synthesis
