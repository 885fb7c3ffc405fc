// The tables and the summary of lake-optimize.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/redesign/redesign_outcome.h"
#include "lake/redesign/sizes.h"
#include "lake/synthesis/synthesis_outcome.h"

namespace lake::commands {

// Writes design.yaml, optimum.csv, constraints.csv, starts.csv, convergence.csv, sensitivity.csv, margin.csv and, if
// there is one, rounded.yaml, with a yield yield.csv and tolerant.yaml; returns the results for summary.json. Warns
// through the run of what a reader must know.
Json WriteSynthesis(const synthesis::SynthesisOutcome& outcome, Run& run);

// A figure of a design in a person's motion, described once: a row of before_after.csv, a key of the summary, and a row
// of a study's report.
struct DesignFigure {
  std::string name, unit;                                        // in before_after.csv
  std::function<double(const redesign::DesignInMotion&)> value;  // NaN where the design cannot make the motion
  std::string label{};                                           // in the report, with the unit; empty: not there
  double factor = 1;                                             // to that unit
  int decimals = 1;                                              // there, where no interval is known

  std::string Key() const;  // of the summary: "cuff_force_max_n"
};
std::vector<DesignFigure> DesignFigures();

// Writes design.yaml, optimum.csv, constraints.csv, starts.csv, convergence.csv, before_after.csv, cuffs.csv,
// program.csv, predicted/misalignment.csv and predicted/comparison.json (as lake-compare writes them), the same in
// joint_moved/ for the worn design with its joint moved, and, if asked for, pareto.csv; returns the results for
// summary.json. Warns through the run of what a reader must know.
Json WriteRedesign(const redesign::RedesignOutcome& outcome, Run& run);

// The names by which folders differ: the parts of their paths less those that all begin and end with; "sub-01" of
// sub-01/comparison. Throws UsageError for a folder that is named twice.
std::vector<std::string> NamesOfFolders(const std::vector<std::filesystem::path>& folders);

// All that WriteGroup() or, with a number of sizes, WriteSizes() may write.
std::vector<std::string> GroupResultNames(const std::vector<std::string>& people, std::optional<int> sizes);

// Writes design.yaml (the common links), people.csv and of each person people/NAME/design.yaml and program.csv; returns
// the results for summary.json. Warns through the run of what a reader must know.
Json WriteGroup(const redesign::GroupOutcome& outcome, Run& run);

// The same with sizes/K/design.yaml of each size, sizes.csv, size_rule.csv and left_out.csv.
Json WriteSizes(const redesign::SizesOutcome& outcome, Run& run);

}  // namespace lake::commands
