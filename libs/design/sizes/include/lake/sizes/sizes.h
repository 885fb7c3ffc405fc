// Several sizes of an exoskeleton for many people: the best K designs, who wears which, and a rule by which the next
// person gets one.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "lake/group/group.h"

namespace lake::sizes {

// What one size is to one person, placement and program adapted.
struct Fit {
  bool holds = false;  // every limit
  double value = 0;    // of the goal, deg; far below that of any that holds where a limit is not held
  double percent = 0;  // misalignment; infinite where the person cannot wear it at all
  double range_deg = 0;
};
Fit FitOf(const redesign::RedesignProblem& person, const linkage::Links& links,
          const synthesis::OptimizeOptions& options);

// Of one quantity of the body: whoever is within (from, to] gets this size. Ranges lie side by side from -inf to inf.
struct RuleRange {
  double from_mm = 0, to_mm = 0;
  std::size_t size = 0;
};
struct SizeRule {
  std::string quantity;  // height_mm, leg_mm, shank_mm, thigh_mm
  std::vector<RuleRange> ranges;
  double loss_deg = 0;  // what it costs those it was made of on average, against the size that is best for each

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

// What comes of a person who was left out: the size that they wear is designed without them, the rule is made of the
// others, and they get what it says.
struct LeftOut {
  std::size_t size = 0;
  Fit fit;
};

struct SizesOutcome {
  std::vector<group::GroupOutcome> sizes;         // each for those who wear it, in the order of their legs' lengths
  std::vector<std::vector<std::size_t>> members;  // of each size, as indices of people
  std::vector<std::size_t> size_of;               // of each person
  std::vector<BodyQuantity> quantities;
  SizeRule rule;
  std::size_t rule_not_held = 0;  // how many people's limits the size that the rule gives them does not hold
  std::vector<LeftOut> left_out;  // per person; empty where a size has no design
  double mean_value_deg = 0;      // of what is maximised, over people; NaN where a limit is not held
  int assignments = 0;            // from how many the search began
  bool is_settled = false;        // everybody wears the size that is best for them

  bool IsSolved() const;
  std::string Reason() const;  // why a size has no design
};

// Throws UsageError: 2 to 8 sizes, at least two people for each, and a limit or penalty on the worst misalignment.
void CheckSizes(const redesign::GroupProblem& shared, int sizes, std::size_t people);

// `heights_mm`: of all people, or empty. Designs and people are assigned to each other in turn, which never makes the
// mean over people worse, from several first assignments, until nobody changes or for ten rounds at most. Throws as
// CheckSizes() and RunGroup().
SizesOutcome RunSizes(const redesign::GroupProblem& shared, const std::vector<group::PersonMeasured>& people, int sizes,
                      const std::vector<double>& heights_mm, const synthesis::OptimizeOptions& options);

}  // namespace lake::sizes
