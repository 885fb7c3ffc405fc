// Pieces of which the design of a group and of several sizes are put together.
#pragma once

#include <optional>
#include <vector>

#include "lake/redesign/group.h"

namespace lake::redesign {

// The same problem with these people's motions.
GroupProblem PutMotionsInto(GroupProblem problem, const std::vector<PersonMeasured>& people);

// Where to start: the problem's start, the optimum without people, and what was worn.
std::vector<linkage::Links> StartLinks(const GroupProblem& problem, const std::vector<PersonMeasured>& people,
                                       const synthesis::OptimizeOptions& options);

// With fewer samples of each motion, all of a hundred and one, but no fewer than the program has knots.
GroupProblem Coarse(GroupProblem problem);

// A problem whose motions are known.
struct DesignTask {
  GroupProblem problem;
  std::vector<compare::StsCurve> human;   // of each person
  std::vector<linkage::Links> links;      // starts
  std::vector<ReoptimizePoint> close_by;  // the solution of a problem close by: no other start if it leads to one
  int starts = 1, usable_starts = 1;      // of the search that led close by
};

// Designs for groups that have nothing to do with each other; outcomes of people come after.
std::vector<GroupOutcome> DesignGroups(std::vector<DesignTask> tasks, const synthesis::OptimizeOptions& options);

// The best for each person alone; absent where none was found.
std::vector<std::optional<ReoptimizePoint>> OwnPoints(const GroupProblem& problem,
                                                      const std::vector<linkage::Links>& links,
                                                      const synthesis::OptimizeOptions& options);

// Person i of a group.
PersonOutcome OutcomeOf(const GroupOutcome& outcome, std::size_t i, const std::optional<ReoptimizePoint>& own);

// A point with these links for each person.
std::vector<ReoptimizePoint> StartPoints(const GroupProblem& problem, const linkage::Links& links);

}  // namespace lake::redesign
