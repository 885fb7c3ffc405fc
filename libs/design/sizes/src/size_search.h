// The search for sizes: designs and who wears them are assigned to each other in turn, and what was solved is kept.
#pragma once

#include <array>
#include <map>
#include <utility>
#include <vector>

#include "lake/core/numbers.h"
#include "lake/group/group_design.h"
#include "lake/sizes/sizes.h"

namespace lake::sizes {

using group::DesignTask;
using group::GroupOutcome;
using redesign::GroupProblem;
using redesign::RedesignPoint;

using Assignment = std::vector<std::size_t>;  // the size of each person
using Fits = std::vector<std::vector<Fit>>;   // per person and size

std::vector<std::size_t> MembersOf(const Assignment& sizes, std::size_t size);

template <typename T>
std::vector<T> Picked(const std::vector<T>& all, const std::vector<std::size_t>& indices) {
  std::vector<T> picked;
  for (const std::size_t i : indices) picked.push_back(all[i]);
  return picked;
}

GroupProblem ProblemOf(const GroupProblem& all, const std::vector<std::size_t>& members);

// From one process to another.
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Fit, holds, value, percent, range_deg)

// Designs for an assignment, and what each is to each person.
struct Alternation {
  Assignment assignment;
  std::vector<GroupOutcome> designs;
  Fits fits;

  double Value() const;  // of the goal, mean over people
};

class SizeSearch {
 public:
  // `human`: of each person; `links`: where designs start. Keeps the problem.
  SizeSearch(const GroupProblem& problem, const std::vector<compare::StsCurve>& human,
             const std::vector<linkage::Links>& links, std::size_t sizes, const synthesis::OptimizeOptions& options)
      : problem_(problem), human_(human), links_(links), sizes_(sizes), options_(options) {}

  // From few starts, each round from the one before, for as long as it gets better.
  Alternation Alternate(const Assignment& first);

  // Designs from all starts, or from those of `found`, and on from there until everybody wears the size that is best
  // for them; whether it came to that.
  enum class From { kAllStarts, kFound };
  bool Settle(From from, Alternation& found);

 private:
  using Members = std::vector<std::size_t>;

  Alternation DesignFor(const Assignment& assignment, const Alternation& before, From from, int starts);
  DesignTask TaskFor(const Members& members, std::size_t size, const Alternation& before, From from) const;
  std::vector<RedesignPoint> PointsBefore(const Members& members, std::size_t size, const Alternation& before) const;
  void FindFits(Alternation& found);
  Assignment BestOf(const Alternation& found) const;

  const GroupProblem problem_;
  const std::vector<compare::StsCurve>& human_;
  const std::vector<linkage::Links>& links_;
  const std::size_t sizes_;
  const synthesis::OptimizeOptions options_;
  std::map<std::pair<int, Members>, GroupOutcome> designs_;            // by starts and who wears it
  std::map<std::pair<std::size_t, std::array<double, 6>>, Fit> fits_;  // by person and links
};

}  // namespace lake::sizes
