#include "exchange.h"

#include <algorithm>
#include <cmath>

#include "lake/problem/assistance.h"
#include "lake/problem/evaluate.h"

namespace lake::synthesis {

Collocation FirstPoses(const problem::SynthesisProblem& problem) {
  Collocation poses{0.25, 0.5, 0.75};
  if (!problem.HasLoadProfile()) return poses;
  constexpr std::size_t kSteps = 8;
  const std::vector<int> samples = problem::SamplesInUse(problem);
  for (std::size_t i = 0; i <= kSteps; ++i) {
    const int sample = samples[i * (samples.size() - 1) / kSteps];
    if (poses.samples.empty() || poses.samples.back() != sample) poses.samples.push_back(sample);
  }
  return poses;
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
                      Collocation& poses) {
  constexpr double kSamePose = 1e-6;
  std::vector<double>& fractions = poses.fractions;
  constexpr std::size_t kMostPoses = 200;
  const auto is_known = [&](const problem::WorstPoint& point) {
    if (point.sample >= 0) return std::ranges::find(poses.samples, point.sample) != poses.samples.end();
    const double fraction = point.fraction;
    return fraction < kSamePose || fraction > 1 - kSamePose ||
           std::any_of(fractions.begin(), fractions.end(),
                       [&](double known) { return std::abs(known - fraction) < kSamePose; });
  };
  const std::size_t before = poses.Size();
  for (const problem::Requirement& requirement : problem::RequirementsOf(problem)) {
    if (!requirement.NeedsStanding()) continue;
    const std::vector<problem::WorstPoint> worst = problem::WorstPoints(links, problem, requirement);
    if (worst.empty() && before < kMostPoses) {  // between two poses the linkage turns back or comes apart
      HalveGaps(fractions);
      return true;
    }
    if (!requirement.IsFamily()) continue;
    for (const problem::WorstPoint& point : worst) {
      if (requirement.Slack(point.value) >= -tolerance * requirement.limit || is_known(point)) continue;
      if (point.sample >= 0)
        poses.samples.push_back(point.sample);
      else
        fractions.push_back(point.fraction);
    }
  }
  return poses.Size() > before;
}

}  // namespace lake::synthesis
