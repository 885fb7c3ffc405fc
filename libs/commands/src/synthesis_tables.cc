#include <algorithm>
#include <cmath>

#include "lake/commands/optimize_tables.h"
#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/uncertain_text.h"
#include "lake/problem/problem_file.h"
#include "lake/synthesis/synthesis_outcome.h"
#include "optimum_tables.h"

namespace lake::commands {
namespace {

// The angles of a pose as rows of optimum.csv; they follow from the links.
std::vector<LimitedRow> PoseRows(const problem::DesignEvaluation& before, const problem::DesignEvaluation& after) {
  const auto row = [&](const char* name, double linkage::Pose::*angle) {
    const auto angle_deg = [&](const problem::DesignEvaluation& design) {
      return design.pose ? DegreesFromRadians(*design.pose.*angle) : kNaN;
    };
    return LimitedRow{
        .name = name, .before = angle_deg(before), .after = angle_deg(after), .limits = {kNaN, kNaN}, .multiplier = {}};
  };
  return {row("phi_deg", &linkage::Pose::phi_rad), row("theta_deg", &linkage::Pose::theta_rad)};
}

void WriteSensitivity(const synthesis::SynthesisOutcome& outcome, Run& run) {
  CsvWriter table({"link", "delta_mm", "range_deg", "assembled", "feasible"});
  for (const problem::SensitivityPoint& point : outcome.sensitivity)
    table.AddRow(problem::LengthName(point.link), point.delta_mm, point.range_deg, !std::isnan(point.range_deg),
                 point.feasible);
  table.Write(run.Result("sensitivity.csv"));
}

void WriteMargins(const synthesis::SynthesisOutcome& outcome, Run& run) {
  std::vector<std::string> header{"margin_mm", "status", "range_deg", "yield"};
  std::ranges::copy(LinkColumns(""), std::back_inserter(header));
  CsvWriter table(header);
  for (const synthesis::MarginPoint& point : outcome.margins) {
    table.Add(point.margin_mm).Add(point.solved ? "solved" : "no solution").Add(point.range_deg).Add(point.yield);
    for (const double value : point.links.Values()) table.Add(point.solved ? value : kNaN);
    table.EndRow();
  }
  table.Write(run.Result("margin.csv"));
}

void WriteRounded(const problem::RoundedDesign& rounded, const problem::SynthesisProblem& problem, Run& run) {
  WriteOptimumDesign(DesignOf(problem, rounded.links), problem, rounded.evaluation,
                     fmt::format(", rounded to multiples of {} mm", rounded.step_mm), "rounded.yaml", run);
}

// The most tolerant design beside the optimum.
void WriteYieldsOf(const synthesis::SynthesisOutcome& outcome, Run& run) {
  std::vector<std::pair<const char*, const problem::Yield*>> designs{{"optimum", &*outcome.yield}};
  if (outcome.tolerant) {
    designs.emplace_back("tolerant", &outcome.tolerant->yield);
    WriteOptimumDesign(DesignOf(outcome.problem, outcome.tolerant->links), outcome.problem,
                       outcome.tolerant->evaluation,
                       fmt::format(", limits kept within ±{} mm", SignificantText(outcome.tolerant->robust_mm, 4)),
                       "tolerant.yaml", run);
  }
  WriteYields(designs, run);
}

Json TolerantJson(const synthesis::TolerantDesign& tolerant) {
  return {{"robust_mm", tolerant.robust_mm},
          {"links", LinksJson(tolerant.links)},
          {"yield", YieldJson(tolerant.yield)},
          {"evaluation", EvaluationJson(tolerant.evaluation)}};
}

// What a builder meets, and the design that allows for it.
std::string YieldsText(const synthesis::SynthesisOutcome& outcome) {
  if (!outcome.yield) return "";
  const std::string text = YieldText(*outcome.yield);
  if (!outcome.tolerant)
    return text + "  no design was found whose limits hold for all builds within a quarter of that\n";
  return text +
         fmt::format("  with the largest share: tolerant.yaml, range {:.4f} deg\n",
                     outcome.tolerant->evaluation.range_deg) +
         YieldText(outcome.tolerant->yield);
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

void WarnOfDesign(const synthesis::SynthesisOutcome& outcome, Run& run) {
  WarnOfMultipliers(outcome.active, run);
  if (const auto& pose = outcome.result.Best().evaluation.pose) {
    const linkage::Transmission transmission = linkage::TransmissionOf(outcome.BestLinks(), *pose);
    constexpr double kUseless_mm = 1;
    if (!(transmission.moment_arm_mm > kUseless_mm))
      run.Warn(
          "at the shortest stroke the moment arm is {:.1f} mm, so the actuator holds no load there; set "
          "--min-moment-arm or --max-force",
          transmission.moment_arm_mm);
  }
  if (outcome.certificate) WarnOfCertificate(*outcome.certificate, certificate::NotInBound(outcome.problem), run);
  if (outcome.options.round_mm && !outcome.rounded)
    run.Warn(
        "near the optimum, no design whose links are multiples of {} mm satisfies the problem; try a smaller --round",
        *outcome.options.round_mm);
}

Json RoundedJson(const problem::RoundedDesign& rounded) {
  return {{"step_mm", rounded.step_mm},
          {"links", LinksJson(rounded.links)},
          {"evaluation", EvaluationJson(rounded.evaluation)}};
}

// What the multipliers are of.
const char* Gained(const problem::SynthesisProblem& problem) {
  return problem.SeeksDuration() ? "s gained" : "deg";
}

// What the summary has behind its head.
Json SolvedJson(const synthesis::SynthesisOutcome& outcome) {
  const synthesis::LocalSolve& best = outcome.result.Best();
  Json json = {{"links", LinksJson(best.end)},
               {"iterations", best.iterations},
               {"exchanges", best.exchanges},
               {"multipliers_unique", outcome.active.multipliers_unique},
               {"active", ActiveJson(outcome.active, Gained(outcome.problem))},
               {"clearances", ClearancesJson(outcome.problem)},
               {"optimum", EvaluationJson(best.evaluation)}};
  if (outcome.problem.robust_mm)
    json["robust"] = {{"tolerance_mm", *outcome.problem.robust_mm},
                      {"worst_range_deg", NumberOrNull(best.evaluation.worst_range_deg)},
                      {"builds", best.poses.builds.size()}};
  if (outcome.certificate)
    json["certificate"] = CertificateJson(*outcome.certificate, certificate::NotInBound(outcome.problem));
  if (outcome.yield) json["yield"] = YieldJson(*outcome.yield);
  if (outcome.tolerant) json["tolerant"] = TolerantJson(*outcome.tolerant);
  if (outcome.rounded) json["rounded"] = RoundedJson(*outcome.rounded);
  return json;
}

std::string ReportOf(const synthesis::SynthesisOutcome& outcome, double range_deg) {
  std::string text = RangeText(range_deg, outcome.certificate);
  if (outcome.problem.robust_mm)
    text +=
        fmt::format("  at least {:.4f} deg for every build within {} mm\n",
                    outcome.result.Best().evaluation.worst_range_deg, SignificantText(*outcome.problem.robust_mm, 4));
  return text + LinksText(outcome.BestLinks()) + ActiveText(outcome.active, Gained(outcome.problem)) +
         YieldsText(outcome);
}

Json InfeasibleJson(const synthesis::InfeasibilityReport& report, const problem::DesignEvaluation& nearest) {
  Json relaxations = Json::array();
  for (const synthesis::Relaxation& relaxation : report.relaxations)
    relaxations.push_back({{"limit", relaxation.text},
                           {"value", relaxation.limit},
                           {"relaxed", relaxation.relaxed},
                           {"unit", relaxation.unit}});
  return {{"links", LinksJson(report.links)},
          {"reason", report.sentence},
          {"fighting", report.fighting},
          {"smallest_relaxation", relaxations},
          {"optimum", EvaluationJson(nearest)}};
}

void WriteTables(const synthesis::SynthesisOutcome& outcome, const OptimumView& optimum, Run& run) {
  WriteOptimumDesign(DesignOf(outcome.problem, optimum.links_after), optimum, run);
  WriteOptimum(optimum, PoseRows(optimum.before, optimum.after), run);
  WriteConstraints(optimum, {}, run);
  std::vector<StartRow> starts;
  for (std::size_t i = 0; i < outcome.result.starts.size(); ++i)
    starts.push_back({outcome.result.starts[i], outcome.result.basin[i]});
  WriteStarts(starts, run);
  WriteConvergence(outcome.result.BestOrFirst(), "range_deg", run);
  if (!outcome.IsSolved()) return;
  WriteSensitivity(outcome, run);
  if (!outcome.margins.empty()) WriteMargins(outcome, run);
  if (outcome.yield) WriteYieldsOf(outcome, run);
  if (outcome.rounded) WriteRounded(*outcome.rounded, outcome.problem, run);
}

}  // namespace

Json WriteSynthesis(const synthesis::SynthesisOutcome& outcome, Run& run) {
  const synthesis::LocalSolve* best = outcome.IsSolved() ? &outcome.result.Best() : nullptr;
  const problem::DesignEvaluation after = problem::Evaluate(outcome.BestLinks(), outcome.problem);
  const OptimumView optimum{.problem = outcome.problem,
                            .links_before = outcome.problem.start,
                            .links_after = outcome.BestLinks(),
                            .before = outcome.start,
                            .after = after,
                            .best = best,
                            .active = outcome.active,
                            .not_a_solution = best ? "" : outcome.infeasible->sentence};
  WriteTables(outcome, optimum, run);
  const double violation = best ? std::max(best->solution.violation, after.violation) : after.violation;
  Json summary = HeadJson(optimum, violation, outcome.certificate);
  summary.update(best ? SolvedJson(outcome) : InfeasibleJson(*outcome.infeasible, after));
  if (best) {
    WarnOfDesign(outcome, run);
    run.Report(ReportOf(outcome, after.range_deg));
  }
  summary["start"] = EvaluationJson(outcome.start);
  if (outcome.start_yield) summary["start"]["yield"] = YieldJson(*outcome.start_yield);
  summary["starts"] = StartsJson(outcome.result);
  return summary;
}

}  // namespace lake::commands
