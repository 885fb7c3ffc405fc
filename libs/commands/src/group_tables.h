// The tables and the summary of one design for many people.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/sizes/sizes.h"

namespace lake::commands {

// What tells the folders apart: the parts of their paths less those that all begin and end with; "sub-01" of
// sub-01/comparison. Throws UsageError for a folder that is named twice.
std::vector<std::string> NamesOfFolders(const std::vector<std::filesystem::path>& folders);

// All that WriteGroup() or, with a number of sizes, WriteSizes() may write.
std::vector<std::string> GroupResultNames(const std::vector<std::string>& people, std::optional<int> sizes);

// Writes design.yaml (the common links), people.csv and of each person people/NAME/design.yaml and program.csv; returns
// the results for summary.json. Warns through the run of what a reader must know.
Json WriteGroup(const group::GroupOutcome& outcome, Run& run);

// The same with sizes/K/design.yaml of each size, sizes.csv, size_rule.csv and left_out.csv.
Json WriteSizes(const sizes::SizesOutcome& outcome, Run& run);

}  // namespace lake::commands
