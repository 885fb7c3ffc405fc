// One exoskeleton for many people: the design, each person's result with it, and each person's loss against a design of
// their own.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lake/redesign/group_problem.h"
#include "lake/redesign/redesign_outcome.h"

namespace lake::group {

// Links that are the same for a group, with each person's placement and program.
struct GroupDesign {
  std::vector<redesign::RedesignPoint> points;
  std::vector<double> multipliers;  // multiplier of each person's misalignment; 0: it does not limit the design
  std::vector<double> pulls;        // redesign::GroupSolve::pulls
  double objective = 0;             // redesign::GroupSolve::objective
  bool is_usable = false;
  int starts = 0, usable_starts = 0;

  bool IsUsable() const { return is_usable; }
  const linkage::Links& Links() const { return points.front().links; }
};

// A person of the group.
struct PersonMeasured {
  std::string name;
  redesign::MeasuredMotion motion;
};

struct PersonOutcome {
  std::string name;
  redesign::DesignInMotion with_group;  // the common links, with the person's own placement and program
  bool counts = true;
  double multiplier = 0;  // GroupDesign::multipliers
  std::optional<redesign::DesignInMotion>
      own;  // the best links for this person alone under the same limits; absent: none found
  // Loss of the objective (the range less the person's own penalty), degrees; absent without `own`.
  std::optional<double> cost_deg;
};

struct GroupOutcome {
  redesign::GroupProblem problem;
  std::vector<compare::StsCurve> human;  // of each person
  std::optional<GroupDesign> design;     // absent where there is none within the limits …
  std::string reason;                    // … and why
  GroupDesign nearest;                   // the design; or that with the least misalignment, whose limit cannot be held
  problem::DesignEvaluation evaluation;  // of its links
  std::vector<PersonOutcome> people;

  bool IsSolved() const { return design.has_value(); }
  // The misalignments of people in percent as the limit counts them: the worst, the mean, the quantile.
  double Misalignment_percent() const;
};

// `shared` without motion. Throws as redesign::RunRedesign().
GroupOutcome RunGroup(const redesign::GroupProblem& shared, const std::vector<PersonMeasured>& people,
                      const synthesis::OptimizeOptions& options);

// The parts of the search, which sizes are made of.

// A problem whose motions are known.
struct DesignTask {
  redesign::GroupProblem problem;
  std::vector<compare::StsCurve> human{};           // of each person
  std::vector<linkage::Links> links{};              // starts
  std::vector<redesign::RedesignPoint> close_by{};  // the solution of a problem close by: no other start if it leads
                                                    // to one
  int starts = 1, usable_starts = 1;                // of the search that led close by
};

// The problem with these people's motions. Starts are the problem's own, the optimum without people, and what was worn.
DesignTask TaskOf(redesign::GroupProblem shared, const std::vector<PersonMeasured>& people,
                  const synthesis::OptimizeOptions& options);

// With fewer samples of each motion, all of a hundred and one, but no fewer than the program has knots.
redesign::GroupProblem Coarse(redesign::GroupProblem problem);

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
