#include "lake/commands/optimize.h"

#include "lake/commands/compare.h"
#include "lake/commands/optimize_tables.h"
#include "lake/compare/comparison_file.h"
#include "lake/core/error.h"
#include "lake/figure/reoptimize_figures.h"
#include "lake/figure/synthesis_figures.h"
#include "lake/problem/problem_file.h"
#include "lake/problem/problem_options.h"
#include "lake/redesign/program_options.h"
#include "lake/redesign/reoptimize_outcome.h"
#include "lake/synthesis/synthesis_options.h"

namespace lake::commands {
namespace {

namespace fs = std::filesystem;

Json RunSynthesis(const OptimizeRunOptions& options, Run& run) {
  run.Begin();
  const synthesis::SynthesisOutcome outcome = synthesis::RunSynthesis(options.problem, options.study);
  Json summary = WriteSynthesis(outcome, run);
  figure::DrawConvergence(outcome.result.BestOrFirst(), "range of rotation, deg", run.Result("convergence.png"));
  if (!outcome.IsSolved()) {
    run.WriteSummary(summary);
    throw SolverError(outcome.infeasible->sentence);
  }
  figure::DrawSensitivity(outcome, run.Result("sensitivity.png"));
  figure::DrawMargins(outcome, run.Result("margin.png"));
  return summary;
}

compare::StsCurve ReadHuman(const ReoptimizeRunOptions& options, Run& run) {
  const compare::TrialTables tables = ReadTrialTables(options.human, options.human_reading, options.human_knee, run);
  compare::RegistrationOptions registration;
  registration.knee = options.human_knee;
  const compare::RegisteredTrial trial = compare::RegisterTrial(tables, registration);
  for (const std::string& warning : trial.warnings) run.Warn(warning);
  return compare::MeanCurve(trial.repetitions);
}

redesign::MeasuredMotion ReadMeasured(const ReoptimizeRunOptions& options, Run& run) {
  redesign::MeasuredMotion measured;
  if (options.comparison.empty()) {
    measured.human = ReadHuman(options, run);
  } else {
    const compare::ComparedCurves curves = compare::ReadComparison(options.comparison);
    run.AddInput(fs::is_directory(options.comparison) ? options.comparison / "comparison.json" : options.comparison);
    measured.human = curves.human, measured.noise_floor_percent = 100 * curves.noise_floor_relative;
    if (!options.human_only) measured.exo = curves.exo, measured.spike = curves.spike;
  }
  if (!options.worn.empty()) {
    measured.worn = linkage::ReadDesign(options.worn), measured.worn_file = options.worn.string();
    run.AddInput(options.worn);
  }
  return measured;
}

redesign::ReoptimizeProblem ProblemOf(const OptimizeRunOptions& options) {
  redesign::ReoptimizeProblem problem;
  const ReoptimizeRunOptions& reoptimize = *options.reoptimize;
  problem.design = options.problem;
  problem.program = reoptimize.program;
  problem.max_misalignment_percent = reoptimize.max_misalignment_percent;
  problem.penalty_deg_per_mm = reoptimize.penalty_deg_per_mm;
  problem.fit_placement = reoptimize.fit_placement;
  problem.placement_reach_mm = reoptimize.placement_reach_mm;
  return problem;
}

void CheckReoptimize(const OptimizeRunOptions& options) {
  const ReoptimizeRunOptions& reoptimize = *options.reoptimize;
  if (reoptimize.comparison.empty() == reoptimize.human.empty())
    throw UsageError("a re-optimisation starts from --comparison DIR or from --human TRIAL: give one of both");
  if (reoptimize.comparison.empty() && reoptimize.human_only)
    throw UsageError("--human-only leaves the exoskeleton trial of --comparison out; --human has none");
  if (!reoptimize.comparison.empty() && reoptimize.worn.empty() && !reoptimize.human_only)
    throw UsageError(
        "--comparison has an exoskeleton trial: name the design that was worn in it with --worn DESIGN.yaml, or leave "
        "that trial out with --human-only");
  if (options.study.round_mm)
    throw UsageError("--round is of a synthesis alone: a rounded design has another misalignment");
}

redesign::ReoptimizeOptions ReoptimizeOptionsOf(const OptimizeRunOptions& options) {
  redesign::ReoptimizeOptions reoptimize;
  reoptimize.optimize = options.study.optimize;
  reoptimize.pareto_points = options.reoptimize->pareto_points;
  reoptimize.certify_gap_deg = options.study.certify_gap_deg;
  reoptimize.certify_boxes = options.study.certify_boxes;
  reoptimize.yield_tolerance_mm = options.study.yield_tolerance_mm;
  reoptimize.quiet = options.study.quiet;
  return reoptimize;
}

void DrawFigures(const redesign::ReoptimizeOutcome& outcome, Run& run) {
  figure::DrawConvergence(outcome.result.BestOrFirst().local, "objective, deg", run.Result("convergence.png"));
  figure::DrawKneePaths(outcome, run.Result("knee_paths.png"));
  if (!outcome.fronts.empty()) figure::DrawPareto(outcome, run.Result("pareto.png"));
}

Json RunReoptimize(const OptimizeRunOptions& options, Run& run) {
  CheckReoptimize(options);
  const redesign::ReoptimizeOptions reoptimize_options = ReoptimizeOptionsOf(options);
  reoptimize_options.Check();
  const redesign::ReoptimizeProblem problem = ProblemOf(options);
  problem.CheckOptions();
  const redesign::MeasuredMotion measured = ReadMeasured(*options.reoptimize, run);
  run.Begin();
  const redesign::ReoptimizeOutcome outcome = redesign::RunReoptimization(problem, measured, reoptimize_options);
  Json summary = WriteReoptimization(outcome, run);
  DrawFigures(outcome, run);
  if (!outcome.IsSolved()) {
    run.WriteSummary(summary);
    throw SolverError(outcome.infeasible->sentence);
  }
  return summary;
}

}  // namespace

Json RunOptimize(const OptimizeRunOptions& options, Run& run) {
  options.study.Check();
  if (!options.problem_file.empty()) run.AddInput(options.problem_file);
  return options.reoptimize ? RunReoptimize(options, run) : RunSynthesis(options, run);
}

void Describe(ReoptimizeRunOptions& o, OptionList& options) {
  options.Add("comparison", o.comparison, "Folder that lake-compare wrote: human and exoskeleton trial")
      .IsPath(Option::Path::kFolder);
  options.Add("human", o.human, "A human trial alone, as lake-compare reads it");
  options.Add("human-knee", o.human_knee, "The knee marker of --human");
  Describe(o.human_reading, options);
  options.Add("worn", o.worn, "design.yaml worn in the exoskeleton trial of --comparison");
  options.Add("human-only", o.human_only, "Ignore the exoskeleton trial of --comparison");
  options.Add("max-misalignment", o.max_misalignment_percent, "Largest misalignment allowed, RMS relative to the shank")
      .Unit("percent")
      .Positive();
  options.Add("penalty", o.penalty_deg_per_mm, "Range given up for less misalignment")
      .Unit("degrees per mm RMS")
      .Key("penalty")
      .NotNegative();
  Describe(o.program, options);
  options.Add("fit-placement", o.fit_placement, "Also move the exoskeleton's joint on the shank");
  options
      .Add("placement-reach", o.placement_reach_mm,
           "Farthest that the joint may sit from the knee, to either side (with --fit-placement)")
      .Unit("mm")
      .Positive();
  options
      .Add("pareto", o.pareto_points,
           "Range against misalignment in this many points, for a constant and a short free program")
      .AtLeast(2);
}

void Describe(OptimizeRunOptions& o, OptionList& options) {
  const auto read = [&o](const OptionTexts& texts, const std::string&) {
    o.problem_file = texts.front();
    o.problem = problem::ReadProblem(o.problem_file);
  };
  options.AddCustom("problem", "Problem file", read).Otherwise("the paper's problem").IsPath(Option::Path::kFile);
  Describe(o.problem, options);  // after the file, which these change
  Describe(o.study, options);
}

}  // namespace lake::commands
