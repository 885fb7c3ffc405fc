// The work of lake-cohort: every person's study by Snakemake, then the group's tables and page; a template folder.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/core/options.h"
#include "lake/core/run.h"
#include "lake/gait/movement.h"

namespace lake::cohort {

// The folder that `lake cohort` is given, and what follows the folder for results.
struct CohortRunOptions {
  std::filesystem::path source;
  std::string level;                           // participant or group
  std::vector<std::string> participants;       // empty: all
  std::optional<gait::MovementKind> movement;  // in the place of what the studies say
  std::optional<int> cores;                    // on this machine; default: --threads
  bool slurm = false;
  int jobs = 100;  // at a time on a cluster
  std::optional<std::filesystem::path> profile;
  std::optional<std::filesystem::path> make_template;
  bool plan = false;                // only says what would be done and what it takes
  std::optional<std::string> only;  // what a job of the workflow does: motion, tables
  std::string recordings;           // of which, for motion: sub-01_ses-1
};
void Describe(CohortRunOptions& options, OptionList& list);

// Results lie in the run's folder: sub-01/ses-1/… with the study's own folders and motion/, group/, logs/. A failing
// study does not stop the others. `participant` throws Error at the end if one failed; `group` warns, and its page has
// the reasons. Returns the summary; null for what a job does.
Json RunCohort(const CohortRunOptions& options, Run& run);

// A folder to fill with recordings. Throws Error if a file of the template is there already.
void WriteTemplate(const std::filesystem::path& folder);

}  // namespace lake::cohort
