// The cohort's work as Snakemake is given it: OUT/logs/cohort.json, which names the studies and what each reads and
// needs; and what became of them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/cohort/cohort_file.h"
#include "lake/cohort/group_data.h"
#include "lake/core/file_lock.h"
#include "lake/core/json.h"

namespace lake::cohort {

inline constexpr const char* kPopulationStep = "population";   // the design for all, in group/population
inline constexpr const char* kSnakemakeLog = "snakemake.log";  // in logs/, of a quiet run

// Held while a workflow is at work in a folder, and by each of its jobs until it ends, whatever becomes of the programs
// that began it: jobs that outlive a killed `lake cohort` are waited for, said on stderr unless quiet.
FileLock LockWorkflow(const std::filesystem::path& out, bool quiet);

// Writes each study.yaml and logs/cohort.json, and takes back the marks of studies that have something to do, so that
// Snakemake does them: steps whose inputs, options, outputs or program are not as they were. A study that cannot be
// read stands in the configuration with its error.
Json PrepareWorkflow(const Cohort& cohort, const std::filesystem::path& out);
Json ReadWorkflow(const std::filesystem::path& out);

// The trials of these recordings as motion files, once all of them have been tracked.
void WriteMotion(const Json& workflow, const std::string& recordings, const std::filesystem::path& out);

// Throws Error in one line where there is no Slurm that answers.
void CheckSlurm();

// Runs snakemake for `target` with the given further arguments, its words on stderr, or in its log. Returns whether all
// went well. Throws Error if it cannot be started.
bool RunSnakemake(const std::filesystem::path& out, const std::string& target,
                  const std::vector<std::string>& arguments, bool quiet, const FileLock& lock);

// A step that was not done although those before it were; of the design for all there is no participant.
struct Failure {
  std::string participant = {}, session = {}, run = {}, step = {}, error = {};

  std::string Text() const;  // "sub-03_ses-1: step exo (…): …"
};

// What has become of the studies: by the stamps of their steps.
struct WorkflowState {
  StepsDone done;
  std::vector<Failure> failures;

  bool AllWereTried() const;  // not if snakemake ended before it came to a study
};
WorkflowState StateOf(const Json& workflow, const std::filesystem::path& out);

// What the group's tables ended with; nullopt where they were not begun.
std::optional<std::string> GroupError(const std::filesystem::path& out);
void ForgetGroup(const std::filesystem::path& out);

}  // namespace lake::cohort
