#include "workflow.h"

#include <fcntl.h>
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
#include "program_files.h"

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

bool Has(const Json& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

// The steps that were asked for and those that they come after, in order; all, if none were asked for.
Json WantedSteps(const Json& steps, const std::vector<std::string>& asked) {
  Json known = Json::array();
  for (const Json& step : steps) known.push_back(step["name"]);
  std::set<std::string> wanted(asked.begin(), asked.end());
  for (const std::string& name : asked)
    if (!Has(known, name)) {
      std::string names;
      for (const Json& step : known) names += (names.empty() ? "" : ", ") + step.get<std::string>();
      throw Fail("cohort.yaml: 'steps' has '{}', which this study has not: {}", name, names);
    }
  if (asked.empty()) return known;
  for (auto step = steps.rbegin(); step != steps.rend(); ++step)
    if (wanted.contains((*step)["name"]))
      for (const Json& before : (*step)["after"]) wanted.insert(before.get<std::string>());
  std::erase_if(known.get_ref<Json::array_t&>(), [&](const Json& name) { return !wanted.contains(name); });
  return known;
}

// Braces are wildcards to Snakemake.
void CheckHasNoBraces(const std::string& path) {
  if (path.find_first_of("{}") != std::string::npos)
    throw Fail("{}: Snakemake cannot work with braces in the name of a file or folder; rename it", path);
}

// What the steps of a study read from outside, and need together: two at the same time.
void AddNeeds(const Json& plan, const fs::path& folder, Json& of) {
  constexpr int kThreads = 2;
  int memory_mb = 0, minutes = 0;
  std::set<std::string> inputs;
  for (const Json& step : plan["steps"]) {
    if (!Has(of["steps"], step["name"])) continue;
    for (const Json& input : step["inputs"])
      if (!LiesIn(input.get<std::string>(), folder)) inputs.insert(input.get<std::string>());
    const Json& needs = step["resources"];
    memory_mb = std::max(memory_mb, kThreads * needs["memory_mb"].get<int>());
    minutes += needs["minutes"].get<int>();
  }
  for (const std::string& input : inputs) CheckHasNoBraces(input);
  of.update({{"inputs", inputs}, {"threads", kThreads}, {"memory_mb", memory_mb}, {"minutes", minutes}});
}

std::string LakeRun() {
  return steps::StepRunOptions::ThisProgram(ProgramFolder() / "lake-run");
}

// As lake-run --plan says it.
Json PlanOf(const Json& of, const std::string& made_by) {
  return study::StudyPlan(study::ReadStudyFile(of["study"].get<std::string>()), of["folder"].get<std::string>(),
                          made_by);
}

// The trials that are tracked, and whether all have been.
bool AreTrialsDone(const Json& plan, const Json& of) {
  bool has_one = false;
  for (const Json& step : plan["steps"]) {
    if ((step["name"] != "human" && step["name"] != "exo") || !Has(of["steps"], step["name"])) continue;
    if (!step["due"].is_null()) return false;
    has_one = true;
  }
  return has_one;
}

// The motion files of one recording's trials.
struct Motion {
  fs::path study, folder;
  MotionNames names;
};

Motion MotionOf(const Json& workflow, const Json& of, const fs::path& out) {
  const std::string participant = of["participant"], session = of["session"];
  return {
      .study = of["folder"].get<std::string>(),
      .folder = out / participant / session / kMotion,
      .names = {
          .person = Recordings{participant, session, "", {}, {}}.Name(), .run = of["run"], .task = workflow["task"]}};
}

bool HasMotion(const Json& workflow, const Json& of, const fs::path& out) {
  const Motion motion = MotionOf(workflow, of, out);
  return HasMotionFiles(motion.study, motion.names, motion.folder);
}

// The plan of one study, and no mark if it has something to do.
void PlanStudy(const Recordings& recordings, const std::vector<std::string>& asked, const fs::path& out,
               const std::string& made_by, const Json& workflow, Json& of) {
  const fs::path file = out / recordings.Folder() / "study.yaml";
  WriteStudy(recordings, file);
  of["study"] = file.string();
  of["folder"] = file.parent_path().string();
  const Json plan = PlanOf(of, made_by);
  of["steps"] = WantedSteps(plan["steps"], asked);
  AddNeeds(plan, file.parent_path(), of);
  const bool is_due = std::ranges::any_of(
      plan["steps"], [&](const Json& step) { return Has(of["steps"], step["name"]) && !step["due"].is_null(); });
  if (!is_due && (!AreTrialsDone(plan, of) || HasMotion(workflow, of, out))) return;
  fs::remove(MarkOf(out, recordings.Name()));
  fs::remove(LogOf(out, recordings.Name()));
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

// Why a step of these recordings has not been done.
std::string WhyNotDone(const Json& step, const fs::path& log) {
  return step["failed"].is_null() || !fs::exists(log) ? ErrorIn(log) : step["failed"].get<std::string>();
}

// The steps of one study that have been done; the others to `fail`, with the reason, if they could have been.
template <typename Fail>
std::set<std::string> StepsDoneOf(const Json& plan, const Json& of, const fs::path& log, const Fail& fail) {
  std::set<std::string> done;
  for (const Json& step : plan["steps"]) {
    if (!Has(of["steps"], step["name"])) continue;
    if (step["due"].is_null())
      done.insert(step["name"].get<std::string>());
    else if (std::ranges::all_of(step["after"], [&](const Json& before) { return done.contains(before); }))
      fail(step["name"], WhyNotDone(step, log));
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

Json PrepareWorkflow(const Cohort& cohort, const fs::path& out) {
  CheckHasNoBraces(out.string());
  const std::string made_by = LakeRun();
  Json workflow = {{"bin", ProgramFolder().string()},
                   {"source", cohort.folder.string()},
                   {"out", out.string()},
                   {"name", cohort.name},
                   {"task", cohort.task},
                   {"population", cohort.population.has_value()},
                   {"recordings", Json::object()},
                   {"failed", Json::array()}};
  // Before any of the study's steps: what was to be found, or read.
  const auto fail = [&](const Recordings& of, const char* step, const std::string& error) {
    workflow["failed"].push_back(
        {{"participant", of.participant}, {"session", of.session}, {"run", of.run}, {"step", step}, {"error", error}});
  };
  for (const std::string& participant : cohort.absent)
    fail({participant, "", "", {}, {}}, "recordings", "there are no recordings");
  for (const Recordings& recordings : cohort.recordings) {
    Json of = {{"participant", recordings.participant}, {"session", recordings.session}, {"run", recordings.run}};
    try {
      PlanStudy(recordings, cohort.steps, out, made_by, workflow, of);
      workflow["recordings"][recordings.Name()] = std::move(of);
    } catch (const Error& error) {
      fail(recordings, "study", error.what());
    }
  }
  WriteIfChanged(out / "logs" / "cohort.json", workflow.dump(1) + "\n");
  return workflow;
}

Json ReadWorkflow(const fs::path& out) {
  return ReadJsonFile(out / "logs" / "cohort.json");
}

void WriteMotion(const Json& workflow, const std::string& recordings, const fs::path& out) {
  const Json& of = workflow["recordings"][recordings];
  if (!AreTrialsDone(PlanOf(of, LakeRun()), of)) return;
  const Motion motion = MotionOf(workflow, of, out);
  WriteMotionFiles(motion.study, motion.names, motion.folder);
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
  // When this program is killed, snakemake is told to end too.
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

WorkflowState StateOf(const Json& workflow, const fs::path& out) {
  const std::string made_by = LakeRun();
  WorkflowState state;
  for (const Json& of : workflow["failed"])
    state.failures.push_back({of["participant"], of["session"], of["run"], of["step"], of["error"]});
  for (const auto& [name, of] : workflow["recordings"].items()) {
    const fs::path log = LogOf(out, name);
    const auto fail = [&, &of = of](const std::string& step, const std::string& error) {
      state.failures.push_back({of["participant"], of["session"], of["run"], step, error});
    };
    state.done[name] = {};
    try {
      const Json plan = PlanOf(of, made_by);
      state.done[name] = StepsDoneOf(plan, of, log, fail);
      if (AreTrialsDone(plan, of) && !HasMotion(workflow, of, out)) fail(kMotion, ErrorIn(log));
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

}  // namespace lake::cohort
