// One exoskeleton for many people: the design, each person's result with it, and each person's loss against a design of
// their own.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lake/redesign/redesign_outcome.h"

namespace lake::redesign {

// A person of the group.
struct PersonMeasured {
  std::string name;
  MeasuredMotion motion;
};

struct PersonOutcome {
  std::string name;
  DesignInMotion with_group;  // the common links, with the person's own placement and program
  bool counts = true;
  double multiplier = 0;              // of the person's misalignment; 0: it does not limit the design
  std::optional<DesignInMotion> own;  // the best links for this person alone under the same limits; absent: none found
  // Loss of the objective (the range less the person's own penalty), degrees; absent without `own`.
  std::optional<double> cost_deg;
};

// Links that are the same for a group, with each person's placement and program.
struct GroupDesign {
  RedesignEnd nearest;  // the design; or that with the least misalignment, whose limit cannot be held …
  std::string reason;   // … and why; empty with a design
  int starts = 0, usable_starts = 0;
  std::vector<bool> counts;  // of each person, whether the misalignment counts

  bool IsSolved() const { return reason.empty(); }
};

struct GroupOutcome : GroupDesign {
  GroupProblem problem;
  std::vector<compare::StsCurve> human;  // of each person
  problem::DesignEvaluation evaluation;  // of the design's links
  std::vector<PersonOutcome> people;

  // The misalignments of people in percent as the limit counts them: the worst, the mean, the quantile.
  double Misalignment_percent() const;
};

// `shared` without motion. Throws as RunRedesign().
GroupOutcome RunGroup(const GroupProblem& shared, const std::vector<PersonMeasured>& people,
                      const synthesis::OptimizeOptions& options);

// The parts of the search, which sizes are made of.

// A problem whose motions are known.
struct DesignTask {
  GroupProblem problem;
  std::vector<compare::StsCurve> human{};  // of each person
  std::vector<linkage::Links> links{};     // starts
  std::vector<RedesignPoint> close_by{};   // the solution of a problem close by: no other start if it leads to one
  int starts = 1, usable_starts = 1;       // of the search that led close by
};

// The problem with these people's motions. Starts are the problem's own, the optimum without people, and what was worn.
DesignTask TaskOf(GroupProblem shared, const std::vector<PersonMeasured>& people,
                  const synthesis::OptimizeOptions& options);

// With fewer samples of each motion, all of a hundred and one, but no fewer than the program has knots.
GroupProblem Coarse(GroupProblem problem);

// Of each group: from its links in turn, then from random links, as FindOptimum(): no more starts than it takes for all
// optima to be likely to have been met, several at a time in processes of their own; the same for any number of them.
// Of a quantile those whose misalignment costs most are left out, a few at a time, before the search. Outcomes of
// people come after.
std::vector<GroupOutcome> DesignGroups(std::vector<DesignTask> tasks, const synthesis::OptimizeOptions& options);

// The best for each person alone; unusable where none was found.
std::vector<RedesignEnd> OwnDesigns(const GroupProblem& problem, const std::vector<linkage::Links>& links,
                                    const synthesis::OptimizeOptions& options);

// Person i of a group.
PersonOutcome OutcomeOf(const GroupOutcome& outcome, std::size_t i, const RedesignEnd& own);

// A point with these links for each person.
std::vector<RedesignPoint> StartPoints(const GroupProblem& problem, const linkage::Links& links);

}  // namespace lake::redesign
