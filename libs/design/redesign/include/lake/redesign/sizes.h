// Several sizes of an exoskeleton for many people: the best K designs, who wears which, and a rule by which the next
// person gets one.
#pragma once

#include <string>
#include <vector>

#include "lake/redesign/group.h"

namespace lake::redesign {

// The fit of one size to one person, placement and program adapted.
struct Fit {
  bool holds = false;  // every limit
  double value = 0;    // of the objective, deg; where a limit is not held, far below that of any size that holds
  double percent = 0;  // misalignment; infinite where the linkage cannot follow the person
  double range_deg = 0;
};
Fit FitOf(const RedesignProblem& person, const linkage::Links& links, const synthesis::OptimizeOptions& options);

// Of one quantity of the body: whoever is within (from, to] gets this size. Ranges lie side by side from -inf to inf.
struct RuleRange {
  double from_mm = 0, to_mm = 0;
  std::size_t size = 0;
};
struct SizeRule {
  std::string quantity;  // height_mm, leg_mm, shank_mm, thigh_mm
  std::vector<RuleRange> ranges;
  double loss_deg = 0;  // mean loss of the people it was made of, against the best size of each

  std::size_t SizeFor(double quantity_mm) const;
};

// A quantity of everybody's body.
struct BodyQuantity {
  std::string name;
  std::vector<double> mm;  // per person
};

// The rule with the least loss of those that cut one quantity into ranges, each size at most once; of equals that of
// the first quantity. `losses`: per person and size. `people`: of whom it is made.
SizeRule FindRule(const std::vector<BodyQuantity>& quantities, const std::vector<std::vector<double>>& losses,
                  const std::vector<std::size_t>& people);

// Leave-one-out result of a person: size and rule are made of the others, and the rule gives the person a size.
struct LeftOut {
  std::size_t size = 0;
  Fit fit;
};

struct SizesOutcome {
  std::vector<GroupOutcome> sizes;                // each for those who wear it, in the order of their legs' lengths
  std::vector<std::vector<std::size_t>> members;  // of each size, as indices of people
  std::vector<std::size_t> size_of;               // of each person
  std::vector<BodyQuantity> quantities;
  SizeRule rule;
  std::size_t rule_not_held = 0;  // how many people's limits the size that the rule gives them does not hold
  std::vector<LeftOut> left_out;  // per person; empty where a size has no design
  double mean_value_deg = 0;      // of what is maximised, over people; NaN where a limit is not held
  bool is_settled = false;        // everybody wears the size that is best for them

  bool IsSolved() const;
  std::string Reason() const;  // why a size has no design
};

// Throws UsageError: 2 to 8 sizes, at least two people for each, and a limit or penalty on the worst misalignment.
void CheckSizes(const GroupProblem& shared, int sizes, std::size_t people);

// `heights_mm`: of all people, or empty. Alternates designing and assigning, which never lowers the mean over people,
// from several first assignments, until no assignment changes or for ten rounds at most. Throws as CheckSizes() and
// RunGroup().
SizesOutcome RunSizes(const GroupProblem& shared, const std::vector<PersonMeasured>& people, int sizes,
                      const std::vector<double>& heights_mm, const synthesis::OptimizeOptions& options);

}  // namespace lake::redesign
