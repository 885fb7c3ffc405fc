#include "exchange.h"

#include <algorithm>
#include <cmath>

#include "lake/synthesis/evaluate.h"

namespace lake {

std::vector<double> FirstFractions() { return {0.25, 0.5, 0.75}; }

bool AddViolatedPoses(const SynthesisProblem& problem, const Links& links, double tolerance,
                      std::vector<double>& fractions) {
  constexpr double kSamePose = 1e-6;
  const auto is_known = [&](double fraction) {
    return fraction < kSamePose || fraction > 1 - kSamePose ||
           std::any_of(fractions.begin(), fractions.end(),
                       [&](double known) { return std::abs(known - fraction) < kSamePose; });
  };
  const std::size_t before = fractions.size();
  for (const Requirement& requirement : RequirementsOf(problem)) {
    if (!requirement.IsFamily()) continue;
    for (const WorstPoint& point : WorstPoints(links, problem, requirement))
      if (requirement.Slack(point.value) < -tolerance * requirement.limit && !is_known(point.fraction))
        fractions.push_back(point.fraction);
  }
  return fractions.size() > before;
}

}  // namespace lake
