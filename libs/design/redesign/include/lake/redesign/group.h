// One exoskeleton for many people: the design, what it is to each of them, and what it costs each against one of their
// own.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lake/redesign/group_problem.h"
#include "lake/redesign/reoptimize_outcome.h"

namespace lake::redesign {

// Links that are the same for a group, with each person's placement and program.
struct GroupDesign {
  std::vector<ReoptimizePoint> points;
  std::vector<double> prices;  // how strongly each person's misalignment holds the design; 0: not at all
  std::vector<double> pulls;   // GroupSolve::pulls
  std::vector<bool> counts;    // those whose misalignment counts: all, or as many as the quantile says
  double objective = 0;        // GroupSolve::objective
  bool is_usable = false;
  int starts = 0, usable_starts = 0;

  const linkage::Links& Links() const { return points.front().links; }
};

// From `links` in turn, then from random links, as FindOptimum(): no more starts than it takes for all optima to be
// likely to have been met, several at a time in processes of their own; the same for any number of them. Of a quantile
// those whose misalignment costs most are left out, a few at a time, before the search. The best of the starts if none
// is usable. Throws as Reoptimize().
GroupDesign FindGroupDesign(const GroupProblem& problem, const std::vector<linkage::Links>& links,
                            const synthesis::OptimizeOptions& options);

// A person of the group.
struct PersonMeasured {
  std::string name;
  MeasuredMotion motion;
};

struct PersonOutcome {
  std::string name;
  DesignInMotion with_group;  // the common links, with the person's own placement and program
  bool counts = true;
  double price = 0;                   // GroupDesign::prices
  std::optional<DesignInMotion> own;  // the best links for this person alone under the same limits; absent: none found
  // What is given up, in degrees of what is maximised (the range less the person's own penalty); absent without `own`.
  std::optional<double> cost_deg;
};

struct GroupOutcome {
  GroupProblem problem;
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

// `shared` without motion. Throws as RunReoptimization().
GroupOutcome RunGroup(const GroupProblem& shared, const std::vector<PersonMeasured>& people,
                      const synthesis::OptimizeOptions& options);

}  // namespace lake::redesign
