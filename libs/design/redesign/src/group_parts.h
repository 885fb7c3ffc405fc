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

// The design for a problem whose motions are known; outcomes of people come after.
GroupOutcome DesignGroup(const GroupProblem& problem, const std::vector<compare::StsCurve>& human,
                         const std::vector<linkage::Links>& links, const synthesis::OptimizeOptions& options);

// The best for each person alone; absent where none was found.
std::vector<std::optional<ReoptimizePoint>> OwnPoints(const GroupProblem& problem,
                                                      const std::vector<linkage::Links>& links,
                                                      const synthesis::OptimizeOptions& options);

// Person i of a group.
PersonOutcome OutcomeOf(const GroupOutcome& outcome, std::size_t i, const std::optional<ReoptimizePoint>& own);

// A point with these links for each person.
std::vector<ReoptimizePoint> StartPoints(const GroupProblem& problem, const linkage::Links& links);

}  // namespace lake::redesign
