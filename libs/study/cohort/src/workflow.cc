#include "workflow.h"

#include <fcntl.h>
#include <fmt/ranges.h>
#include <pwd.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <set>

#include "lake/cohort/motion_files.h"
#include "lake/core/atomic_file.h"
#include "lake/core/child_program.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/file_descriptor.h"
#include "lake/core/interrupt.h"
#include "lake/core/paths.h"
#include "lake/core/processes.h"
#include "lake/study/study.h"

namespace lake::cohort {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMotion = "motion";
constexpr const char* kNotBegun = "not begun";

// That a study was done, for Snakemake; what it said.
fs::path MarkOf(const fs::path& out, const std::string& recordings) {
  return out / "logs" / (recordings + ".done");
}

fs::path LogOf(const fs::path& out, const std::string& recordings) {
  return out / "logs" / (recordings + ".log");
}

fs::path GroupLog(const fs::path& out) {
  return LogOf(out, "group");
}

// A file that says the same keeps its times: nothing that reads it is to be done again.
void WriteIfChanged(const fs::path& path, const std::string& text) {
  if (fs::is_regular_file(path) && ReadTextFile(path) == text) return;
  fs::create_directories(path.parent_path());
  WriteTextFile(path, text);
}

// JSON is YAML.
void WriteStudy(const Recordings& recordings, const fs::path& file) {
  Json study = recordings.study;
  study["folder"] = recordings.source.lexically_relative(file.parent_path()).string();
  WriteIfChanged(file, "# Written by lake cohort; change cohort.yaml instead.\n" + study.dump(2) + "\n");
}

bool Has(const std::vector<std::string>& names, const std::string& name) {
  return std::ranges::find(names, name) != names.end();
}

// The steps that were asked for and those that they come after, in order; all, if none were asked for.
std::vector<std::string> WantedSteps(const study::StudyPlan& plan, const std::vector<std::string>& asked) {
  std::vector<std::string> known;
  for (const study::PlannedStep& step : plan.steps) known.push_back(step.name);
  for (const std::string& name : asked)
    if (!Has(known, name))
      throw Fail("cohort.yaml: 'steps' has '{}', which this study has not: {}", name, fmt::join(known, ", "));
  if (asked.empty()) return known;
  std::set<std::string> wanted(asked.begin(), asked.end());
  for (auto step = plan.steps.rbegin(); step != plan.steps.rend(); ++step)
    if (wanted.contains(step->name)) wanted.insert(step->after.begin(), step->after.end());
  std::erase_if(known, [&](const std::string& name) { return !wanted.contains(name); });
  return known;
}

// Braces are wildcards to Snakemake.
void CheckHasNoBraces(const std::string& path) {
  if (path.find_first_of("{}") != std::string::npos)
    throw Fail("{}: Snakemake cannot work with braces in the name of a file or folder; rename it", path);
}

// What is there of what the steps of a study read from outside, and need together: two at the same time.
void AddNeeds(const study::StudyPlan& plan, WorkflowStudy& of) {
  of.needs = {.threads = 2, .memory_mb = 0, .minutes = 0};
  std::set<std::string> inputs;
  for (const study::PlannedStep& step : plan.steps) {
    if (!Has(of.steps, step.name)) continue;
    for (const fs::path& input : step.inputs)
      if (!LiesIn(input, of.folder) && fs::exists(input)) inputs.insert(input);
    of.needs.memory_mb = std::max(of.needs.memory_mb, of.needs.threads * step.needs.memory_mb);
    of.needs.minutes += step.needs.minutes;
  }
  for (const std::string& input : inputs) CheckHasNoBraces(input);
  of.inputs.assign(inputs.begin(), inputs.end());
}

std::string LakeRun() {
  return steps::StepRunOptions::ThisProgram(ProgramFolder() / "lake-run");
}

study::StudyPlan PlanOf(const WorkflowStudy& of, const std::string& made_by) {
  return study::PlanStudy(study::ReadStudyFile(of.file), of.folder, made_by);
}

// The trials that are tracked, and whether all have been.
bool AreTrialsDone(const study::StudyPlan& plan, const WorkflowStudy& of) {
  bool has_one = false;
  for (const study::PlannedStep& step : plan.steps) {
    if ((step.name != "human" && step.name != "exo") || !Has(of.steps, step.name)) continue;
    if (step.due) return false;
    has_one = true;
  }
  return has_one;
}

MotionNames MotionNamesOf(const Workflow& workflow, const WorkflowStudy& of) {
  return {.person = Recordings{of.participant, of.session, "", {}, {}}.Name(), .run = of.run, .task = workflow.task};
}

fs::path MotionFolder(const Workflow& workflow, const WorkflowStudy& of) {
  return workflow.out / of.participant / of.session / kMotion;
}

bool HasMotion(const Workflow& workflow, const WorkflowStudy& of) {
  return HasMotionFiles(of.folder, MotionNamesOf(workflow, of), MotionFolder(workflow, of));
}

// One study as it would be done; its study.yaml is written, as plans are read from it.
WorkflowStudy StudyFor(const Recordings& recordings, const std::vector<std::string>& asked, const std::string& made_by,
                       const Workflow& workflow) {
  const fs::path file = workflow.out / recordings.Folder() / "study.yaml";
  WorkflowStudy of{.name = recordings.Name(),
                   .participant = recordings.participant,
                   .session = recordings.session,
                   .run = recordings.run,
                   .file = file,
                   .folder = file.parent_path(),
                   .steps = {},
                   .inputs = {},
                   .needs = {}};
  WriteStudy(recordings, file);
  const study::StudyPlan plan = PlanOf(of, made_by);
  of.steps = WantedSteps(plan, asked);
  AddNeeds(plan, of);
  return of;
}

// Snakemake does what has no mark.
void TakeBackMark(const WorkflowStudy& of, const std::string& made_by, const Workflow& workflow) {
  const study::StudyPlan plan = PlanOf(of, made_by);
  const bool is_due = std::ranges::any_of(
      plan.steps, [&](const study::PlannedStep& step) { return Has(of.steps, step.name) && step.due; });
  if (!is_due && (!AreTrialsDone(plan, of) || HasMotion(workflow, of))) return;
  fs::remove(MarkOf(workflow.out, of.name));
  fs::remove(LogOf(workflow.out, of.name));
}

// As Snakemake reads it.
Json WorkflowJson(const Workflow& workflow) {
  Json json = {{"bin", ProgramFolder().string()}, {"source", workflow.source.string()},
               {"out", workflow.out.string()},    {"name", workflow.name},
               {"task", workflow.task},           {"population", workflow.has_population},
               {"recordings", Json::object()},    {"failed", Json::array()}};
  for (const WorkflowStudy& of : workflow.studies)
    json["recordings"][of.name] = {
        {"participant", of.participant}, {"session", of.session},        {"run", of.run},
        {"study", of.file.string()},     {"folder", of.folder.string()}, {"steps", of.steps},
        {"inputs", of.inputs},           {"threads", of.needs.threads},  {"memory_mb", of.needs.memory_mb},
        {"minutes", of.needs.minutes}};
  for (const Failure& of : workflow.failed)
    json["failed"].push_back({{"participant", of.participant},
                              {"session", of.session},
                              {"run", of.run},
                              {"step", of.step},
                              {"error", of.error}});
  return json;
}

// The error that a log ends with.
std::string ErrorIn(const fs::path& log) {
  if (!fs::is_regular_file(log)) return kNotBegun;
  std::string last;
  for (const std::string& line : SplitText(ReadTextFile(log), '\n'))
    if (!line.empty()) last = line;
  if (last.empty() || last.find(": warning: ") != std::string::npos)
    return fmt::format("it ended without a word; was it out of memory or time? See {}", log.string());
  const std::size_t program = last.starts_with("lake-") ? last.find(": ") : std::string::npos;
  return program == std::string::npos ? last : last.substr(program + 2);
}

// The steps of one study that have been done; the others to `fail`, with the reason, if they could have been.
template <typename Fail>
std::set<std::string> StepsDoneOf(const study::StudyPlan& plan, const WorkflowStudy& of, const fs::path& log,
                                  const Fail& fail) {
  std::set<std::string> done;
  for (const study::PlannedStep& step : plan.steps) {
    if (!Has(of.steps, step.name)) continue;
    if (!step.due)
      done.insert(step.name);
    else if (std::ranges::all_of(step.after, [&](const std::string& before) { return done.contains(before); }))
      fail(step.name, step.failed && fs::exists(log) ? *step.failed : ErrorIn(log));
  }
  return done;
}

}  // namespace

std::string Failure::Text() const {
  if (participant.empty()) return fmt::format("{}: {}", step, error);
  return fmt::format("{}: {}", Recordings{participant, session, run, {}, {}}.Name(), error);
}

FileLock LockWorkflow(const fs::path& out, bool quiet) {
  const fs::path path = out / "logs" / "lock";
  fs::create_directories(path.parent_path());
  return FileLock(path, [&] {
    if (!quiet) fmt::print(stderr, "waiting for jobs that outlived an earlier run in {}\n", out.string());
  });
}

const WorkflowStudy* Workflow::Find(const std::string& name) const {
  const auto found = std::ranges::find(studies, name, &WorkflowStudy::name);
  return found == studies.end() ? nullptr : &*found;
}

Workflow WorkflowOf(const Cohort& cohort, const fs::path& out) {
  CheckHasNoBraces(out.string());
  const std::string made_by = LakeRun();
  Workflow workflow{.source = cohort.folder,
                    .out = out,
                    .name = cohort.name,
                    .task = cohort.task,
                    .has_population = cohort.population.has_value(),
                    .studies = {},
                    .failed = {}};
  for (const std::string& participant : cohort.absent)
    workflow.failed.push_back({.participant = participant, .step = "recordings", .error = "there are no recordings"});
  for (const Recordings& recordings : cohort.recordings) {
    try {
      workflow.studies.push_back(StudyFor(recordings, cohort.steps, made_by, workflow));
    } catch (const Error& error) {
      workflow.failed.push_back({recordings.participant, recordings.session, recordings.run, "study", error.what()});
    }
  }
  return workflow;
}

Workflow PrepareWorkflow(const Cohort& cohort, const fs::path& out) {
  Workflow workflow = WorkflowOf(cohort, out);
  const std::string made_by = LakeRun();
  for (const WorkflowStudy& of : workflow.studies) TakeBackMark(of, made_by, workflow);
  WriteIfChanged(out / "logs" / "cohort.json", WorkflowJson(workflow).dump(1) + "\n");
  return workflow;
}

Workflow ReadWorkflow(const fs::path& out) {
  const Json json = ReadJsonFile(out / "logs" / "cohort.json");
  Workflow workflow{.source = json.at("source").get<std::string>(),
                    .out = out,
                    .name = json.at("name"),
                    .task = json.at("task"),
                    .has_population = json.at("population"),
                    .studies = {},
                    .failed = {}};
  for (const auto& [name, of] : json.at("recordings").items())
    workflow.studies.push_back(
        {.name = name,
         .participant = of.at("participant"),
         .session = of.at("session"),
         .run = of.at("run"),
         .file = of.at("study").get<std::string>(),
         .folder = of.at("folder").get<std::string>(),
         .steps = of.at("steps"),
         .inputs = of.at("inputs"),
         .needs = {.threads = of.at("threads"), .memory_mb = of.at("memory_mb"), .minutes = of.at("minutes")}});
  for (const Json& of : json.at("failed"))
    workflow.failed.push_back({of.at("participant"), of.at("session"), of.at("run"), of.at("step"), of.at("error")});
  return workflow;
}

Json WorkflowPlanJson(const Workflow& workflow) {
  const std::string made_by = LakeRun();
  Json recordings = Json::array(), failed = Json::array();
  for (const WorkflowStudy& of : workflow.studies) {
    std::vector<std::string> due;
    for (const study::PlannedStep& step : PlanOf(of, made_by).steps)
      if (step.due && Has(of.steps, step.name)) due.push_back(step.name);
    recordings.push_back({{"name", of.name}, {"due", due}});
  }
  for (const Failure& failure : workflow.failed) failed.push_back(failure.Text());
  return {{"name", workflow.name}, {"recordings", recordings}, {"failed", failed}};
}

void WriteMotion(const Workflow& workflow, const WorkflowStudy& of) {
  if (AreTrialsDone(PlanOf(of, LakeRun()), of))
    WriteMotionFiles(of.folder, MotionNamesOf(workflow, of), MotionFolder(workflow, of));
}

void CheckSlurm() {
  for (const char* program : {"sbatch", "sinfo"})
    if (!IsInPath(program))
      throw Fail("--slurm: {} is not installed here; start where jobs are submitted, or work with --cores", program);
  std::string said;
  const auto say = [&](const std::string& line) {
    if (said.empty()) said = line;
  };
  if (RunChild("sinfo", {"-h", "-o", "%P"}, say, ThrowIfInterrupted).code != 0)
    throw Fail("--slurm: Slurm does not answer: {}", said);
}

bool RunSnakemake(const fs::path& out, const std::string& target, const std::vector<std::string>& arguments, bool quiet,
                  const FileLock& lock) {
  if (!IsInPath("snakemake")) throw Error("snakemake is not installed; install the package snakemake");
  const fs::path logs = out / "logs";
  // When this program is killed, snakemake ends too.
  std::vector<std::string> words = {"setpriv",      "--pdeathsig",
                                    "TERM",         "snakemake",
                                    "--snakefile",  SharedFile("Snakefile").string(),
                                    "--configfile", (logs / "cohort.json").string(),
                                    "--directory",  logs.string(),
                                    "--keep-going", "--rerun-incomplete",
                                    "--nolock",     "--rerun-triggers",
                                    "mtime",        "--quiet",
                                    "rules"};
  // Of what is there now: a step's own stamp, where it has one, says whether it is done again. Before other options, as
  // it takes several words, and without "--", behind which Snakemake would lose what a profile says.
  if (target != "participant") words.insert(words.end(), {"--forcerun", target});
  words.insert(words.end(), arguments.begin(), arguments.end());
  words.push_back(target);
  if (const passwd* user = getpwuid(geteuid()))
    setenv("USER", user->pw_name, false);         // for Slurm, where nobody logged in
  ChildStreams streams{.in = lock.Descriptor()};  // every descendant inherits it: the lock is held until all have ended
  const FileDescriptor log(quiet ? WriteTo(logs / kSnakemakeLog) : -1);
  streams.err = quiet ? log : STDERR_FILENO;
  streams.out = streams.err;  // stdout is for results
  // Snakemake waits for its jobs to end.
  const int status = WaitForChild(StartChild(words, streams), "snakemake", std::chrono::milliseconds(50));
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

WorkflowState StateOf(const Workflow& workflow) {
  const std::string made_by = LakeRun();
  WorkflowState state{.done = {}, .failures = workflow.failed};
  for (const WorkflowStudy& of : workflow.studies) {
    const fs::path log = LogOf(workflow.out, of.name);
    const auto fail = [&](const std::string& step, const std::string& error) {
      state.failures.push_back({of.participant, of.session, of.run, step, error});
    };
    std::set<std::string>& done = state.done[of.name];
    try {
      const study::StudyPlan plan = PlanOf(of, made_by);
      done = StepsDoneOf(plan, of, log, fail);
      if (AreTrialsDone(plan, of) && !HasMotion(workflow, of)) fail(kMotion, ErrorIn(log));
    } catch (const Error& error) {
      fail("study", error.what());
    }
  }
  return state;
}

void ForgetGroup(const fs::path& out) {
  fs::remove(GroupLog(out));
}

std::optional<std::string> GroupError(const fs::path& out) {
  return fs::exists(GroupLog(out)) ? std::optional(ErrorIn(GroupLog(out))) : std::nullopt;
}

bool WorkflowState::AllWereTried() const {
  return std::ranges::none_of(failures, [](const Failure& failure) { return failure.error == kNotBegun; });
}

fs::path ProgramFolder() {
  return fs::read_symlink("/proc/self/exe").parent_path();
}

fs::path SharedFile(const std::string& name) {
  const fs::path path = (ProgramFolder() / "../share/lake/cohort" / name).lexically_normal();
  if (!fs::exists(path)) throw Fail("{}: missing from the installation; install lake again", path.string());
  return path;
}

}  // namespace lake::cohort
