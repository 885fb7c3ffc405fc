// A cohort as a folder: who takes part, where each one's recordings are, and the study that is made of them.
//
//   participants.tsv                     participant_id and any other columns (BIDS)
//   sourcedata/sub-01[/ses-1][/run-1]/   one folder of recordings each
//   cohort.yaml:
//     name, task: texts                  task is the label of the movement in the names of files
//     steps: [comparison, …]             which of the study's steps are done, with those before them; absent: all
//     study: a study.yaml (study_file.h), its paths relative to the folder of recordings
//     people: {sub-01: …, sub-01_ses-2: …}   what is different in the study of one person or recording; ~ takes a key
//     population: one design for all of them, or several sizes; absent: none
//     out
//
// In texts of the study $cohort stands for the cohort's folder and $COLUMN for the person's cell of participants.tsv; a
// value that is nothing but such a name is left out where the cell is n/a. $$ is a $.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "lake/core/json.h"
#include "lake/study/study_file.h"

namespace lake::cohort {

// One folder of recordings.
struct Recordings {
  std::string participant;   // "sub-01"
  std::string session, run;  // "ses-1", "run-1"; empty where there are no such folders
  std::filesystem::path source;
  Json study;  // what study.yaml says for it; paths relative to `source`, but for $cohort

  std::string Name() const;              // "sub-01_ses-1_run-1"
  std::filesystem::path Folder() const;  // "sub-01/ses-1/run-1"
};

struct Cohort {
  std::filesystem::path folder;  // absolute
  std::string name, task;
  std::vector<std::string> steps;
  std::vector<Recordings> recordings;              // in the order of participants.tsv, then of sessions and runs
  std::vector<std::string> absent;                 // participants without recordings
  std::optional<study::StudyRedesign> population;  // one design for all of them, or several sizes
  bool has_heights = false;                        // participants.tsv has everybody's height_mm
};

// Those of the given participants ("01" or "sub-01"), or of all. Throws Error in one line with file and line: labels
// that are not letters and digits, a participant that stands twice, recordings of a participant who is not in the
// table, an unknown key, column or name; UsageError for a participant who is not there.
Cohort ReadCohort(const std::filesystem::path& folder, const std::vector<std::string>& participants = {});

// In the place of what the studies' trials say of it.
void SetMovement(gait::MovementKind movement, Cohort& cohort);

}  // namespace lake::cohort
