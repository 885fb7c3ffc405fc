#include "exchange.h"

#include <algorithm>
#include <cmath>
#include <limits>

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
  all.push_back(0);
  all.push_back(1);
  std::sort(all.begin(), all.end());
  for (std::size_t i = 1; i < all.size(); ++i) fractions.push_back((all[i - 1] + all[i]) / 2);
}

constexpr std::size_t kMostPoses = 200;

bool IsKnown(const problem::WorstPoint& point, const Collocation& poses) {
  constexpr double kSamePose = 1e-6;
  if (point.sample >= 0) return std::ranges::find(poses.samples, point.sample) != poses.samples.end();
  return point.fraction < kSamePose || point.fraction > 1 - kSamePose ||
         std::ranges::any_of(poses.fractions,
                             [&](double known) { return std::abs(known - point.fraction) < kSamePose; });
}

// The poses at which one linkage violates the problem; false where it turns back or comes apart between two poses.
bool AddPosesOf(const problem::SynthesisProblem& problem, const std::vector<problem::Requirement>& requirements,
                const linkage::Links& links, double tolerance, Collocation& poses) {
  problem::UsedPoses used(links, problem);
  for (const problem::Requirement& requirement : requirements) {
    if (!requirement.NeedsStanding()) continue;
    if (!used.Range()) return false;
    if (!requirement.IsFamily()) continue;
    const std::vector<problem::WorstPoint> worst = used.WorstPoints(requirement);
    if (worst.empty()) return false;
    if (requirement.Info().place == problem::Place::kSeated) continue;  // one pose, which the program has already
    for (const problem::WorstPoint& point : worst) {
      const double allowed = tolerance * std::max(requirement.limit, requirement.IsClearance() ? 1.0 : 0.0);
      if (requirement.Slack(point.value) >= -allowed || IsKnown(point, poses)) continue;
      if (point.sample >= 0)
        poses.samples.push_back(point.sample);
      else
        poses.fractions.push_back(point.fraction);
    }
  }
  return true;
}

// The corner of the tolerance that violates the problem most, or else the one whose goal is less than that of all
// builds known.
bool AddWorstBuild(const problem::SynthesisProblem& problem, const linkage::Links& links, double tolerance,
                   Collocation& poses) {
  constexpr double kWorse_deg = 1e-6;
  const problem::BuildError* worst = nullptr;
  double worst_violation = 10 * tolerance, known_deg = std::numeric_limits<double>::infinity(), least_deg = known_deg;
  const problem::BuildError* least = nullptr;
  const std::vector<problem::BuildError> corners = problem::Corners(*problem.robust_mm);
  for (const problem::BuildError& corner : corners) {
    const problem::DesignEvaluation build =
        problem::Evaluate(problem::LinksOf(corner, links), problem::ProblemOf(corner, problem));
    const double range_deg = build.pose ? build.range_deg : -std::numeric_limits<double>::infinity();
    if (std::ranges::find(poses.builds, corner) != poses.builds.end()) {
      known_deg = std::min(known_deg, range_deg);
      continue;
    }
    if (build.violation > worst_violation) {
      worst_violation = build.violation;
      worst = &corner;
    }
    if (range_deg < least_deg) {
      least_deg = range_deg;
      least = &corner;
    }
  }
  if (!worst && least && least_deg < known_deg - kWorse_deg) worst = least;
  if (worst) poses.builds.push_back(*worst);
  return worst;
}

}  // namespace

bool AddViolatedPoses(const problem::SynthesisProblem& problem, const std::vector<problem::Requirement>& requirements,
                      const linkage::Links& links, double tolerance, Collocation& poses) {
  const std::size_t before = poses.Size();
  bool stand = AddPosesOf(problem, requirements, links, tolerance, poses);
  for (std::size_t i = 0; i < poses.builds.size(); ++i)
    stand = AddPosesOf(problem::ProblemOf(poses.builds[i], problem), requirements,
                       problem::LinksOf(poses.builds[i], links), tolerance, poses) &&
            stand;
  if (!stand && before < kMostPoses) HalveGaps(poses.fractions);
  if (poses.Size() > before) return true;
  return problem.robust_mm && AddWorstBuild(problem, links, tolerance, poses);
}

}  // namespace lake::synthesis
