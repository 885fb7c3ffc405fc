#include "optimum_tables.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json_or_null.h"
#include "lake/core/numbers.h"
#include "lake/core/provenance.h"
#include "lake/core/uncertain_text.h"
#include "lake/problem/problem_file.h"

namespace lake::commands {
namespace {

// "lower", "upper", "fixed" where a value is at its limits; else empty.
std::string_view ActiveSide(double value, const problem::Bounds& limits) {
  constexpr double kTouching = 1e-5;  // as for the active set
  const auto touches = [&](double limit) {
    return std::isfinite(limit) && std::abs(value - limit) <= kTouching * std::max(1.0, std::abs(limit));
  };
  const bool lower = touches(limits.lower), upper = touches(limits.upper);
  return lower && upper ? "fixed" : lower ? "lower" : upper ? "upper" : "";
}

}  // namespace

std::optional<double> OptimumView::MultiplierOf(const synthesis::LimitId& id) const {
  return best && active.multipliers_unique ? best->MultiplierOf(id) : std::nullopt;
}

void WriteOptimum(const OptimumView& optimum, const std::vector<LimitedRow>& others, Run& run) {
  std::vector<LimitedRow> rows;
  for (int i = 0; i < 6; ++i)
    rows.push_back({.name = problem::LinkName(i),
                    .before = optimum.links_before.Values()[i],
                    .after = optimum.links_after.Values()[i],
                    .limits = optimum.problem.bounds[i],
                    .multiplier = optimum.MultiplierOf({synthesis::LimitId::kLink, i})});
  rows.insert(rows.end(), others.begin(), others.end());
  CsvWriter table({"variable", "initial", "optimum", "lower", "upper", "active", "multiplier"});
  for (const LimitedRow& row : rows)
    table.AddRow(row.name, row.before, row.after, row.limits.lower, row.limits.upper, ActiveSide(row.after, row.limits),
                 row.multiplier);
  table.Write(run.Result("optimum.csv"));
}

void WriteConstraints(const OptimumView& optimum, const std::vector<LimitedRow>& others, Run& run) {
  std::vector<LimitedRow> rows;
  for (const problem::RequirementCheck& check : optimum.after.checks) {
    const problem::Requirement& requirement = check.requirement;
    problem::Bounds limits{std::nan(""), std::nan("")};
    (requirement.is_lower_limit ? limits.lower : limits.upper) = requirement.limit;
    rows.push_back({.name = std::string(requirement.name),
                    .before = optimum.before.CheckOf(requirement.name).value,
                    .after = check.value,
                    .limits = limits,
                    .multiplier = optimum.MultiplierOf({requirement.name}),
                    .unit = requirement.unit});
  }
  rows.insert(rows.end(), others.begin(), others.end());
  CsvWriter table({"constraint", "initial", "optimum", "lower", "upper", "active", "multiplier", "unit"});
  for (const LimitedRow& row : rows)
    table.AddRow(row.name, row.before, row.after, row.limits.lower, row.limits.upper, ActiveSide(row.after, row.limits),
                 row.multiplier, row.unit);
  table.Write(run.Result("constraints.csv"));
}

void WriteStarts(const std::vector<StartRow>& starts, Run& run) {
  const bool has_motion = starts.front().motion.has_value();
  std::vector<std::string> header{"start"};
  const auto add = [&](const std::vector<std::string>& columns) {
    header.insert(header.end(), columns.begin(), columns.end());
  };
  add(LinkColumns("start_"));
  if (has_motion)
    add({"status", "usable", "objective_deg", "range_deg", "misalignment_percent"});
  else
    add({"basin", "status", "range_deg"});
  add({"constraint_violation", "kkt_error", "iterations"});
  add(LinkColumns("end_"));
  CsvWriter table(header);
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const StartRow& row = starts[i];
    const synthesis::LocalSolve& solve = row.solve;
    table.Add(i).Add(solve.start.Values());
    if (row.basin && *row.basin < 0)
      table.AddEmpty();
    else if (row.basin)
      table.Add(*row.basin);
    table.Add(NameOf(solve.solution.status));
    if (row.motion) table.Add(row.motion->is_usable).Add(row.motion->objective_deg);
    table.Add(solve.evaluation.range_deg);
    if (row.motion) table.Add(row.motion->misalignment_percent);
    table.Add(solve.evaluation.violation).Add(solve.solution.kkt_error).Add(solve.iterations);
    table.Add(solve.end.Values()).EndRow();
  }
  table.Write(run.Result("starts.csv"));
}

void WriteOptimumDesign(linkage::Design design, const problem::SynthesisProblem& problem,
                        const problem::DesignEvaluation& evaluation, const std::string& remark, const std::string& name,
                        Run& run) {
  problem::TakeProblem(problem, (run.Folder() / name).parent_path(), design);
  problem::TakeRange(evaluation, design);
  design.made_by = fmt::format("lake-optimize {}{}", Version(), remark);
  linkage::WriteDesign(run.Result(name), design);
}

void WriteOptimumDesign(const linkage::Design& design, const OptimumView& optimum, Run& run) {
  const std::string remark = optimum.best ? "" : fmt::format(": NOT A SOLUTION: {}", optimum.not_a_solution);
  WriteOptimumDesign(design, optimum.problem, optimum.after, remark, "design.yaml", run);
}

void WarnOfMultipliers(const synthesis::ActiveSet& active, Run& run) {
  if (active.multipliers_unique) return;
  run.Warn("no sensitivities: the limits that bind depend on one another, so what each of them costs is not unique");
}

std::string RangeText(double range_deg, const std::optional<certificate::Certificate>& certificate) {
  std::string text = fmt::format("range {:.4f} deg", range_deg);
  if (certificate && std::isfinite(certificate->upper_bound_deg))
    text += fmt::format("; no design exceeds {:.4f} deg (proved)", certificate->upper_bound_deg);
  return text + "\n";
}

std::string LinksText(const linkage::Links& links) {
  std::string text;
  for (std::size_t i = 0; i < 6; ++i) text += fmt::format("  {} {:9.4f} mm\n", problem::LinkName(i), links.Values()[i]);
  return text;
}

std::string ActiveText(const synthesis::ActiveSet& active, const std::string& gained) {
  std::string text;
  for (const synthesis::ActiveSet::Entry& entry : active.entries) {
    text += fmt::format("  at its limit: {}", entry.name);
    if (active.multipliers_unique)
      text += fmt::format(", {} {} per {}", SignificantText(entry.multiplier, 4), gained, entry.unit);
    text += "\n";
  }
  return text;
}

Json HeadJson(const OptimumView& optimum, double violation,
              const std::optional<certificate::Certificate>& certificate) {
  const synthesis::LocalSolve* best = optimum.best;
  return {{"range_deg", NumberOrNull(optimum.after.range_deg)},
          {"status", best ? Json(NameOf(best->solution.status)) : Json("infeasible")},
          {"constraint_violation", NumberOrNull(violation)},
          {"kkt_error", best ? Json(best->solution.kkt_error) : Json()},
          {"certified_upper_bound_deg", certificate ? NumberOrNull(certificate->upper_bound_deg) : Json()}};
}

Json LinksJson(const linkage::Links& links) {
  Json json = Json::object();
  for (std::size_t i = 0; i < 6; ++i) json[problem::LinkName(i)] = links.Values()[i];
  return json;
}

Json ClearancesJson(const problem::SynthesisProblem& problem) {
  const problem::Clearances& clearances = problem.clearances;
  if (!clearances.AreAsked()) return nullptr;
  const person::Body body = person::BodyOf(clearances.body);
  return {{"seat_mm", NumberOrNull(clearances.seat_mm)},
          {"limb_mm", NumberOrNull(clearances.thigh_mm)},
          {"height_mm", body.height_mm},
          {"mass_kg", body.mass_kg},
          {"thigh_mm", body.thigh.length_mm},
          {"shank_mm", body.shank.length_mm},
          {"seat_edge_mm", clearances.seat_edge_mm},
          {"bar_width_mm", problem.parts.bar_width_mm},
          {"actuator_diameter_mm", problem.parts.actuator_diameter_mm}};
}

namespace {

const char* KindText(const problem::Requirement& requirement) {
  return requirement.is_lower_limit ? "at least" : "at most";
}

std::string ValueText(const problem::Requirement& requirement, double value) {
  if (std::isnan(value)) return "no value";
  const std::string text = SignificantText(value, 4);
  return requirement.unit == "1" ? text : text + " " + requirement.unit;
}

}  // namespace

Json EvaluationJson(const problem::DesignEvaluation& evaluation) {
  Json requirements = Json::array();
  for (const problem::RequirementCheck& check : evaluation.checks)
    requirements.push_back({{"name", check.requirement.name},
                            {"limit", check.requirement.limit},
                            {"kind", KindText(check.requirement)},
                            {"value", NumberOrNull(check.value)},
                            {"slack", NumberOrNull(check.slack)},
                            {"unit", check.requirement.unit}});
  return {{"range_deg", NumberOrNull(evaluation.range_deg)},
          {"assembled", evaluation.pose.has_value()},
          {"feasible", evaluation.IsFeasible()},
          {"violation", NumberOrNull(evaluation.violation)},
          {"stroke_when_standing_mm", ValueOrNull(evaluation.stands_mm)},
          {"requirements", requirements}};
}

Json YieldJson(const problem::Yield& yield) {
  const auto fraction = [](const problem::Fraction& f) {
    return Json{{"value", f.value}, {"interval_95", {f.lower, f.upper}}};
  };
  Json limits = Json::array();
  for (const problem::LimitYield& limit : yield.limits)
    limits.push_back({{"name", limit.requirement.name},
                      {"limit", limit.requirement.limit},
                      {"kind", KindText(limit.requirement)},
                      {"unit", limit.requirement.unit},
                      {"kept", fraction(limit.kept)},
                      {"kept_by_95_percent", NumberOrNull(limit.kept_by_95)}});
  return {{"tolerance_mm", yield.options.tolerance_mm},
          {"scope", problem::kYieldScope},
          {"samples", yield.options.samples},
          {"assembled", fraction(yield.assembled)},
          {"limits", limits},
          {"all_limits", fraction(yield.all)},
          {"range_p5_deg", NumberOrNull(yield.range_p5_deg)},
          {"range_median_deg", NumberOrNull(yield.range_median_deg)},
          {"range_p95_deg", NumberOrNull(yield.range_p95_deg)},
          {"safe_singularity_margin_mm", yield.safe_singularity_margin_mm},
          {"safe_grashof_margin_mm", yield.safe_grashof_margin_mm}};
}

void WriteYields(const std::vector<std::pair<const char*, const problem::Yield*>>& designs, Run& run) {
  CsvWriter table({"design", "limit", "kind", "limit_value", "unit", "kept", "kept_low", "kept_high", "kept_by_95"});
  for (const auto& [design, yield] : designs) {
    const auto add = [&, design = design](const std::string& what, const char* kind, double limit,
                                          const std::string& unit, const problem::Fraction& kept, double by_95) {
      table.AddRow(design, what, kind, limit, unit, kept.value, kept.lower, kept.upper, by_95);
    };
    add("assembled", "", kNaN, "", yield->assembled, kNaN);
    for (const problem::LimitYield& limit : yield->limits)
      add(std::string(limit.requirement.name), KindText(limit.requirement), limit.requirement.limit,
          limit.requirement.unit, limit.kept, limit.kept_by_95);
    add("all", "", kNaN, "", yield->all, kNaN);
  }
  table.Write(run.Result("yield.csv"));
}

std::string YieldText(const problem::Yield& yield) {
  std::string text = fmt::format("  of builds within ±{} mm {:.1f} % keep every limit", yield.options.tolerance_mm,
                                 100 * yield.all.value);
  std::vector<std::string> missed;
  for (const problem::LimitYield& limit : yield.limits)
    if (limit.kept.value < 1)
      missed.push_back(fmt::format("    {:.1f} % keep {}, 95 % keep {}\n", 100 * limit.kept.value,
                                   limit.requirement.Text(), ValueText(limit.requirement, limit.kept_by_95)));
  return text + (missed.empty() ? "\n" : fmt::format(":\n{}", fmt::join(missed, "")));
}

std::vector<std::string> LinkColumns(std::string_view prefix) {
  std::vector<std::string> columns;
  for (std::size_t i = 0; i < 6; ++i) columns.push_back(fmt::format("{}{}_mm", prefix, problem::LinkName(i)));
  return columns;
}

void WriteConvergence(const synthesis::LocalSolve& solve, const std::string& objective, Run& run) {
  CsvWriter table({"iteration", objective, "constraint_violation", "dual_infeasibility", "barrier", "step"});
  for (std::size_t i = 0; i < solve.history.size(); ++i) {
    const nlp::NlpIteration& step = solve.history[i];
    table.AddRow(i, -step.cost, step.violation, step.dual_infeasibility, step.barrier, step.step);
  }
  table.Write(run.Result("convergence.csv"));
}

Json ActiveJson(const synthesis::ActiveSet& active, const std::string& gained) {
  Json entries = Json::array();
  for (const synthesis::ActiveSet::Entry& entry : active.entries)
    entries.push_back({{"limit", entry.name},
                       {"multiplier", active.multipliers_unique ? Json(entry.multiplier) : Json()},
                       {"unit", fmt::format("{} per {}", gained, entry.unit)}});
  return entries;
}

namespace {

std::string_view NameOf(certificate::Certificate::End end) {
  switch (end) {
    case certificate::Certificate::End::kGap:
      return "gap";
    case certificate::Certificate::End::kBoxes:
      return "boxes";
    case certificate::Certificate::End::kTime:
      return "time";
    case certificate::Certificate::End::kNothingToSplit:
      return "nothing_to_split";
  }
  return "";
}

}  // namespace

Json CertificateJson(const certificate::Certificate& certificate, const std::vector<std::string>& not_in_bound) {
  return {{"upper_bound_deg", NumberOrNull(certificate.upper_bound_deg)},
          {"of_range_deg", NumberOrNull(certificate.range_deg)},
          {"gap_deg", NumberOrNull(certificate.gap_deg)},
          {"reached", certificate.reached},
          {"ended_by", NameOf(certificate.end)},
          {"boxes", certificate.boxes},
          {"not_in_bound", not_in_bound}};
}

void WarnOfCertificate(const certificate::Certificate& certificate, const std::vector<std::string>& not_in_bound,
                       Run& run) {
  if (certificate.reached) return;
  std::string text = fmt::format("between the range found and the proved bound {}° are open, more than requested",
                                 SignificantText(certificate.gap_deg, 3));
  if (certificate.end == certificate::Certificate::End::kTime)
    text += ": the time of --certify-time was over, so another machine may come to another gap";
  if (certificate.end == certificate::Certificate::End::kBoxes)
    text += fmt::format(": the search ended after {} boxes", certificate.boxes);
  if (certificate.end == certificate::Certificate::End::kNothingToSplit)
    text += ": no box is left that can be split further";
  if (!not_in_bound.empty())
    text +=
        fmt::format("; the bound holds for all requirements, but is found without {}", fmt::join(not_in_bound, ", "));
  run.Warn(text);
}

void WriteProgramTable(const redesign::DesignInMotion& design, const redesign::HumanMotion& human,
                       const std::filesystem::path& path) {
  CsvWriter table({"percent", "time_s", "stroke_mm", "knee_deg", "human_knee_deg"});
  for (std::size_t i = 0; design.prediction && i < human.size(); ++i) {
    const double percent = static_cast<double>(i);
    table.AddRow(i, design.duration_s * percent / 100, design.prediction->stroke_mm[i],
                 DegreesFromRadians(design.prediction->theta_rad[i]), DegreesFromRadians(human[i].knee_rad));
  }
  table.Write(path);
}

void WarnWithoutLimit(const redesign::MotionLimits& limits, Run& run) {
  if (!redesign::kMisalignment.Counts(limits))
    run.Warn(
        "neither --max-misalignment nor --penalty is given, so only the range is optimised; give one of them to limit "
        "the misalignment");
}

}  // namespace lake::commands
