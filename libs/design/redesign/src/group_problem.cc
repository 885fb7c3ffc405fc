#include "lake/redesign/group_problem.h"

#include <algorithm>
#include <cmath>

#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"

namespace lake::redesign {

GroupProblem GroupProblem::OfOne(const RedesignProblem& problem) {
  return {problem, {{"", problem.human, problem.placement_mm}}};
}

RedesignProblem GroupProblem::Of(std::size_t person) const {
  RedesignProblem problem = shared;
  problem.human = people.at(person).human;
  problem.placement_mm = people[person].placement_mm;
  return problem;
}

std::size_t GroupProblem::Counting() const {
  if (across != Across::kQuantile) return people.size();
  constexpr double kRounding = 1e-9;  // 0.9 of 10 people are 9
  return static_cast<std::size_t>(std::ceil(quantile * static_cast<double>(people.size()) - kRounding));
}

double GroupProblem::Combine(const std::vector<double>& of_people) const {
  if (across == Across::kMean) return Mean(of_people);
  double largest = -kInfinity;
  for (std::size_t i = 0; i < of_people.size(); ++i)
    if (people[i].counts) largest = std::max(largest, of_people[i]);
  return largest;
}

void GroupProblem::CheckOptions() const {
  shared.CheckOptions();
  if (!(quantile > 0 && quantile <= 1)) throw UsageError("--quantile {}: above 0, at most 1", quantile);
}

void GroupProblem::Check() const {
  CheckOptions();
  if (people.empty()) throw Fail("a design for a group needs at least one person");
  if (people.size() > 1 && shared.design.clearances.AreAsked())
    throw Fail("clearances are from one person's body; omit them in a design for {} people", people.size());
  for (std::size_t i = 0; i < people.size(); ++i) Of(i).Check();
}

}  // namespace lake::redesign
