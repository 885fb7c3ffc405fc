// The one table of a study's steps: what each is called, needs, leaves and shows, and who makes it.
#pragma once

#include <optional>
#include <vector>

#include "lake/study/study.h"
#include "step_work.h"
#include "study_chapters.h"

namespace lake::study {

struct StepKind {
  const char* name;     // of its folder, too
  const char* program;  // whose work it is
  // Nullopt for a study that has no such step. Name, program and folder are those of this table.
  std::optional<steps::StudyStep> (*make)(const StudyFile& study, const std::filesystem::path& out);
  StepNeeds needs = {};
  std::vector<const char*> outputs = {};        // that every run leaves, and others go by
  std::vector<report::Files::File> files = {};  // figures and tables that the report names, below its folder

  // Its chapter in the report, and the title of its warnings there; both come in the order of these numbers.
  report::Section (*chapter)(const StudyFile& study, const StudyResults& results) = nullptr;
  int chapter_place = 0;
  const char* warnings = "";
  int warnings_place = 0;
};

// In an order in which each comes after those that it reads.
const std::vector<StepKind>& StepKinds();

// Of all steps: it comes last, into the study's own folder.
inline constexpr const char* kReportStep = "report";

}  // namespace lake::study
