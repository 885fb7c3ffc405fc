#include "tables.h"

#include <algorithm>
#include <cmath>

#include "lake/core/csv.h"
#include "lake/core/error.h"

namespace lake::commands {

Json LinksJson(const linkage::Links& links) {
  Json json = Json::object();
  for (std::size_t i = 0; i < 6; ++i) json[problem::LinkName(i)] = links.Values()[i];
  return json;
}

Json NumberOrNull(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

std::string_view ActiveSide(double value, double lower, double upper) {
  constexpr double kTouching = 1e-5;  // as for the active set
  const auto touches = [&](double limit) {
    return std::isfinite(limit) && std::abs(value - limit) <= kTouching * std::max(1.0, std::abs(limit));
  };
  return touches(lower) && touches(upper) ? "fixed" : touches(lower) ? "lower" : touches(upper) ? "upper" : "";
}

Json EvaluationJson(const problem::DesignEvaluation& evaluation) {
  Json requirements = Json::array();
  for (const problem::RequirementCheck& check : evaluation.checks)
    requirements.push_back({{"name", check.requirement.name},
                            {"limit", check.requirement.limit},
                            {"kind", check.requirement.is_lower_limit ? "at least" : "at most"},
                            {"value", NumberOrNull(check.value)},
                            {"slack", NumberOrNull(check.slack)},
                            {"unit", check.requirement.unit}});
  return {{"range_deg", NumberOrNull(evaluation.range_deg)},
          {"assembled", evaluation.pose.has_value()},
          {"feasible", evaluation.IsFeasible()},
          {"violation", NumberOrNull(evaluation.violation)},
          {"stroke_when_standing_mm", evaluation.stands_mm ? Json(*evaluation.stands_mm) : Json()},
          {"requirements", requirements}};
}

Json YieldJson(const problem::Yield& yield) {
  const auto fraction = [](const problem::Fraction& f) {
    return Json{{"value", f.value}, {"interval_95", {f.lower, f.upper}}};
  };
  return {{"tolerance_mm", yield.options.tolerance_mm},
          {"scope", problem::kYieldScope},
          {"samples", yield.options.samples},
          {"assembled", fraction(yield.assembled)},
          {"assembled_and_grashof", fraction(yield.assembled_and_grashof)},
          {"range_p5_deg", NumberOrNull(yield.range_p5_deg)},
          {"range_median_deg", NumberOrNull(yield.range_median_deg)},
          {"range_p95_deg", NumberOrNull(yield.range_p95_deg)},
          {"safe_singularity_margin_mm", yield.safe_singularity_margin_mm},
          {"safe_grashof_margin_mm", yield.safe_grashof_margin_mm}};
}

std::vector<std::string> LinkColumns(std::string_view prefix) {
  std::vector<std::string> columns;
  for (std::size_t i = 0; i < 6; ++i) columns.push_back(fmt::format("{}{}_mm", prefix, problem::LinkName(i)));
  return columns;
}

void AddLinkCells(CsvWriter& table, const linkage::Links& links) {
  for (const double value : links.Values()) table.Add(value);
}

void WriteConvergence(const synthesis::LocalSolve& solve, const std::string& objective, Run& run) {
  CsvWriter table({"iteration", objective, "constraint_violation", "dual_infeasibility", "barrier", "step"});
  for (std::size_t i = 0; i < solve.history.size(); ++i) {
    const nlp::NlpIteration& step = solve.history[i];
    table.Add(static_cast<int>(i)).Add(-step.cost).Add(step.violation).Add(step.dual_infeasibility).Add(step.barrier);
    table.Add(step.step).EndRow();
  }
  table.Write(run.Result("convergence.csv"));
}

Json ActiveJson(const synthesis::ActiveSet& active) {
  Json entries = Json::array();
  for (const synthesis::ActiveSet::Entry& entry : active.entries)
    entries.push_back({{"limit", entry.name},
                       {"multiplier", active.multipliers_unique ? Json(entry.price) : Json()},
                       {"unit", fmt::format("deg per {}", entry.unit)}});
  return entries;
}

Json CertificateJson(const certificate::Certificate& certificate, bool ignores_used_range) {
  return {{"upper_bound_deg", NumberOrNull(certificate.upper_bound_deg)},
          {"gap_deg", NumberOrNull(certificate.gap_deg)},
          {"reached", certificate.reached},
          {"boxes", certificate.boxes},
          {"leaves_out_requirements_over_used_range", ignores_used_range}};
}

}  // namespace lake::commands
