// Checks a design against a problem, in closed form and on a fine grid of the used range; independent of any solver.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "lake/problem/problem.h"

namespace lake::problem {

// A pose of the used range is named by its fraction: 0 standing, 1 at d_min; theta = standing + fraction (range -
// standing).
struct WorstPoint {
  double fraction = 0;  // along the load profile: of the rise, percent / 100
  double value = 0;     // in the requirement's unit
  int sample = -1;      // of the load profile
};

// What a row of kLimits limits, in one pose under one load: the worst of its ratios. NaN where there is no pose.
double ValueInPose(const linkage::Links& links, const SynthesisProblem& problem, std::size_t row, const PoseLoad& load,
                   const std::optional<linkage::Pose>& pose);

// A linkage over its used range, whose poses are found once for all requirements on them.
class UsedPoses {
 public:
  UsedPoses(const linkage::Links& links, const SynthesisProblem& problem);

  // nullopt if the linkage cannot be assembled at d_min or does not reach standing.
  const std::optional<linkage::UsedRange>& Range() const { return range_; }

  // The value of a requirement under the constant load at a fraction of the range, which there must be.
  double At(const Requirement& requirement, double fraction) const;

  // The local worst points of a requirement of the family kind, the global one first: over the used range the grid's,
  // refined by Brent's minimisation, of one where a person sits that pose alone; along the load profile those of its
  // samples that are not straighter than standing, NaN where they are bent more than the linkage can be. Empty without
  // a range. Throws std::logic_error for a requirement that is no family.
  std::vector<WorstPoint> WorstPoints(const Requirement& requirement);

 private:
  const std::vector<std::optional<linkage::Pose>>& Grid();

  const linkage::Links links_;
  const SynthesisProblem& problem_;
  std::optional<linkage::UsedRange> range_;
  std::vector<std::optional<linkage::Pose>> grid_;  // at even steps of the range; empty until they are asked for
};

constexpr double kHoldsTo = 1e-6;  // of a limit: within this violation a design counts as feasible

struct RequirementCheck {
  Requirement requirement;
  double value = 0;     // NaN if it cannot be evaluated: not assembled at d_min, or not able to stand
  double slack = 0;     // distance to the limit, positive if satisfied; -infinity if it cannot be evaluated
  double fraction = 1;  // where in the used range, or in the rise, a family is worst

  // In units of the limit where that exceeds one; negative if satisfied.
  double Violation() const { return -slack / std::max(1.0, requirement.limit); }
  bool Holds() const { return Violation() <= kHoldsTo; }
};

struct DesignEvaluation {
  std::optional<linkage::Pose> pose;  // at d_min; nullopt if it cannot be assembled there
  std::string gap;                    // then: the triangle that does not close, one sentence
  double range_deg = 0;               // theta(d_min), NaN without a pose
  double worst_range_deg = 0;  // of the builds within problem.robust_mm, -infinity if one cannot be assembled; else
                               // range_deg
  std::optional<double> stands_mm;       // the stroke at standing_deg, if the used range reaches it
  std::vector<RequirementCheck> checks;  // with problem.robust_mm each of the build that is worst in it
  double bound_violation_mm = 0;         // the worst link outside its bounds
  // Worst violation over requirements and bounds, in units of the limit where that exceeds one; infinite if it cannot
  // be assembled.
  double violation = 0;

  // Throws std::out_of_range where the problem has no such requirement.
  const RequirementCheck& CheckOf(std::string_view name) const;
  bool IsFeasible(double tolerance = kHoldsTo) const { return violation <= tolerance; }
};

DesignEvaluation Evaluate(const linkage::Links& links, const SynthesisProblem& problem);

// Evaluate(links, problem).IsFeasible(tolerance), quicker: it ends at the first requirement that does not hold.
bool IsFeasible(const linkage::Links& links, const SynthesisProblem& problem, double tolerance = kHoldsTo);

// The objective, to be maximised: the range in deg (with a tolerance, of the worst build) or the negative of the
// duration in s. NaN where it is undefined.
double GoalOf(const SynthesisProblem& problem, const DesignEvaluation& evaluation);

// Fast: bounds and the requirements that are closed form in X (linear, singularity, assembly at d_min, cap), no used
// range.
bool MeetsLinkRequirements(const linkage::Links& links, const SynthesisProblem& problem,
                           const std::vector<Requirement>& requirements, double tolerance_mm = 0);

}  // namespace lake::problem
