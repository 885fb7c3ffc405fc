// The tables and the parts of a summary that a synthesis and a redesign both write.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "lake/certificate/certificate.h"
#include "lake/core/csv.h"
#include "lake/core/json_or_null.h"
#include "lake/core/run.h"
#include "lake/linkage/design_file.h"
#include "lake/problem/robustness.h"
#include "lake/redesign/redesign_outcome.h"
#include "lake/synthesis/optimize.h"

namespace lake::commands {

// Either of them, as far as these tables go.
struct OptimumView {
  const problem::SynthesisProblem& problem;
  linkage::Links links_before, links_after;
  const problem::DesignEvaluation &before, &after;
  const synthesis::LocalSolve* best;  // nullptr without a solution
  const synthesis::ActiveSet& active;
  std::string not_a_solution;  // why there is none; empty with one

  // nullopt where multipliers are not unique, or the limit is none of the program's.
  std::optional<double> MultiplierOf(const synthesis::LimitId& id) const;
};

// A row of optimum.csv or constraints.csv; NaN where there is no such number.
struct LimitedRow {
  std::string name;
  double before, after;
  problem::Bounds limits;
  std::optional<double> multiplier;
  std::string unit{};  // constraints.csv only
};

// optimum.csv: the links, and what else varies. constraints.csv: the requirements, and what else is limited.
void WriteOptimum(const OptimumView& optimum, const std::vector<LimitedRow>& others, Run& run);
void WriteConstraints(const OptimumView& optimum, const std::vector<LimitedRow>& others, Run& run);

// starts.csv; of all starts either `basin` or `motion` is there.
struct StartRow {
  struct Motion {
    bool is_usable;
    double objective_deg, misalignment_percent;  // NaN without a prediction
  };
  const synthesis::LocalSolve& solve;
  std::optional<int> basin{};  // -1: unusable
  std::optional<Motion> motion{};
};
void WriteStarts(const std::vector<StartRow>& starts, Run& run);

// convergence.csv; `objective` names the column of the cost's negative.
void WriteConvergence(const synthesis::LocalSolve& solve, const std::string& objective, Run& run);

// The file of a design of this problem. The evaluation's range and stroke when standing go into it; `remark` goes
// behind the program's name.
void WriteOptimumDesign(linkage::Design design, const problem::SynthesisProblem& problem,
                        const problem::DesignEvaluation& evaluation, const std::string& remark, const std::string& name,
                        Run& run);
// As design.yaml; marked where it is not a solution.
void WriteOptimumDesign(const linkage::Design& design, const OptimumView& optimum, Run& run);

void WarnOfMultipliers(const synthesis::ActiveSet& active, Run& run);

// Lines of the report: the range and what is proved of it; the links; the limits that bind, with their multipliers.
std::string RangeText(double range_deg, const std::optional<certificate::Certificate>& certificate);
std::string LinksText(const linkage::Links& links);
std::string ActiveText(const synthesis::ActiveSet& active, const std::string& gained = "deg");

// The first entries of the summary. `violation` of a solution may count more than the evaluation's.
Json HeadJson(const OptimumView& optimum, double violation, const std::optional<certificate::Certificate>& certificate);
Json LinksJson(const linkage::Links& links);
// What was asked for, and on which body; null if nothing was.
Json ClearancesJson(const problem::SynthesisProblem& problem);
Json EvaluationJson(const problem::DesignEvaluation& evaluation);
Json YieldJson(const problem::Yield& yield);
// yield.csv: the share of builds that keeps each limit and all of them, of named designs.
void WriteYields(const std::vector<std::pair<const char*, const problem::Yield*>>& designs, Run& run);
// All limits together, then those that not every build keeps, a line each.
std::string YieldText(const problem::Yield& yield);
// `gained`: what is maximised, in its unit: "deg", "s gained".
Json ActiveJson(const synthesis::ActiveSet& active, const std::string& gained = "deg");
// `not_in_bound`: names of the requirements that the bound does without.
Json CertificateJson(const certificate::Certificate& certificate, const std::vector<std::string>& not_in_bound);
// Where the gap asked for was not reached: what ended the search, and what the bound does without.
void WarnOfCertificate(const certificate::Certificate& certificate, const std::vector<std::string>& not_in_bound,
                       Run& run);

// "l1_mm" and so on, with a prefix.
std::vector<std::string> LinkColumns(std::string_view prefix);

// The program sample by sample, and the knee angles that it is to follow; only the header where the design cannot make
// the motion.
void WriteProgramTable(const redesign::DesignInMotion& design, const redesign::HumanMotion& human,
                       const std::filesystem::path& path);

// Where nothing limits the misalignment.
void WarnWithoutLimit(const redesign::MotionLimits& limits, Run& run);

}  // namespace lake::commands
