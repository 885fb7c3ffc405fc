// The cohort's work as Snakemake is given it: OUT/logs/cohort.json, which names the studies and what each reads and
// needs; and what became of them.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "lake/cohort/cohort_file.h"
#include "lake/core/file_lock.h"
#include "lake/study/study.h"

namespace lake::cohort {

inline constexpr const char* kPopulationStep = "population";   // the design for all, in group/population
inline constexpr const char* kSnakemakeLog = "snakemake.log";  // in logs/, of a quiet run

// Held while a workflow is at work in a folder, and by each of its jobs until it ends, whatever becomes of the programs
// that began it: jobs that outlive a killed `lake cohort` are waited for, said on stderr unless quiet.
FileLock LockWorkflow(const std::filesystem::path& out, bool quiet);

// The study of one folder of recordings.
struct WorkflowStudy {
  std::string name;  // "sub-01_ses-1", as Recordings::Name() has it
  std::string participant, session, run;
  std::filesystem::path file, folder;  // study.yaml, and of the results
  std::vector<std::string> steps;      // to be done, in order
  std::vector<std::string> inputs;     // what they read from outside, ascending
  study::StepNeeds needs;              // together
};

// A step that was not done although those before it were; of the design for all there is no participant.
struct Failure {
  std::string participant = {}, session = {}, run = {}, step = {}, error = {};

  std::string Text() const;  // "sub-03_ses-1: step exo (…): …"
};

struct Workflow {
  std::filesystem::path source, out;
  std::string name, task;
  bool has_population = false;
  std::vector<WorkflowStudy> studies;
  std::vector<Failure> failed;  // before any step: recordings that are missing, studies that cannot be read

  const WorkflowStudy* Find(const std::string& name) const;  // nullptr if there is none of these recordings
};

// Writes each study.yaml, nothing else. A study that cannot be read stands there with its error.
Workflow WorkflowOf(const Cohort& cohort, const std::filesystem::path& out);

// The same, and writes logs/cohort.json and takes back the marks of studies that have something to do, so that
// Snakemake does them: steps whose inputs, options, outputs or program are not as they were.
Workflow PrepareWorkflow(const Cohort& cohort, const std::filesystem::path& out);
Workflow ReadWorkflow(const std::filesystem::path& out);

// What would be done of each study; the design for all and the group's tables are left out.
Json WorkflowPlanJson(const Workflow& workflow);

// The trials of a study as motion files, once all of them have been tracked.
void WriteMotion(const Workflow& workflow, const WorkflowStudy& of);

// Throws Error in one line where there is no Slurm that answers.
void CheckSlurm();

// Runs snakemake for `target` with the given further arguments, its words on stderr, or in its log. Returns whether all
// went well. Throws Error if it cannot be started.
bool RunSnakemake(const std::filesystem::path& out, const std::string& target,
                  const std::vector<std::string>& arguments, bool quiet, const FileLock& lock);

// The steps of a study that have been done, by its name.
using StepsDone = std::map<std::string, std::set<std::string>>;

// What has become of the studies: by the stamps of their steps.
struct WorkflowState {
  StepsDone done;
  std::vector<Failure> failures;

  bool AllWereTried() const;  // not if snakemake ended before it came to a study
};
WorkflowState StateOf(const Workflow& workflow);

// What the group's tables ended with; nullopt where they were not begun.
std::optional<std::string> GroupError(const std::filesystem::path& out);
void ForgetGroup(const std::filesystem::path& out);

// The folder of the running program.
std::filesystem::path ProgramFolder();

// A file of ../share/lake/cohort beside that folder. Throws Error if it is not there.
std::filesystem::path SharedFile(const std::string& name);

}  // namespace lake::cohort
