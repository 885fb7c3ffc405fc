// The chapters of a study's report, each from what its steps wrote.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <string>

#include "lake/core/json.h"
#include "lake/pipeline/study_file.h"
#include "lake/report/report.h"

namespace lake {

// The folders of a study's steps.
class StudyResults {
 public:
  explicit StudyResults(std::filesystem::path out) : out_(std::move(out)) {}

  const std::filesystem::path& Folder() const { return out_; }
  bool Has(const std::string& step) const { return std::filesystem::is_regular_file(out_ / step / "summary.json"); }
  Json Summary(const std::string& step) const { return ReadJsonFile(out_ / step / "summary.json"); }

  // The picture, if it was made.
  void AddPicture(const std::filesystem::path& name, const std::string& alt, const std::string& caption,
                  report::Width width, report::Section& section) const;

 private:
  std::filesystem::path out_;
};

report::Section TrialsChapter(const StudyFile& study, const StudyResults& results);
report::Section MisalignmentChapter(const StudyResults& results);
report::Section OptimumChapter(const StudyFile& study, const StudyResults& results);
report::Section RedesignChapter(const StudyResults& results);
report::Section StrokeChapter(const StudyResults& results);
report::Section SimulationChapter(const StudyResults& results);

}  // namespace lake
