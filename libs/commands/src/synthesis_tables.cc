#include <algorithm>
#include <cmath>

#include "lake/commands/optimize_tables.h"
#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/provenance.h"
#include "lake/linkage/design_file.h"
#include "lake/synthesis/synthesis_outcome.h"
#include "tables.h"

namespace lake::commands {
namespace {

constexpr const char* kPoseAtRange[] = {"phi", "theta"};

void WriteDesignFile(const synthesis::SynthesisOutcome& outcome, Run& run) {
  linkage::Design design;
  design.links = outcome.BestLinks();
  design.d_min_mm = outcome.problem.d_min_mm;
  design.made_by = fmt::format("lake-optimize {}", Version());
  const problem::DesignEvaluation evaluation = problem::Evaluate(design.links, outcome.problem);
  if (evaluation.pose) design.range_deg = evaluation.range_deg;
  if (evaluation.stands_mm && *evaluation.stands_mm > design.d_min_mm) design.d_max_mm = evaluation.stands_mm;
  if (!outcome.IsSolved()) design.made_by += fmt::format(": NOT A SOLUTION: {}", outcome.infeasible->sentence);
  linkage::WriteDesign(run.Result("design.yaml"), design);
}

// The variables of the pose at d_min as a table; empty optimum columns without a solution.
void WriteOptimum(const synthesis::SynthesisOutcome& outcome, Run& run) {
  CsvWriter table({"variable", "initial", "optimum", "lower", "upper", "active", "multiplier"});
  const auto initial = outcome.problem.start.Values(), best = outcome.BestLinks().Values();
  const bool priced = outcome.IsSolved() && outcome.active.multipliers_unique;
  for (std::size_t i = 0; i < best.size(); ++i) {
    const problem::Bounds& bounds = outcome.problem.bounds[i];
    table.Add(problem::LinkName(i)).Add(initial[i]).Add(best[i]).Add(bounds.lower).Add(bounds.upper);
    table.Add(ActiveSide(best[i], bounds.lower, bounds.upper));
    priced ? table.Add(-outcome.result.Best().solution.variable_prices[outcome.result.Best().program.links[i]])
           : table.AddEmpty();
    table.EndRow();
  }
  const std::optional<linkage::Pose> start = outcome.start.pose,
                                     end = linkage::SolvePose(outcome.BestLinks(), outcome.problem.d_min_mm);
  for (const char* name : kPoseAtRange) {
    const auto angle = [&](const std::optional<linkage::Pose>& pose) -> std::optional<double> {
      if (!pose) return std::nullopt;
      return DegreesFromRadians(name == kPoseAtRange[0] ? pose->phi_rad : pose->theta_rad);
    };
    table.Add(fmt::format("{}_deg", name)).Add(angle(start)).Add(angle(end));
    table.AddEmpty().AddEmpty().AddEmpty().AddEmpty().EndRow();
  }
  table.Write(run.Result("optimum.csv"));
}

void WriteConstraints(const synthesis::SynthesisOutcome& outcome, Run& run) {
  CsvWriter table({"constraint", "initial", "optimum", "lower", "upper", "active", "multiplier", "unit"});
  const problem::DesignEvaluation best = problem::Evaluate(outcome.BestLinks(), outcome.problem);
  const bool priced = outcome.IsSolved() && outcome.active.multipliers_unique;
  for (std::size_t i = 0; i < best.checks.size(); ++i) {
    const problem::RequirementCheck& check = best.checks[i];
    const double lower = check.requirement.is_lower_limit ? check.requirement.limit : NAN;
    const double upper = check.requirement.is_lower_limit ? NAN : check.requirement.limit;
    const int row = outcome.IsSolved() ? outcome.result.Best().program.limits[i].row : -1;
    table.Add(check.requirement.name).Add(outcome.start.checks[i].value).Add(check.value).Add(lower).Add(upper);
    table.Add(ActiveSide(check.value, lower, upper));
    priced&& row >= 0 ? table.Add(-outcome.result.Best().solution.row_prices[row]) : table.AddEmpty();
    table.Add(check.requirement.unit).EndRow();
  }
  table.Write(run.Result("constraints.csv"));
}

void WriteStarts(const synthesis::SynthesisOutcome& outcome, Run& run) {
  std::vector<std::string> header{"start"};
  std::ranges::copy(LinkColumns("start_"), std::back_inserter(header));
  for (const char* column :
       {"basin", "status", "range_deg", "constraint_violation", "kkt_error", "iterations", "time_s"})
    header.emplace_back(column);
  std::ranges::copy(LinkColumns("end_"), std::back_inserter(header));
  CsvWriter table(header);
  for (std::size_t i = 0; i < outcome.result.starts.size(); ++i) {
    const synthesis::LocalSolve& solve = outcome.result.starts[i];
    table.Add(static_cast<int>(i));
    AddLinkCells(table, solve.start);
    outcome.result.basin[i] < 0 ? table.AddEmpty() : table.Add(outcome.result.basin[i]);
    table.Add(NameOf(solve.solution.status)).Add(solve.evaluation.range_deg).Add(solve.evaluation.violation);
    table.Add(solve.solution.kkt_error).Add(solve.iterations).Add(solve.seconds);
    AddLinkCells(table, solve.end);
    table.EndRow();
  }
  table.Write(run.Result("starts.csv"));
}

void WriteSensitivity(const synthesis::SynthesisOutcome& outcome, Run& run) {
  CsvWriter table({"link", "delta_mm", "range_deg", "assembled", "feasible"});
  for (const problem::SensitivityPoint& point : outcome.sensitivity) {
    table.Add(problem::LinkName(point.link)).Add(point.delta_mm).Add(point.range_deg);
    table.Add(std::isnan(point.range_deg) ? 0 : 1).Add(point.feasible ? 1 : 0).EndRow();
  }
  table.Write(run.Result("sensitivity.csv"));
}

void WriteMargins(const synthesis::SynthesisOutcome& outcome, Run& run) {
  std::vector<std::string> header{"margin_mm", "status", "range_deg", "certified_upper_bound_deg", "yield_links_alone"};
  std::ranges::copy(LinkColumns(""), std::back_inserter(header));
  CsvWriter table(header);
  for (const synthesis::MarginPoint& point : outcome.margins) {
    table.Add(point.margin_mm).Add(point.solved ? "solved" : "no solution").Add(point.range_deg);
    table.Add(point.upper_bound_deg).Add(point.yield);
    for (const double value : point.links.Values()) point.solved ? table.Add(value) : table.AddEmpty();
    table.EndRow();
  }
  table.Write(run.Result("margin.csv"));
}

void WriteRounded(const problem::RoundedDesign& rounded, const problem::SynthesisProblem& problem, Run& run) {
  linkage::Design design;
  design.links = rounded.links;
  design.d_min_mm = problem.d_min_mm;
  design.range_deg = rounded.evaluation.range_deg;
  if (rounded.evaluation.stands_mm) design.d_max_mm = rounded.evaluation.stands_mm;
  design.made_by = fmt::format("lake-optimize {}, rounded to multiples of {} mm", Version(), rounded.step_mm);
  linkage::WriteDesign(run.Result("rounded.yaml"), design);
}

Json StartsJson(const synthesis::SynthesisResult& result) {
  Json starts = Json::array();
  for (std::size_t i = 0; i < result.starts.size(); ++i) {
    const synthesis::LocalSolve& solve = result.starts[i];
    starts.push_back({{"start", i},
                      {"status", NameOf(solve.solution.status)},
                      {"basin", result.basin[i] < 0 ? Json() : Json(result.basin[i])},
                      {"range_deg", NumberOrNull(solve.evaluation.range_deg)},
                      {"iterations", solve.iterations}});
  }
  return starts;
}

void Warn(const synthesis::SynthesisOutcome& outcome, Run& run) {
  if (!outcome.active.multipliers_unique)
    run.Warn(
        "multipliers are not published: at this optimum the gradients of the active limits are linearly dependent, so "
        "multipliers are not unique; ask for margins to have sensitivities");
  if (const auto& pose = outcome.result.Best().evaluation.pose) {
    const linkage::Transmission transmission = linkage::TransmissionOf(outcome.BestLinks(), *pose);
    constexpr double kUseless_mm = 1;
    if (!(transmission.moment_arm_mm > kUseless_mm))
      run.Warn(
          fmt::format("at d_min the moment arm is {:.2g} mm: the actuator holds no load there; ask for "
                      "--min-moment-arm or --max-force",
                      transmission.moment_arm_mm));
  }
  if (outcome.certificate && !outcome.certificate->reached)
    run.Warn(fmt::format(
        "the gap of the certificate is {:.3g} deg, more than asked for{}", outcome.certificate->gap_deg,
        outcome.certificate_ignores_used_range ? ": the bound leaves out the requirements over the used range" : ""));
  if (outcome.options.round_mm && !outcome.rounded)
    run.Warn(fmt::format("no design with links that are multiples of {} mm near the optimum satisfies the problem",
                         *outcome.options.round_mm));
}

Json SolvedJson(const synthesis::SynthesisOutcome& outcome) {
  const synthesis::LocalSolve& best = outcome.result.Best();
  const certificate::Certificate* certificate = outcome.certificate ? &*outcome.certificate : nullptr;
  Json json = {{"range_deg", best.evaluation.range_deg},
               {"status", NameOf(best.solution.status)},
               {"constraint_violation", std::max(best.solution.violation, best.evaluation.violation)},
               {"kkt_error", best.solution.kkt_error},
               {"certified_upper_bound_deg", certificate ? NumberOrNull(certificate->upper_bound_deg) : Json()},
               {"links", LinksJson(best.end)},
               {"iterations", best.iterations},
               {"exchanges", best.exchanges},
               {"time_s", best.seconds},
               {"multipliers_unique", outcome.active.multipliers_unique},
               {"active", ActiveJson(outcome.active)},
               {"optimum", EvaluationJson(best.evaluation)}};
  if (certificate) json["certificate"] = CertificateJson(*certificate, outcome.certificate_ignores_used_range);
  if (outcome.yield) json["yield"] = YieldJson(*outcome.yield);
  if (outcome.rounded)
    json["rounded"] = {{"step_mm", outcome.rounded->step_mm},
                       {"links", LinksJson(outcome.rounded->links)},
                       {"evaluation", EvaluationJson(outcome.rounded->evaluation)}};
  return json;
}

Json InfeasibleJson(const synthesis::SynthesisOutcome& outcome) {
  const synthesis::InfeasibilityReport& report = *outcome.infeasible;
  const problem::DesignEvaluation nearest = problem::Evaluate(report.links, outcome.problem);
  Json relaxations = Json::array();
  for (const synthesis::Relaxation& relaxation : report.relaxations)
    relaxations.push_back({{"limit", relaxation.text},
                           {"value", relaxation.limit},
                           {"relaxed", relaxation.relaxed},
                           {"unit", relaxation.unit}});
  return {{"range_deg", NumberOrNull(nearest.range_deg)},
          {"status", "infeasible"},
          {"constraint_violation", NumberOrNull(nearest.violation)},
          {"kkt_error", Json()},
          {"certified_upper_bound_deg", Json()},
          {"links", LinksJson(report.links)},
          {"reason", report.sentence},
          {"fighting", report.fighting},
          {"smallest_relaxation", relaxations},
          {"optimum", EvaluationJson(nearest)}};
}

}  // namespace

Json WriteSynthesis(const synthesis::SynthesisOutcome& outcome, Run& run) {
  WriteDesignFile(outcome, run);
  WriteOptimum(outcome, run);
  WriteConstraints(outcome, run);
  WriteStarts(outcome, run);
  WriteConvergence(outcome.result.starts[std::max(0, outcome.result.best)], "range_deg", run);
  Json summary = outcome.IsSolved() ? SolvedJson(outcome) : InfeasibleJson(outcome);
  if (outcome.IsSolved()) {
    Warn(outcome, run);
    WriteSensitivity(outcome, run);
    WriteMargins(outcome, run);
    if (outcome.rounded) WriteRounded(*outcome.rounded, outcome.problem, run);
  }
  summary["start"] = EvaluationJson(outcome.start);
  if (outcome.start_yield) summary["start"]["yield"] = YieldJson(*outcome.start_yield);
  summary["starts"] = StartsJson(outcome.result);
  return summary;
}

}  // namespace lake::commands
