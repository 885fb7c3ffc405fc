#include "workflow.h"

#include <fcntl.h>
#include <fmt/ranges.h>
#include <pwd.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <set>

#include "lake/core/atomic_file.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/paths.h"
#include "lake/core/processes.h"
#include "lake/study/study.h"
#include "population.h"
#include "program_files.h"

namespace lake::cohort {
namespace {

namespace fs = std::filesystem;

fs::path LogFolder(const fs::path& out, const std::string& recordings) {
  return out / "logs" / recordings;
}

fs::path MarkOf(const fs::path& out, const std::string& recordings, const std::string& step) {
  return LogFolder(out, recordings) / (step + ".done");
}

fs::path LogOf(const fs::path& out, const std::string& recordings, const std::string& step) {
  return LogFolder(out, recordings) / (step + ".log");
}

// That a step was done or failed.
void Forget(const fs::path& out, const std::string& recordings, const std::string& step) {
  fs::remove(MarkOf(out, recordings, step));
  fs::remove(LogOf(out, recordings, step));
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

const Json* Find(const Json& steps, const std::string& name) {
  const auto found = std::find_if(steps.begin(), steps.end(), [&](const Json& step) { return step["name"] == name; });
  return found == steps.end() ? nullptr : &*found;
}

// The steps that were asked for and those that they come after.
std::set<std::string> WantedSteps(const Json& steps, const std::vector<std::string>& asked) {
  std::set<std::string> wanted;
  std::vector<std::string> next = asked;
  if (asked.empty())
    for (const Json& step : steps) next.push_back(step["name"]);
  while (!next.empty()) {
    const std::string name = next.back();
    next.pop_back();
    const Json* step = Find(steps, name);
    if (!step) {
      std::vector<std::string> names;
      for (const Json& known : steps) names.push_back(known["name"]);
      throw Fail("cohort.yaml: 'steps' has '{}', which this study has not: {}", name, fmt::join(names, ", "));
    }
    if (wanted.insert(name).second)
      for (const Json& before : (*step)["after"]) next.push_back(before);
  }
  return wanted;
}

// Braces are wildcards to Snakemake.
void CheckHasNoBraces(const std::string& path) {
  if (path.find_first_of("{}") != std::string::npos)
    throw Fail("{}: Snakemake cannot work with braces in the name of a file or folder; rename it", path);
}

Json StepOf(const Json& plan, const fs::path& folder) {
  Json step = plan["resources"];
  step["after"] = plan["after"];
  step["inputs"] = Json::array();
  for (const Json& input : plan["inputs"])
    if (!LiesIn(input.get<std::string>(), folder)) CheckHasNoBraces(input), step["inputs"].push_back(input);
  return step;
}

// Where steps that are no one person's leave what they found for all.
fs::path CacheFolder(const fs::path& out) {
  const char* said = std::getenv("LAKE_CACHE");
  return said && *said ? fs::absolute(said).lexically_normal() : out / "logs" / "cache";
}

// The plan of one study, and no mark for what is to be done.
void PlanStudy(const Recordings& recordings, const std::vector<std::string>& asked, const fs::path& out,
               const std::string& made_by, Json& of) {
  const fs::path file = out / recordings.Folder() / "study.yaml";
  WriteStudy(recordings, file);
  of["study"] = file.string(), of["folder"] = file.parent_path().string();
  const Json plan = study::StudyPlan(study::ReadStudyFile(file), file.parent_path(), made_by);
  const std::set<std::string> wanted = WantedSteps(plan["steps"], asked);
  Json trials = Json::array();
  bool trials_due = false;
  for (const Json& step : plan["steps"]) {
    const std::string name = step["name"];
    if (!wanted.contains(name)) continue;
    of["steps"][name] = StepOf(step, file.parent_path());
    const bool is_due = !step["due"].is_null();
    if (is_due) Forget(out, recordings.Name(), name);
    if (name == "human" || name == "exo") trials.push_back(name), trials_due |= is_due;
  }
  if (trials.empty()) return;
  of["steps"][kMotionStep] = {{"after", trials}, {"inputs", Json::array()}};
  if (trials_due || !fs::is_directory(out / recordings.participant / recordings.session / kMotionStep))
    Forget(out, recordings.Name(), kMotionStep);
}

// `lock` becomes the children's standard input, which every descendant inherits: so the lock is held until all have
// ended. When this program is killed, snakemake is told to end too (setpriv).
int Spawn(std::vector<std::string> words, int lock, const std::optional<fs::path>& log) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, lock, STDIN_FILENO);
  if (log) posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, log->c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
  posix_spawn_file_actions_adddup2(&actions, STDERR_FILENO, STDOUT_FILENO);  // stdout is for results
  // A process group of its own: Ctrl-C is for this program, which then ends snakemake and its jobs.
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  if (const passwd* user = getpwuid(geteuid()))
    setenv("USER", user->pw_name, false);  // for Slurm, where nobody logged in
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t child = 0;
  const int error = posix_spawnp(&child, arguments.front(), &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw Fail("{} cannot be started: {}", words.front(), std::strerror(error));
  return WaitForChild(child, "snakemake", std::chrono::milliseconds(50));  // which waits for its jobs to end
}

// Whether a program is in PATH.
bool IsInstalled(const std::string& program) {
  const char* path = std::getenv("PATH");
  for (const std::string& folder : SplitText(path ? path : "", ':'))
    if (access((fs::path(folder) / program).c_str(), X_OK) == 0) return true;
  return false;
}

constexpr const char* kGroupLog = "group.log";
constexpr const char* kNotBegun = "not begun";

// The error that a step's log ends with.
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

}  // namespace

std::string Failure::Text() const {
  if (participant.empty()) return fmt::format("{}: {}", step, error);
  return fmt::format("{}: {}", Recordings{participant, session, run, {}, {}}.Name(), error);
}

FileLock LockWorkflow(const fs::path& out, bool quiet) {
  const fs::path path = out / "logs" / "lock";
  fs::create_directories(path.parent_path());
  return FileLock(path, [&] {
    if (!quiet) fmt::print(stderr, "waiting for steps that outlived an earlier run in {}\n", out.string());
  });
}

Json PrepareWorkflow(const Cohort& cohort, const fs::path& out) {
  CheckHasNoBraces(out.string());
  const std::string made_by = steps::StepRunOptions::ThisProgram(ProgramFolder() / "lake-run");
  Json workflow = {{"bin", ProgramFolder().string()},
                   {"source", cohort.folder.string()},
                   {"out", out.string()},
                   {"cache", CacheFolder(out).string()},
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
    Json of = {{"participant", recordings.participant},
               {"session", recordings.session},
               {"run", recordings.run},
               {"steps", Json::object()}};
    try {
      PlanStudy(recordings, cohort.steps, out, made_by, of);
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

void CheckSlurm() {
  for (const char* program : {"sbatch", "sinfo"})
    if (!IsInstalled(program))
      throw Fail("--slurm: {} is not installed here; start where jobs are submitted, or work with --cores", program);
  std::string said;
  FILE* pipe = popen("sinfo -h -o %P 2>&1", "r");
  if (!pipe) throw Fail("--slurm: sinfo cannot be started: {}", std::strerror(errno));
  char line[1024];
  while (std::fgets(line, sizeof line, pipe)) said += line;
  if (pclose(pipe) != 0) throw Fail("--slurm: Slurm does not answer: {}", said.substr(0, said.find('\n')));
}

bool RunSnakemake(const fs::path& out, const std::string& target, const std::vector<std::string>& arguments, bool quiet,
                  const FileLock& lock) {
  if (!IsInstalled("snakemake")) throw Error("snakemake is not installed; install the package snakemake");
  const fs::path logs = out / "logs";
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
  const int status = Spawn(words, lock.Descriptor(), quiet ? std::optional(logs / kSnakemakeLog) : std::nullopt);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

std::vector<Failure> FailuresOf(const Json& workflow, const fs::path& out) {
  std::vector<Failure> failures;
  for (const Json& of : workflow["failed"])
    failures.push_back({of["participant"], of["session"], of["run"], of["step"], of["error"]});
  for (const auto& [name, of] : workflow["recordings"].items())
    for (const auto& [step, plan] : of["steps"].items()) {
      const bool could_be_done =
          std::all_of(plan["after"].begin(), plan["after"].end(),
                      [&, &name = name](const Json& before) { return IsDone(out, name, before); });
      if (could_be_done && !IsDone(out, name, step))
        failures.push_back({of["participant"], of["session"], of["run"], step, ErrorIn(LogOf(out, name, step))});
    }
  if (workflow.value("population", false) && !fs::exists(out / "logs" / "population.done"))
    if (const fs::path log = out / "logs" / "population.log"; fs::exists(log))
      failures.push_back({"", "", "", kPopulationStep, ErrorIn(log)});
  return failures;
}

void ForgetGroup(const fs::path& out) {
  for (const char* file : {"population.done", "population.log", kGroupLog}) fs::remove(out / "logs" / file);
}

std::optional<std::string> GroupError(const fs::path& out) {
  const fs::path log = out / "logs" / kGroupLog;
  return fs::exists(log) ? std::optional(ErrorIn(log)) : std::nullopt;
}

bool AllWereTried(const std::vector<Failure>& failures) {
  return std::none_of(failures.begin(), failures.end(),
                      [](const Failure& failure) { return failure.error == kNotBegun; });
}

bool IsDone(const fs::path& out, const std::string& recordings, const std::string& step) {
  return fs::exists(MarkOf(out, recordings, step));
}

}  // namespace lake::cohort
