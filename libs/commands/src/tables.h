// What the tables and summaries of a synthesis and of a re-optimisation have in common.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "lake/certificate/certificate.h"
#include "lake/core/csv.h"
#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/problem/robustness.h"
#include "lake/synthesis/optimize.h"

namespace lake::commands {

Json LinksJson(const linkage::Links& links);
Json NumberOrNull(double value);
Json EvaluationJson(const problem::DesignEvaluation& evaluation);
Json YieldJson(const problem::Yield& yield);
Json ActiveJson(const synthesis::ActiveSet& active);
Json CertificateJson(const certificate::Certificate& certificate, bool ignores_used_range);

// "lower", "upper", "fixed" where a value is at its limits; else empty.
std::string_view ActiveSide(double value, double lower, double upper);

// "l1_mm" and so on, with a prefix; and the cells below them.
std::vector<std::string> LinkColumns(std::string_view prefix);
void AddLinkCells(CsvWriter& table, const linkage::Links& links);

// convergence.csv; `objective` names the column of the cost's negative.
void WriteConvergence(const synthesis::LocalSolve& solve, const std::string& objective, Run& run);

}  // namespace lake::commands
