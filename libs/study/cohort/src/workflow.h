// The cohort's work as Snakemake is given it: OUT/logs/cohort.json, which names the studies, their steps and what each
// step reads and needs; and what became of them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/cohort/cohort_file.h"
#include "lake/core/file_lock.h"
#include "lake/core/json.h"

namespace lake::cohort {

inline constexpr const char* kMotionStep = "motion";
inline constexpr const char* kSnakemakeLog = "snakemake.log";  // in logs/, of a quiet run

// Held while a workflow is at work in a folder, and by each of its jobs until it ends, whatever becomes of the programs
// that began it: steps that outlive a killed `lake cohort` are waited for, said on stderr unless quiet.
FileLock LockWorkflow(const std::filesystem::path& out, bool quiet);

// Writes each study.yaml and logs/cohort.json, and takes back the marks of steps that are to be done, so that Snakemake
// does them: those whose inputs, options, outputs or program are not as they were. A study that cannot be read stands
// in the configuration with its error.
Json PrepareWorkflow(const Cohort& cohort, const std::filesystem::path& out);
Json ReadWorkflow(const std::filesystem::path& out);

// Throws Error in one line where there is no Slurm that answers.
void CheckSlurm();

// Runs snakemake for `target` with the given further arguments, its words on stderr, or in its log. Returns whether all
// went well. Throws Error if it cannot be started.
bool RunSnakemake(const std::filesystem::path& out, const std::string& target,
                  const std::vector<std::string>& arguments, bool quiet, const FileLock& lock);

// A step that was not done although those before it were; of the design for all there is no participant.
struct Failure {
  std::string participant, session, run, step, error;

  std::string Text() const;  // "sub-03_ses-1: step exo (…): …"
};
std::vector<Failure> FailuresOf(const Json& workflow, const std::filesystem::path& out);

// That the design for all was made, or failed, and what the group's tables were made with.
void ForgetGroup(const std::filesystem::path& out);

// What the group's tables ended with; nullopt where they were not begun.
std::optional<std::string> GroupError(const std::filesystem::path& out);

// Not if snakemake ended before it came to a step that could be done.
bool AllWereTried(const std::vector<Failure>& failures);

// Whether this step of a study has been done.
bool IsDone(const std::filesystem::path& out, const std::string& recordings, const std::string& step);

}  // namespace lake::cohort
