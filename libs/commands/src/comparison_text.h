// What a person wants to read of a comparison, at the terminal.
#pragma once

#include <string>
#include <vector>

#include "cuff_tables.h"
#include "lake/compare/misalignment.h"
#include "lake/compare/uncertainty_budget.h"

namespace lake::commands {

// `worn`: what is said of the worn links, with the joint's headline. `cuffs`: the joint as worn and moved; may be
// empty.
std::string ComparisonText(const compare::Misalignment& misalignment, const std::vector<compare::Budget>& budgets,
                           const std::string& worn, const std::vector<CuffCase>& cuffs);

}  // namespace lake::commands
