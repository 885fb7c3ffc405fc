#include "exchange.h"

#include <algorithm>
#include <cmath>

#include "lake/problem/evaluate.h"

namespace lake::synthesis {

std::vector<double> FirstFractions() {
  return {0.25, 0.5, 0.75};
}

namespace {

// A pose between each two neighbours, both ends of the used range included.
void HalveGaps(std::vector<double>& fractions) {
  std::vector<double> all = fractions;
  all.push_back(0), all.push_back(1);
  std::sort(all.begin(), all.end());
  for (std::size_t i = 1; i < all.size(); ++i) fractions.push_back((all[i - 1] + all[i]) / 2);
}

}  // namespace

bool AddViolatedPoses(const problem::SynthesisProblem& problem, const linkage::Links& links, double tolerance,
                      std::vector<double>& fractions) {
  constexpr double kSamePose = 1e-6;
  constexpr std::size_t kMostPoses = 200;
  const auto is_known = [&](double fraction) {
    return fraction < kSamePose || fraction > 1 - kSamePose ||
           std::any_of(fractions.begin(), fractions.end(),
                       [&](double known) { return std::abs(known - fraction) < kSamePose; });
  };
  const std::size_t before = fractions.size();
  for (const problem::Requirement& requirement : problem::RequirementsOf(problem)) {
    if (!requirement.NeedsStanding()) continue;
    const std::vector<problem::WorstPoint> worst = problem::WorstPoints(links, problem, requirement);
    if (worst.empty() && before < kMostPoses) {  // between two poses the linkage turns back or comes apart
      HalveGaps(fractions);
      return true;
    }
    if (!requirement.IsFamily()) continue;
    for (const problem::WorstPoint& point : worst)
      if (requirement.Slack(point.value) < -tolerance * requirement.limit && !is_known(point.fraction))
        fractions.push_back(point.fraction);
  }
  return fractions.size() > before;
}

}  // namespace lake::synthesis
