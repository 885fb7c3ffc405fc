#include "lake/commands/optimize.h"

#include <algorithm>

#include "assistance_tables.h"
#include "lake/commands/compare.h"
#include "lake/commands/gait.h"
#include "lake/commands/optimize_tables.h"
#include "lake/compare/comparison_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/plausible.h"
#include "lake/figure/charts.h"
#include "lake/figure/design_figures.h"
#include "lake/loads/body_path.h"
#include "lake/problem/problem_file.h"
#include "lake/problem/problem_options.h"
#include "lake/redesign/redesign_outcome.h"
#include "lake/report/redesign_charts.h"
#include "lake/synthesis/synthesis_outcome.h"
#include "png_and_svg.h"

namespace lake::commands {
namespace {

namespace fs = std::filesystem;

// All that a synthesis and a redesign may write: what is in the way of it is said before the work.
std::vector<std::string> ResultNames(std::initializer_list<const char*> own) {
  std::vector<std::string> names = {"summary.json", "design.yaml",     "optimum.csv",     "constraints.csv",
                                    "starts.csv",   "convergence.csv", "convergence.png", "convergence.svg"};
  names.insert(names.end(), own.begin(), own.end());
  return names;
}

void CheckSynthesis(const OptimizeRunOptions& options) {
  options.problem.CheckLoad();
  if (options.study.certify_gap_deg && options.problem.SeeksDuration())
    throw UsageError("--certify bounds the range, and --duration free seeks the shortest duration: omit one");
}

void DrawFigures(const synthesis::SynthesisOutcome& outcome, Run& run) {
  const bool is_duration = outcome.problem.SeeksDuration();
  std::vector<NamedFigure> figures = {{"convergence", [&](const fs::path& path) {
                                         figure::DrawConvergence(outcome.result.BestOrFirst(),
                                                                 is_duration ? "duration (s)" : "range of rotation (°)",
                                                                 is_duration ? 1 : -1, path);
                                       }}};
  if (outcome.IsSolved())
    figures.push_back({"sensitivity", [&](const fs::path& path) { figure::DrawSensitivity(outcome, path); }});
  if (!outcome.margins.empty())
    figures.push_back({"margin", [&](const fs::path& path) { figure::DrawMargins(outcome, path); }});
  DrawTogether(figures, run);
}

// The summary; of a failure it is written, too, which `reason` says.
Json Finished(bool is_solved, Json summary, const std::string& reason, Run& run) {
  if (is_solved) return summary;
  run.WriteFailedSummary(summary, reason);
  throw SolverError(reason);
}

Json RunSynthesis(const OptimizeRunOptions& options, Run& run) {
  CheckSynthesis(options);
  const problem::SynthesisProblem problem = problem::WithActuator(options.problem);
  std::vector<std::string> names =
      ResultNames({"sensitivity.csv", "sensitivity.png", "sensitivity.svg", "margin.csv", "margin.png", "margin.svg"});
  if (options.study.yield_tolerance_mm) names.insert(names.end(), {"yield.csv", "tolerant.yaml"});
  if (options.study.round_mm) names.push_back("rounded.yaml");
  if (problem.HasLoadProfile()) names.insert(names.end(), {"assistance.csv", "assistance.png", "assistance.svg"});
  run.Begin(names);
  const synthesis::SynthesisOutcome outcome = synthesis::RunSynthesis(problem, options.study);
  Json summary = WriteSynthesis(outcome, run);
  DrawFigures(outcome, run);
  if (outcome.IsSolved() && problem.HasLoadProfile())
    summary["assistance"] =
        WriteAssistance(problem::FindAssistance(outcome.BestLinks(), outcome.problem), outcome.problem, run);
  return Finished(outcome.IsSolved(), std::move(summary), outcome.IsSolved() ? "" : outcome.infeasible->sentence, run);
}

// Those of a catalogue, and between them that of the problem.
std::vector<double> SharesOf(const problem::SynthesisProblem& problem) {
  std::vector<double> shares = {0.05, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8, 1};
  if (problem.assist && *problem.assist > 0) shares.push_back(*problem.assist);
  std::ranges::sort(shares);
  shares.erase(std::unique(shares.begin(), shares.end()), shares.end());
  return shares;
}

void CheckFront(const OptimizeRunOptions& options) {
  if (!options.problem.profile)
    throw UsageError("--actuators compares by what the knee needs: give that with --profile loads.json");
  if (options.problem.actuator)
    throw UsageError("--actuators takes each actuator of its file, and --actuator is a single one: omit one");
  if (options.problem.duration_s)
    throw UsageError("--actuators finds the shortest duration of each actuator: omit --duration");
  if (options.reoptimize) throw UsageError("--actuators cannot be combined with a human's motion yet: omit one");
}

Json RunActuatorFront(const OptimizeRunOptions& options, Run& run) {
  CheckFront(options);
  const std::vector<problem::LinearActuator> actuators = problem::ReadActuators(options.actuators);
  run.Begin({"summary.json", "actuators_front.csv", "actuators_front.png", "actuators_front.svg"});
  const std::vector<synthesis::ActuatorCurve> curves =
      synthesis::FindActuatorFront(options.problem, actuators, SharesOf(options.problem), options.study.optimize);
  WriteActuatorFront(curves, run.Result("actuators_front.csv"));
  DrawPngAndSvg("actuators_front", run, figure::DrawActuatorFront, curves, options.problem.profile->duration_s);
  const bool is_solved = std::ranges::any_of(curves, &synthesis::ActuatorCurve::Last);
  if (is_solved) run.Report(ActuatorFrontText(curves, options.problem.profile->duration_s));
  return Finished(is_solved, ActuatorFrontJson(curves, options.problem),
                  "none of the actuators can be built in within the problem's limits; actuators_front.csv says why",
                  run);
}

// Of a joint against the knee where no trial showed both: what skin and the marker's placement, or the axis that stands
// for it, leave open.
double PlaceDeviationMm(const std::optional<double>& axis_mm) {
  const compare::RecordingBudgetOptions budget;
  return std::hypot(budget.soft_tissue_mm, axis_mm.value_or(budget.placement_mm));
}

void ReadHuman(const ReoptimizeRunOptions& options, Run& run, redesign::MeasuredMotion& measured) {
  CheckReading(options.human, options.human_reading);
  const FunctionalTables read = ReadFunctionalTables(options.human, options.human_reading, options.human_knee,
                                                     TrialSide::kHuman, options.knee, run);
  if (options.knee.knee == KneeFrom::kFunctional && !read.sd_mm)
    throw UsageError("--knee functional: {} has no markers of --segment on shank and thigh", options.human.string());
  compare::RegistrationOptions registration;
  registration.knee = options.human_knee;
  const compare::RegisteredTrial trial = compare::RegisterTrial(read.tables, registration);
  for (const std::string& warning : trial.warnings) run.Warn(warning);
  measured.human = compare::MeanCurve(trial.repetitions);
  measured.movement = trial.movement;
  measured.joint_sd_mm = PlaceDeviationMm(read.sd_mm);
}

// Of one comparison, and the design worn in it.
redesign::MeasuredMotion ReadCompared(const ReoptimizeRunOptions& options, std::size_t i) {
  redesign::MeasuredMotion measured;
  const fs::path& comparison = options.comparisons[i];
  const compare::ComparedCurves curves = compare::ReadComparison(comparison);
  if (options.knee.knee == KneeFrom::kFunctional && !curves.knee_is_functional)
    throw UsageError(
        "--knee functional: {} was made from the knee markers; run lake-compare with --knee functional and --segment, "
        "and take its folder",
        comparison.string());
  measured.human = curves.human;
  measured.movement = curves.movement;
  measured.noise_floor_percent = 100 * curves.noise_floor_relative;
  measured.joint_sd_mm = curves.joint_sd_mm.value_or(PlaceDeviationMm({}));
  if (!options.human_only) {
    measured.exo = curves.exo;
    measured.spike = curves.spike;
  }
  return measured;
}

redesign::MeasuredMotion ReadMeasured(const ReoptimizeRunOptions& options, std::size_t i, Run& run) {
  redesign::MeasuredMotion measured;
  if (options.comparisons.empty())
    ReadHuman(options, run, measured);
  else
    measured = ReadCompared(options, i);
  if (!options.worn.empty()) {
    const fs::path& worn = options.worn[options.worn.size() == 1 ? 0 : i];
    measured.worn = linkage::ReadDesign(worn);
    measured.worn_file = worn.string();
  }
  return measured;
}

// Of a design whose joint alone is limited: what soft tissue takes up.
constexpr double kAngleMismatch_deg = 5;

redesign::RedesignProblem ProblemOf(const OptimizeRunOptions& options) {
  const ReoptimizeRunOptions& reoptimize = *options.reoptimize;
  redesign::RedesignProblem problem;
  static_cast<redesign::MotionLimits&>(problem) = reoptimize;
  problem.design = problem::WithActuator(options.problem);
  // The program's own duration, not that of the profile's motion.
  if (problem.design.duration_s) problem.program.duration_s = problem.design.duration_s;
  problem.design.duration_s.reset();
  if (problem.misalignment_of == redesign::MisalignmentOf::kJoint && !problem.max_angle_mismatch_deg)
    problem.max_angle_mismatch_deg = kAngleMismatch_deg;
  if (!reoptimize.body.empty()) {
    loads::BodyPath body = loads::ReadBodyPath(reoptimize.body);
    body.aids = reoptimize.aids;
    problem.body = std::make_shared<const loads::BodyPath>(std::move(body));
  } else if (reoptimize.aids.device_kg > 0 || reoptimize.aids.hold_n > 0) {
    throw UsageError("--device-mass and --hold-force are of balance: give --body loads.json too");
  }
  return problem;
}

void CheckRedesign(const OptimizeRunOptions& options) {
  const ReoptimizeRunOptions& reoptimize = *options.reoptimize;
  if (options.problem.assist && !options.problem.profile)
    throw UsageError("--assist is a share of the knee moment: give that with --profile loads.json");
  if (options.problem.SeeksDuration())
    throw UsageError("--duration free cannot be combined with a human's motion: there the range is sought");
  if (const auto& actuator = options.problem.actuator;
      actuator && reoptimize.program.max_speed_mm_s > actuator->SpeedAt(0))
    throw UsageError("--max-speed {} mm/s is more than {} has, {} mm/s", reoptimize.program.max_speed_mm_s,
                     actuator->name, actuator->SpeedAt(0));
  if (options.problem.robust_mm)
    throw UsageError("--robust varies the links alone and cannot be combined with a human's motion yet: omit one");
  if (reoptimize.comparisons.empty() == reoptimize.human.empty())
    throw UsageError("a re-optimisation starts from --comparison DIR or from --human TRIAL: specify exactly one");
  if (reoptimize.comparisons.empty() && reoptimize.human_only)
    throw UsageError("--human-only leaves out the exoskeleton trial of --comparison, and --human has none: omit it");
  if (!reoptimize.comparisons.empty() && !reoptimize.knee.segments.shank.empty())
    throw UsageError("--segment is for --human: lake-compare has found the knees of --comparison; omit it");
  if (!reoptimize.knee.exo_segments.shank.empty())
    throw UsageError("--exo-segment belongs to lake-compare, which reads the exoskeleton trial: give it there");
  if (!reoptimize.comparisons.empty() && reoptimize.worn.empty() && !reoptimize.human_only) {
    for (const fs::path& comparison : reoptimize.comparisons)
      compare::ReadComparison(comparison);  // or says what it is
    throw UsageError(
        "--comparison has an exoskeleton trial: name the design that was worn in it with --worn DESIGN.yaml, or leave "
        "that trial out with --human-only");
  }
  if (const std::size_t worn = reoptimize.worn.size(); worn > 1 && worn != reoptimize.comparisons.size())
    throw UsageError("--worn names {} designs for {} comparisons: name one for all, or one for each", worn,
                     reoptimize.comparisons.size());
  if (!reoptimize.participants.empty() && !reoptimize.sizes)
    throw UsageError("--participants is for the rule of --sizes: give that too, or omit it");
  if (reoptimize.quantile != redesign::GroupProblem{}.quantile && reoptimize.across != redesign::Across::kQuantile)
    throw UsageError("--quantile is for --across quantile: give that too, or omit it");
  if (options.study.round_mm)
    throw UsageError(
        "--round cannot be combined with a human's motion: rounding the links would change the misalignment");
}

void DrawFigures(const redesign::RedesignOutcome& outcome, const Json& summary, Run& run) {
  std::vector<NamedFigure> figures = {
      {"convergence",
       [&](const fs::path& path) {
         figure::DrawConvergence(outcome.result.BestOrFirst().local, "range less penalties (°)", -1, path);
       }},
      {"knee_paths", [&](const fs::path& path) { figure::DrawKneePaths(path, outcome); }}};
  if (outcome.after.prediction && outcome.after.prediction->balance)
    figures.push_back({"balance", [&](const fs::path& path) { figure::DrawBalance(path, outcome); }});
  if (!outcome.fronts.empty())
    figures.push_back(
        {"pareto", [&](const fs::path& path) { figure::DrawCharts(path, {report::ParetoChart(summary)}); }});
  DrawTogether(figures, run);
}

// What a design for one person has and one for many has not.
void CheckForGroup(const OptimizeRunOptions& options) {
  for (const auto& [is_given, name] : {std::pair{options.reoptimize->pareto_points.has_value(), "--pareto"},
                                       std::pair{options.study.certify_gap_deg.has_value(), "--certify"},
                                       std::pair{options.study.yield_tolerance_mm.has_value(), "--yield"},
                                       std::pair{options.reoptimize->balance_mm.has_value(), "--balance"},
                                       std::pair{!options.reoptimize->body.empty(), "--body"},
                                       std::pair{options.reoptimize->cuff_penalty_deg_per_n > 0, "--cuff-penalty"},
                                       std::pair{options.reoptimize->aids.device_kg > 0, "--device-mass"},
                                       std::pair{options.reoptimize->aids.hold_n > 0, "--hold-force"}})
    if (is_given) throw UsageError("{} is for one person: omit it, or give one --comparison", name);
}

// Throws Error for a person without a height.
std::vector<double> ReadHeights(const fs::path& participants, const std::vector<std::string>& names) {
  const CsvTable table = CsvTable::Read(participants, '\t');
  std::vector<double> heights_mm;
  for (const std::string& name : names) {
    std::size_t row = 0;
    while (row < table.Rows() && table.Text(row, table.Column("participant_id")) != name) ++row;
    if (row == table.Rows()) throw Fail("{}: no participant_id is '{}'", participants.string(), name);
    const double height_mm = table.RequiredNumber(row, table.Column("height_mm"));
    if (!kPlausibleStature.Holds(height_mm))
      throw Fail("{}: height_mm {}: a person is {} to {} mm tall", table.Where(row), height_mm, kPlausibleStature.low,
                 kPlausibleStature.high);
    heights_mm.push_back(height_mm);
  }
  return heights_mm;
}

// The target is the knee's angle over the stride, in its time.
void SetWalk(const OptimizeRunOptions& options, const redesign::MeasuredMotion& measured,
             redesign::RedesignProblem& problem) {
  for (const auto& [is_given, name] : {std::pair{options.reoptimize->pareto_points.has_value(), "--pareto"},
                                       std::pair{options.reoptimize->balance_mm.has_value(), "--balance"},
                                       std::pair{!options.reoptimize->body.empty(), "--body"},
                                       std::pair{options.problem.profile.has_value(), "--profile"}})
    if (is_given) throw UsageError("{} is of sit-to-stands, and this motion is walking: omit it", name);
  problem.program.kind = linkage::StrokeProgram::Kind::kFree;
  problem.program.cyclic = true;
  if (!problem.program.duration_s) problem.program.duration_s = measured.human.duration_s;
  if (!problem.max_angle_mismatch_deg) problem.max_angle_mismatch_deg = kAngleMismatch_deg;
}

Json RunForGroup(const OptimizeRunOptions& options, const redesign::RedesignProblem& shared, Run& run) {
  CheckForGroup(options);
  ReoptimizeRunOptions reoptimize = *options.reoptimize;
  redesign::GroupProblem problem{
      .shared = shared, .people = {}, .across = reoptimize.across, .quantile = reoptimize.quantile};
  problem.CheckOptions();
  if (reoptimize.sizes) redesign::CheckSizes(problem, *reoptimize.sizes, reoptimize.comparisons.size());
  const std::vector<std::string> names =
      reoptimize.people.empty() ? NamesOfFolders(reoptimize.comparisons) : reoptimize.people;
  std::vector<redesign::PersonMeasured> people;
  for (std::size_t i = 0; i < names.size(); ++i) people.push_back({names[i], ReadMeasured(reoptimize, i, run)});
  for (const redesign::PersonMeasured& person : people)
    if (person.motion.movement == gait::MovementKind::kWalking)
      throw Fail("{}: it is of walking, and a linkage for many people is designed for sit-to-stands", person.name);
  if (!reoptimize.participants.empty()) reoptimize.heights_mm = ReadHeights(reoptimize.participants, names);
  run.Begin(GroupResultNames(names, reoptimize.sizes));
  if (reoptimize.sizes) {
    const redesign::SizesOutcome outcome =
        redesign::RunSizes(problem, people, *reoptimize.sizes, reoptimize.heights_mm, options.study.optimize);
    return Finished(outcome.IsSolved(), WriteSizes(outcome, run), outcome.Reason(), run);
  }
  const redesign::GroupOutcome outcome = redesign::RunGroup(problem, people, options.study.optimize);
  return Finished(outcome.IsSolved(), WriteGroup(outcome, run), outcome.reason, run);
}

Json RunRedesign(const OptimizeRunOptions& options, Run& run) {
  CheckRedesign(options);
  const redesign::RedesignOptions redesign_options{options.study, options.reoptimize->pareto_points};
  redesign_options.Check();
  redesign::RedesignProblem problem = ProblemOf(options);
  problem.CheckOptions();
  if (options.reoptimize->comparisons.size() > 1 || options.reoptimize->sizes)
    return RunForGroup(options, problem, run);
  const redesign::MeasuredMotion measured = ReadMeasured(*options.reoptimize, 0, run);
  if (measured.movement == gait::MovementKind::kWalking) SetWalk(options, measured, problem);
  std::vector<std::string> names =
      ResultNames({"before_after.csv", "cuffs.csv", "program.csv", "knee_paths.png", "knee_paths.svg",
                   "predicted/comparison.json", "predicted/misalignment.csv"});
  if (measured.worn) names.insert(names.end(), {"joint_moved/comparison.json", "joint_moved/misalignment.csv"});
  if (options.reoptimize->pareto_points) names.insert(names.end(), {"pareto.csv", "pareto.png", "pareto.svg"});
  if (options.study.yield_tolerance_mm) names.push_back("yield.csv");
  if (problem.body) names.insert(names.end(), {"balance.csv", "balance.png", "balance.svg"});
  run.Begin(names);
  const redesign::RedesignOutcome outcome = redesign::RunRedesign(problem, measured, redesign_options);
  Json summary = WriteRedesign(outcome, run);
  DrawFigures(outcome, summary, run);
  return Finished(outcome.IsSolved(), std::move(summary), outcome.IsSolved() ? "" : outcome.infeasible->sentence, run);
}

void AddInputs(const ReoptimizeRunOptions& options, std::vector<InputFile>& inputs) {
  for (const fs::path& comparison : options.comparisons)
    inputs.push_back({IsTrialFolder(comparison) ? comparison / "comparison.json" : comparison, "comparison"});
  if (!options.human.empty())
    for (InputFile& input : TrialTableInputs(options.human, "human")) inputs.push_back(std::move(input));
  for (const fs::path& worn : options.worn) inputs.push_back({worn, "worn"});
  if (!options.participants.empty()) inputs.push_back({options.participants, "participants"});
  if (!options.body.empty())
    inputs.push_back({fs::is_directory(options.body) ? options.body / "loads.json" : options.body, "body"});
}

}  // namespace

std::vector<InputFile> InputsOf(const OptimizeRunOptions& options) {
  std::vector<InputFile> inputs = problem::LoadFiles(options.problem);
  if (!options.problem_file.empty()) inputs.push_back({options.problem_file, "problem"});
  if (!options.actuators.empty()) inputs.push_back({options.actuators, "actuators"});
  if (options.reoptimize) AddInputs(*options.reoptimize, inputs);
  return inputs;
}

Json RunOptimize(const OptimizeRunOptions& options, Run& run) {
  options.study.Check();
  problem::CheckBody(options.problem);
  problem::CheckMount(options.problem);
  run.AddInputs(InputsOf(options));
  if (!options.actuators.empty()) return RunActuatorFront(options, run);
  return options.reoptimize ? RunRedesign(options, run) : RunSynthesis(options, run);
}

void Describe(ReoptimizeRunOptions& o, OptionList& options) {
  options
      .Add("comparison", o.comparisons,
           "Folder that lake-compare wrote: human and exoskeleton trial; several: one design for all these people")
      .IsPath(Option::Path::kFolder)
      .Repeats();
  options.Add("human", o.human, "A human trial alone, as lake-compare reads it");
  options.Add("human-knee", o.human_knee, "The knee marker of --human");
  Describe(o.knee, options);
  Describe(o.human_reading, options);
  options
      .Add("worn", o.worn,
           "design.yaml worn in the exoskeleton trial of --comparison; of several one for all, or one for each")
      .Repeats();
  options.Add("human-only", o.human_only, "Do not use the exoskeleton trial of --comparison");
  for (const redesign::Quantity& quantity : redesign::kQuantities) {
    if (!*quantity.help) continue;
    Option& option = options.Add(quantity.option, quantity.limit(o), quantity.help)
                         .Unit(quantity.option_unit)
                         .Otherwise(quantity.otherwise);
    quantity.is_lower ? option.NotNegative() : option.Positive();
  }
  options.Add("penalty", o.penalty_deg_per_mm, "Weight of the misalignment in the objective")
      .Unit("degrees per mm RMS")
      .Key("penalty")
      .NotNegative();
  options.AddChoice("misalignment", o.misalignment_of,
                    OptionList::Choices<redesign::MisalignmentOf>{{"joint", redesign::MisalignmentOf::kJoint},
                                                                  {"path", redesign::MisalignmentOf::kPath}},
                    "What limit and penalty are on: the joint against the knee that it is worn on, or its path against "
                    "that of the human trial");
  options.Add("body", o.body, "loads.json of the human trial, or the folder of lake-loads: whose balance it is")
      .IsPath(Option::Path::kFile)
      .Otherwise("balance is not computed");
  options
      .Add("device-mass", o.aids.device_kg,
           "The exoskeleton's own mass on this leg, which balance and moments count with shank and thigh")
      .Unit("kg")
      .Between(0, 30);
  options
      .Add("hold-force", o.aids.hold_n,
           "Upward force on the trunk, for this leg, of arm rests, a helper or a harness, in balance and moments")
      .Unit("N")
      .Between(0, 500);
  options.Add("cuff-penalty", o.cuff_penalty_deg_per_n, "Weight of the largest force at a cuff in the objective")
      .Unit("degrees per N")
      .Key("cuff_penalty")
      .NotNegative();
  Describe(o.cuffs, options);
  Describe(o.program, options);
  options.Add("fit-placement", o.fit_placement, "Optimise the placement of the joint on the shank too");
  options.Add("placement-reach", o.placement_reach_mm, "Largest distance of the joint from the knee along each axis")
      .Unit("mm")
      .Positive();
  options.AddChoice("across", o.across,
                    OptionList::Choices<redesign::Across>{{"worst", redesign::Across::kWorst},
                                                          {"mean", redesign::Across::kMean},
                                                          {"quantile", redesign::Across::kQuantile}},
                    "With several comparisons: which of the people's misalignments limit and penalty are on");
  options.Add("quantile", o.quantile, "With --across quantile: fraction of people who must meet the limit")
      .Between(0, 1);
  options
      .Add("sizes", o.sizes,
           "With several comparisons: so many designs, who wears which, and a rule for the next person")
      .AtLeast(2)
      .Otherwise("one design");
  options
      .Add("participants", o.participants,
           "With --sizes: participants.tsv, whose height_mm the rule may use; participant_id is the part by which "
           "the comparisons' folders differ")
      .Otherwise("segment lengths alone");
  options.Add("pareto", o.pareto_points, "Number of points of each Pareto front of range against misalignment")
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
  options
      .Add(
          "actuators", o.actuators,
          "A catalogue, as calibration/actuators.csv: the shortest duration of each of its actuators against the share "
          "that it gives, instead of one design")
      .Otherwise("none");
}

}  // namespace lake::commands
