// The work of lake-run: all steps of a study, each by the function of the program whose work it is, and one report.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/run.h"
#include "lake/steps/study_steps.h"
#include "lake/study/study_file.h"

namespace lake::study {

// Reads the files that a study names by the readers of its steps. Throws Error with study, key, file and what it is
// not: before the first step, as a step that cannot read its file may come after minutes of tracking.
void CheckFiles(const StudyFile& study);

// All steps that a study can have and that write into a folder of their own, in order.
std::vector<std::string> StudyStepNames();

// In order; each writes into its own folder below `out`, the report into `out` itself. `head` (Run::Head()) is what the
// report says of its making.
std::vector<steps::StudyStep> StudySteps(const StudyFile& study, const std::filesystem::path& out, const Json& head);

// Does what has changed since the last time and returns the summary: the steps, and of each what its own summary.json
// says, under its name. Throws what a step throws, with the step's name; `keep_going`: after all that does not read
// what failed has been done.
Json RunStudyFile(const StudyFile& study, Run& run, bool keep_going = false);

// These steps of the study alone, where something that they are made of has changed: those before them must have been
// done. Writes nothing beside their own results, so other steps may be under way at the same time. Throws as
// RunStudyFile.
void RunStudySteps(const StudyFile& study, const std::vector<std::string>& names, bool keep_going, const Run& run);

// What a scheduler gives a step: several times what the sample study takes (350 MB, 25 s on one core at most), as
// recordings are longer and larger elsewhere.
struct StepNeeds {
  int threads = 1, memory_mb = 1000, minutes = 10;
};

struct PlannedStep {
  std::string name, what, program;
  std::filesystem::path folder;
  std::vector<std::string> after;              // the steps whose outputs it reads
  std::vector<std::filesystem::path> inputs;   // files and folders
  std::vector<std::filesystem::path> outputs;  // that every run of the step leaves and others go by
  std::optional<std::string> due;              // why it would be done; nullopt: it would not be
  std::optional<std::string> failed;           // why it failed the last time
  StepNeeds needs;
  std::optional<steps::StepCost> last_run;  // nullopt: it was never done
};

// What would be done, for programs that order the steps themselves (Snakemake); all paths absolute.
struct StudyPlan {
  std::string name;
  std::filesystem::path study, out;
  std::vector<PlannedStep> steps;
};

// `made_by` is lake-run as StepRunOptions has it. Nothing is written.
StudyPlan PlanStudy(const StudyFile& study, const std::filesystem::path& out,
                    const std::string& made_by = steps::StepRunOptions::ThisProgram());
Json PlanJson(const StudyPlan& plan);

// A line per step for the terminal: how long it took, and whether it was done this time.
std::string StudyText(const std::vector<steps::StepOutcome>& outcomes);

}  // namespace lake::study
