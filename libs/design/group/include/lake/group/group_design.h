// The search for the links of a group, or of several independent groups.
#pragma once

#include <optional>
#include <vector>

#include "lake/group/group.h"

namespace lake::group {

// The same problem with these people's motions.
redesign::GroupProblem PutMotionsInto(redesign::GroupProblem problem, const std::vector<PersonMeasured>& people);

// Where to start: the problem's start, the optimum without people, and what was worn.
std::vector<linkage::Links> StartLinks(const redesign::GroupProblem& problem, const std::vector<PersonMeasured>& people,
                                       const synthesis::OptimizeOptions& options);

// With fewer samples of each motion, all of a hundred and one, but no fewer than the program has knots.
redesign::GroupProblem Coarse(redesign::GroupProblem problem);

// A problem whose motions are known.
struct DesignTask {
  redesign::GroupProblem problem;
  std::vector<compare::StsCurve> human{};           // of each person
  std::vector<linkage::Links> links{};              // starts
  std::vector<redesign::RedesignPoint> close_by{};  // the solution of a problem close by: no other start if it leads
                                                    // to one
  int starts = 1, usable_starts = 1;                // of the search that led close by
};

// Of each group: from its links in turn, then from random links, as redesign::FindOptimum(): no more starts than it
// takes for all optima to be likely to have been met, several at a time in processes of their own; the same for any
// number of them. Of a quantile those whose misalignment costs most are left out, a few at a time, before the search.
// Outcomes of people come after.
std::vector<GroupOutcome> DesignGroups(std::vector<DesignTask> tasks, const synthesis::OptimizeOptions& options);

// The best for each person alone; absent where none was found.
std::vector<std::optional<redesign::RedesignPoint>> OwnPoints(const redesign::GroupProblem& problem,
                                                              const std::vector<linkage::Links>& links,
                                                              const synthesis::OptimizeOptions& options);

// Person i of a group.
PersonOutcome OutcomeOf(const GroupOutcome& outcome, std::size_t i, const std::optional<redesign::RedesignPoint>& own);

// A point with these links for each person.
std::vector<redesign::RedesignPoint> StartPoints(const redesign::GroupProblem& problem, const linkage::Links& links);

}  // namespace lake::group
