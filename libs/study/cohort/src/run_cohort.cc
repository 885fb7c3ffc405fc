#include "lake/cohort/run_cohort.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <set>
#include <string>

#include "group_page.h"
#include "lake/cohort/cohort_file.h"
#include "lake/cohort/group_statistics.h"
#include "lake/commands/optimize.h"
#include "lake/core/atomic_file.h"
#include "lake/core/counted.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/core/paths.h"
#include "lake/core/provenance.h"
#include "lake/core/run.h"
#include "lake/core/threads.h"
#include "lake/steps/study_steps.h"
#include "lake/study/study.h"
#include "workflow.h"

namespace lake::cohort {
namespace {

namespace fs = std::filesystem;

using reliability::Estimate;

void WriteTrials(const GroupData& group, Run& run) {
  std::vector<std::string> header = {"participant_id", "session", "run", "trial", "repetition"};
  header.insert(header.end(), group.quantities.begin(), group.quantities.end());
  CsvWriter csv(header);
  for (const GroupRow& row : group.rows) {
    csv.Add(row.participant).Add(row.session).Add(row.run).Add(row.trial).Add(row.repetition);
    for (const std::string& quantity : group.quantities) {
      const auto found = row.values.find(quantity);
      csv.Add(found == row.values.end() ? std::nullopt : std::optional(found->second));
    }
    csv.EndRow();
  }
  csv.Write(run.Result("trials.csv"));
}

void AddEstimate(const Estimate& estimate, CsvWriter& csv) {
  csv.Add(estimate.value).Add(estimate.interval.low).Add(estimate.interval.high);
}

void WriteCurves(const std::vector<CurveRow>& rows, Run& run) {
  CsvWriter csv({"trial", "quantity", "percent", "participants", "mean", "sd", "low", "high"});
  for (const CurveRow& row : rows)
    for (int percent = 0; percent < kPercents; ++percent) {
      const reliability::MeanOfSubjects& of = row.percent[static_cast<std::size_t>(percent)];
      csv.AddRow(row.trial, row.quantity, percent, of.subjects, of.mean.value, of.standard_deviation,
                 of.mean.interval.low, of.mean.interval.high);
    }
  csv.Write(run.Result("curves.csv"));
}

void WriteReliability(const std::vector<ReliabilityRow>& rows, Run& run) {
  std::vector<std::string> header = {"trial", "quantity", "across", "participants", "judges", "mean"};
  for (const char* estimate : {"icc_2_1", "icc_3_1", "sem"})
    for (const char* end : {"", "_low", "_high"}) header.push_back(std::string(estimate) + end);
  header.push_back("mdc95");
  for (const char* estimate : {"bias", "lower_limit", "upper_limit"})
    for (const char* end : {"", "_low", "_high"}) header.push_back(std::string(estimate) + end);
  CsvWriter csv(header);
  for (const ReliabilityRow& row : rows) {
    csv.Add(row.trial).Add(row.quantity).Add(row.across);
    csv.Add(row.squares.targets).Add(row.squares.judges).Add(row.mean);
    for (const Estimate& estimate : {row.icc2, row.icc3, row.sem}) AddEstimate(estimate, csv);
    csv.Add(row.mdc95);
    for (const Estimate& estimate : {row.agreement.bias, row.agreement.lower, row.agreement.upper})
      AddEstimate(estimate, csv);
    csv.EndRow();
  }
  csv.Write(run.Result("reliability.csv"));
}

void WriteDifferences(const std::vector<DifferenceRow>& rows, Run& run) {
  CsvWriter csv({"quantity", "participants", "human", "exo", "difference", "sd", "low", "high"});
  for (const DifferenceRow& row : rows)
    csv.AddRow(row.quantity, row.difference.subjects, row.human, row.exo, row.difference.mean.value,
               row.difference.standard_deviation, row.difference.mean.interval.low, row.difference.mean.interval.high);
  csv.Write(run.Result("differences.csv"));
}

void WriteOutliers(const std::vector<OutlierRow>& rows, Run& run) {
  CsvWriter csv({"participant_id", "trial", "quantity", "value", "median", "robust_score", "why"});
  for (const OutlierRow& row : rows)
    csv.AddRow(row.participant, row.quantity.trial, row.quantity.name, row.value, row.median, row.score, row.Why());
  csv.Write(run.Result("outliers.csv"));
}

void WriteFailures(const std::vector<Failure>& failures, Run& run) {
  CsvWriter csv({"participant_id", "session", "run", "step", "error"});
  for (const Failure& of : failures) csv.AddRow(of.participant, of.session, of.run, of.step, of.error);
  csv.Write(run.Result("failures.csv"));
}

std::vector<DoneStudy> StudiesOf(const Workflow& workflow, const WorkflowState& state) {
  std::vector<DoneStudy> studies;
  for (const WorkflowStudy& of : workflow.studies)
    studies.push_back({.participant = of.participant,
                       .session = of.session,
                       .run = of.run,
                       .folder = of.folder,
                       .steps = state.done.at(of.name),
                       .has_redesign = std::ranges::find(of.steps, "redesign") != of.steps.end()});
  return studies;
}

// Writes trials.csv, curves.csv, reliability.csv, differences.csv, outliers.csv, failures.csv, figures and group.html
// into the run's folder, of what the workflow's studies have left. Throws Error if there is nothing at all.
Json WriteGroup(const Workflow& workflow, const WorkflowState& state, Run& run) {
  const GroupData group = ReadGroup(StudiesOf(workflow, state));
  if (group.rows.empty())
    throw Fail("{}: no study has results{}", workflow.out.string(),
               state.failures.empty() ? "" : "; " + state.failures.front().Text());
  const GroupFindings findings{.repetition = gait::MovementOf(group.movement).repetition,
                               .curves = CurvesOf(group),
                               .reliability = ReliabilityOf(group),
                               .differences = DifferencesOf(group),
                               .outliers = OutliersOf(group),
                               .failures = state.failures};
  std::vector<std::string> names = {"trials.csv",   "curves.csv",   "reliability.csv", "differences.csv",
                                    "outliers.csv", "failures.csv", "group.html"};
  for (const GroupFigure& figure : kGroupFigures) std::ranges::copy(figure.Files(), std::back_inserter(names));
  run.Begin(names);
  WriteTrials(group, run);
  WriteCurves(findings.curves, run);
  WriteReliability(findings.reliability, run);
  WriteDifferences(findings.differences, run);
  WriteOutliers(findings.outliers, run);
  WriteFailures(findings.failures, run);
  DrawGroupFigures(findings, run);
  report::WriteReport(run.Result("group.html"), MakeGroupPage(workflow, group, findings, run.Head()));
  return {{"participants", ParticipantsOf(group).size()},
          {"rows", group.rows.size()},
          {"failures", findings.failures.size()},
          {"outliers", findings.outliers.size()}};
}

// Each participant's first recordings whose comparison has been done, with the design that was worn.
void AddPeople(const Cohort& cohort, const Workflow& workflow, const StepsDone& done,
               commands::ReoptimizeRunOptions& options) {
  for (const Recordings& recordings : cohort.recordings) {
    const bool is_there = std::ranges::find(options.people, recordings.participant) != options.people.end();
    const auto steps = done.find(recordings.Name());
    if (is_there || steps == done.end() || !steps->second.contains("comparison")) continue;
    const fs::path& folder = workflow.Find(recordings.Name())->folder;
    options.people.push_back(recordings.participant);
    options.comparisons.push_back(folder / "comparison");
    if (options.human_only) continue;
    const auto worn = study::ReadStudyFile(folder / "study.yaml").worn;
    if (!worn)
      throw Fail(
          "cohort.yaml: 'population' uses the exo trials: name the design that was worn with study: {{design: {{worn: "
          "FILE}}}}, or leave them out with population: {{human_only: true}}");
    options.worn.push_back(*worn);
  }
}

steps::StudyStep PopulationStep(const Cohort& cohort, const Workflow& workflow, const StepsDone& done) {
  commands::OptimizeRunOptions options;
  options.problem = cohort.population->design.problem;
  options.study = cohort.population->search;
  if (cohort.population->design.file) options.problem_file = *cohort.population->design.file;
  commands::ReoptimizeRunOptions& reoptimize = options.reoptimize.emplace(cohort.population->options);
  if (reoptimize.sizes && cohort.has_heights) reoptimize.participants = cohort.folder / "participants.tsv";
  AddPeople(cohort, workflow, done, reoptimize);
  if (reoptimize.people.size() < 2)
    throw Fail("a design for many needs the comparisons of two participants at least, and there is {}",
               reoptimize.people.empty() ? "none" : "one");
  steps::StudyStep step{.name = kPopulationStep,
                        .what = "the design for all participants",
                        .program = "lake-redesign",
                        .folder = workflow.out / "group" / kPopulationStep,
                        .options = {{"population", cohort.population->section.text}, {"people", reoptimize.people}}};
  for (const InputFile& input : InputsOf(options)) step.inputs.push_back(input.path);
  step.work = [options](Run& run) {
    commands::OptimizeRunOptions work = options;
    work.study.quiet = work.study.optimize.quiet = run.Quiet();
    run.WriteSummary(commands::RunOptimize(work, run));
  };
  return step;
}

// In group/population of the results, if anything that it is made of has changed. Each participant counts once, with
// the first recordings whose comparison has been done. Throws Error where fewer than two participants have one.
void RunPopulation(const Cohort& cohort, const Workflow& workflow, const StepsDone& done, const Run& run) {
  steps::RunSteps(
      {PopulationStep(cohort, workflow, done)},
      {.command = run.Head()["command"], .quiet = run.Quiet(), .subject = {(cohort.folder / "cohort.yaml").string()}});
}

constexpr const char* kBidsVersion = "1.9.0";

// What BIDS does not know of, for its validators.
std::string Ignored() {
  std::string lines = ".*\nlogs/\ngroup/\nsummary.json\noptions.toml\n**/study.yaml\n**/report.html\n**/run-*/\n";
  for (const std::string& step : study::StudyStepNames()) lines += fmt::format("**/{}/\n", step);
  return lines;
}

constexpr const char* kReadme =
    "Results of `lake cohort`: a derivative in the order of BIDS.\n\n"
    "sub-*/[ses-*/]motion/   the trials as motion data: positions, knee angle, events\n"
    "sub-*/[ses-*/[run-*/]]  the study of each recording, in lake's own folders (see .bidsignore)\n"
    "group/                  trials.csv, curves.csv, reliability.csv, group.html\n"
    "logs/                   what each study said, and cohort.json, which Snakemake is run with\n";

// What the columns of all …_events.tsv mean that BIDS does not know.
Json EventColumns() {
  return {{"trial_type",
           {{"Description", "What the sit-to-stand has come to"},
            {"Levels",
             {{"onset", "the trunk begins to lean forward"},
              {"seat_off", "the thigh leaves the seat"},
              {"standing", "the leg is straight"},
              {"descent", "the leg begins to bend again"},
              {"seated", "the thigh is back on the seat"}}}}},
          {"repetition", {{"Description", "Number of the sit-to-stand in the recording, from 1"}}}};
}

// Relative, so that results that are passed on do not name a home folder.
std::string FileUri(const fs::path& relative) {
  std::string uri = "file:";
  for (const unsigned char c : relative.string()) {
    const bool is_plain = std::isalnum(c) || std::string_view("-._~/").find(static_cast<char>(c)) != std::string::npos;
    uri += is_plain ? std::string(1, static_cast<char>(c)) : fmt::format("%{:02X}", c);
  }
  return uri;
}

void WriteDatasetFiles(const Cohort& cohort, Run& run) {
  const fs::path out = fs::absolute(run.Folder()).lexically_normal();
  const std::string events = fmt::format("task-{}_events.json", cohort.task);
  run.Begin({"dataset_description.json", "participants.tsv", "participants.json", events, "README", ".bidsignore"});
  WriteJsonFile(run.Result("dataset_description.json"),
                {{"Name", cohort.name + ", results of lake"},
                 {"BIDSVersion", kBidsVersion},
                 {"DatasetType", "derivative"},
                 {"GeneratedBy", Json::array({{{"Name", "lake"}, {"Version", std::string(Version())}}})},
                 {"SourceDatasets", Json::array({{{"URL", FileUri(cohort.folder.lexically_relative(out))}}})}});
  WriteJsonFile(run.Result(events), EventColumns());
  WriteTextFile(run.Result("README"), kReadme);
  WriteTextFile(run.Result(".bidsignore"), Ignored());
  for (const char* table : {"participants.tsv", "participants.json"})
    if (fs::is_regular_file(cohort.folder / table))
      WriteTextFile(run.Result(table), ReadTextFile(cohort.folder / table));
}

// What was recorded stays as it is: no result lies among the recordings, or beside the cohort's own tables.
void CheckFolder(const Cohort& cohort, const fs::path& out) {
  if (LiesIn(out, cohort.folder / "sourcedata") || LiesIn(cohort.folder, out))
    throw UsageError("{}: the results need a folder of their own, outside the recordings; such as {}", out.string(),
                     (cohort.folder / "derivatives/lake").string());
}

// Snakemake looks for a profile in its own folders, too.
void CheckProfile(const fs::path& profile) {
  std::vector<fs::path> folders = {"", "/etc/xdg/snakemake"};
  if (const char* config = std::getenv("XDG_CONFIG_HOME")) folders.push_back(fs::path(config) / "snakemake");
  if (const char* home = std::getenv("HOME")) folders.push_back(fs::path(home) / ".config/snakemake");
  for (const fs::path& folder : folders)
    for (const char* name : {"config.yaml", "config.v8+.yaml"})
      if (fs::is_regular_file(folder / profile / name)) return;
  throw UsageError("--profile {}: there is no config.yaml in it; a Snakemake profile is a folder with one",
                   profile.string());
}

std::vector<std::string> SnakemakeArguments(const CohortRunOptions& options) {
  if (options.profile) {
    const bool is_folder = fs::is_directory(*options.profile);
    return {"--profile", is_folder ? fs::absolute(*options.profile).string() : options.profile->string()};
  }
  // Snakemake would ask after one job in half a minute; a Slurm without accounting forgets a job five minutes after it
  // has ended, and who was not asked after by then is an error.
  if (options.slurm)
    return {"--slurm", "--jobs", std::to_string(options.jobs), "--latency-wait", "60", "--max-status-checks-per-second",
            "1"};
  return {"--cores", std::to_string(options.cores.value_or(Threads()))};
}

// The design for all, if there is to be one, then tables and page; without that design the page says why.
void RunGroup(const Workflow& workflow, const Run& run) {
  WorkflowState state = StateOf(workflow);
  Run tables({.program = "lake-cohort",
              .command = run.Head()["command"],
              .options = run.Head()["options"],
              .out = workflow.out / "group",
              .quiet = run.Quiet()});
  try {
    if (workflow.has_population) RunPopulation(ReadCohort(workflow.source), workflow, state.done, run);
  } catch (const Error& error) {
    state.failures.push_back({.step = kPopulationStep, .error = error.what()});
    tables.Warn(state.failures.back().Text());
  }
  tables.WriteSummary(WriteGroup(workflow, state, tables));
}

// What a job of the workflow does with the results, by the workflow's own configuration.
void RunJob(const CohortRunOptions& options, const Run& run) {
  const fs::path out = fs::absolute(run.Folder()).lexically_normal();
  const Workflow workflow = ReadWorkflow(out);
  if (*options.only == "tables") return RunGroup(workflow, run);
  const WorkflowStudy* of = workflow.Find(options.recordings);
  if (!of) throw UsageError("--recordings {}: not in {}", options.recordings, (out / "logs/cohort.json").string());
  WriteMotion(workflow, *of);
}

std::string SnakemakeSays(const fs::path& out, const Run& run) {
  return "snakemake says why " + (run.Quiet() ? "in " + (out / "logs" / kSnakemakeLog).string() : "above");
}

// A study fails at several steps where one needs nothing of the other, as with both trials.
std::size_t FailedStudies(const std::vector<Failure>& failures) {
  std::set<std::array<std::string, 3>> studies;
  for (const Failure& failure : failures) studies.insert({failure.participant, failure.session, failure.run});
  return studies.size();
}

void CheckLevel(const CohortRunOptions& options) {
  if (options.make_template) return;
  if (options.source.empty()) throw UsageError("the cohort's folder is missing; --template FOLDER makes one");
  if (options.level != "participant" && options.level != "group")
    throw UsageError(options.level.empty() ? "say participant or group behind the folders"
                                           : fmt::format("'{}': participant or group", options.level));
  if (options.only && *options.only != "motion" && *options.only != "tables")
    throw UsageError("--only {}: motion or tables", *options.only);
  if (options.cores && (options.slurm || options.profile)) throw UsageError("--cores: not with --slurm or --profile");
  if (options.plan && (options.slurm || options.profile))
    throw UsageError("--plan: of this machine, so not with --slurm or --profile");
  if (options.slurm && options.profile) throw UsageError("--slurm: not with --profile, which can say so itself");
}

}  // namespace

void Describe(CohortRunOptions& o, OptionList& options) {
  options
      .AddOperand("level", o.level, "participant: every study; group: those missing, then the group's tables and page")
      .Value("participant|group");
  options.Add("participant-label", o.participants, "These participants only: 01 02 …").Value("LABEL").Repeats();
  gait::DescribeMovement(o.movement, options);
  options.Add("cores", o.cores, "Cores of this machine to work with").AtLeast(1).Otherwise("--threads");
  options.Add("slurm", o.slurm, "Hand the steps to Slurm");
  options.Add("jobs", o.jobs, "With --slurm: so many at a time").AtLeast(1);
  options.Add("profile", o.profile, "A Snakemake profile: any other cluster, or accounts and partitions of Slurm")
      .Value("DIR|NAME");
  options.Add("plan", o.plan, "Print what is to be done of each recording, as JSON; do nothing");
  options.Add("template", o.make_template, "Make a folder to fill with recordings, and do nothing else")
      .IsPath(Option::Path::kFolder);
  options.Add("only", o.only, "Do this alone, here and now, as a job of the workflow does").Value("motion|tables");
  options.Add("recordings", o.recordings, "With --only motion: of these, e.g. sub-01_ses-1").Value("NAME");
  options.Check([&o](const OptionList&) { CheckLevel(o); });
}

Json RunCohort(const CohortRunOptions& options, Run& run) {
  if (options.make_template) {
    WriteTemplate(*options.make_template);
    return {};
  }
  if (options.only) {
    RunJob(options, run);
    return {};
  }
  Cohort cohort = ReadCohort(options.source, options.participants);
  if (options.movement) SetMovement(*options.movement, cohort);
  run.AddInputs({{cohort.folder / "participants.tsv", "participants"}, {cohort.folder / "cohort.yaml", "cohort"}});
  CheckFolder(cohort, run.Folder());
  if (options.profile) CheckProfile(*options.profile);
  if (options.slurm) CheckSlurm();
  const fs::path out = fs::absolute(run.Folder()).lexically_normal();
  if (options.plan) {
    fmt::print("{}\n", WorkflowPlanJson(WorkflowOf(cohort, out)).dump(2));
    return {};
  }
  WriteDatasetFiles(cohort, run);
  const FileLock lock = LockWorkflow(out, run.Quiet());
  const Workflow workflow = PrepareWorkflow(cohort, out);
  if (workflow.studies.empty())
    throw Fail("{}: no study can be done: {}", cohort.folder.string(), workflow.failed.front().Text());
  const std::vector<std::string> arguments = SnakemakeArguments(options);
  ForgetGroup(out);
  const bool all_well = RunSnakemake(out, "participant", arguments, run.Quiet(), lock);
  const WorkflowState state = StateOf(workflow);
  if (!all_well && (state.failures.empty() || !state.AllWereTried()))
    throw Fail("snakemake ended before every study was tried; {}", SnakemakeSays(out, run));
  Json summary = {{"recordings", workflow.studies.size()}, {"failures", Json::array()}};
  const auto say = [&](const std::string& failure) {
    run.Warn(failure);
    summary["failures"].push_back(failure);
  };
  for (const Failure& failure : state.failures) say(failure.Text());
  if (options.level == "group") {
    if (!RunSnakemake(out, "group", arguments, run.Quiet(), lock))
      throw Fail("the group's tables were not made: {}", GroupError(out).value_or(SnakemakeSays(out, run)));
    summary["group"] = ReadJsonFile(out / "group" / "summary.json");
    for (const Json& warning : summary["group"]["warnings"]) say(warning);
  } else if (!state.failures.empty()) {
    throw Fail("{} of {} studies failed: {}", FailedStudies(state.failures),
               cohort.recordings.size() + cohort.absent.size(), state.failures.front().Text());
  }
  run.Report("{}, {}\n", Counted(workflow.studies.size(), "recording"), Counted(summary["failures"].size(), "failure"));
  if (const auto group = summary.find("group"); group != summary.end())
    run.Report("{}, {}: group/group.html\n", Counted(group->at("participants").get<int>(), "participant"),
               Counted(group->at("outliers").get<int>(), "outlier"));
  return summary;
}

void WriteTemplate(const fs::path& folder) {
  const fs::path from = SharedFile("template");
  if (fs::exists(folder) && !fs::is_directory(folder))
    throw Fail("{}: is a file; --template needs a folder, which it makes", folder.string());
  for (const auto& entry : fs::directory_iterator(from))
    if (fs::exists(folder / entry.path().filename()))
      throw Fail("{}: is there already; choose another folder", (folder / entry.path().filename()).string());
  for (const char* participant : {"sub-01", "sub-02"})
    fs::create_directories(folder / "sourcedata" / participant / "ses-1");
  for (const auto& entry : fs::directory_iterator(from))
    WriteTextFile(folder / entry.path().filename(), ReadTextFile(entry.path()));
}

}  // namespace lake::cohort
