#include "study_report.h"

#include <algorithm>
#include <set>
#include <string>

#include "lake/core/error.h"
#include "step_table.h"
#include "study_chapters.h"

namespace lake::study {

using namespace report;

namespace {

namespace fs = std::filesystem;

// The rows of the table that the study has and that have a place by `place`, in its order.
std::vector<const StepKind*> InOrder(const StudyResults& results, int StepKind::*place) {
  std::vector<const StepKind*> kinds;
  for (const StepKind& kind : StepKinds())
    if (kind.*place != 0 && results.Has(kind.name)) kinds.push_back(&kind);
  std::ranges::sort(kinds, {}, [&](const StepKind* kind) { return kind->*place; });
  return kinds;
}

std::vector<std::string> WarningsOf(const StudyResults& results) {
  std::vector<std::string> warnings;
  std::set<std::string> said;  // several steps read one trial
  for (const StepKind* kind : InOrder(results, &StepKind::warnings_place)) {
    const Json summary = results.Summary(kind->name);
    for (const std::string warning : summary.at("warnings"))
      if (said.insert(warning).second) warnings.push_back(fmt::format("{}: {}", kind->warnings, warning));
  }
  return warnings;
}

Section MethodsChapter() {
  return {"Methods",
          {List{{"Markers: the centre of each from a model of its blob, with its own standard deviation from the "
                 "recording's noise. One robust least-squares fit over all frames gives segment angles and lengths; "
                 "the knee angle is that of the vectors ankle–knee and knee–hip, 0° straight.",
                 "Sit-to-stand: 0 % where hip or trunk leaves rest, 100 % where the knee's extension speed falls below "
                 "5 % of its peak. Repetitions are averaged at each percent.",
                 "Misalignment: the distance between the exoskeleton's and the human's knee at the same percent, over "
                 "the human's shank length there; its RMS is the root of the mean square. Placement, timing and shape "
                 "are fitted together; their shares add up to 100 %.",
                 "Design: the range of rotation is the knee angle at the actuator's shortest stroke. It is maximised "
                 "over the six links with Ipopt, exact derivatives, from many starts, under Grashof's law, order of "
                 "links, singularity and bounds (Gautam, Singla & Singla).",
                 "Re-optimisation: the same problem with the predicted path of the exoskeleton's knee on this person's "
                 "own motion; its error is the comparison's."}}}};
}

// Of steps alone there is no summary.
Section FilesChapter(const StudyFile& study, const StudyResults& results, const Json& head) {
  Files files;
  for (const StepKind& kind : StepKinds())
    for (const Files::File& file : kind.files)
      if (const fs::path path = kind.name / file.path; results.HasFile(path)) files.files.push_back({path, file.what});
  if (const auto firmware = FirmwareOf(study); firmware && results.HasFile(firmware->path))
    files.files.push_back(*firmware);
  if (const Json only = head.at("options").value("only", Json("")); only == "")
    files.files.push_back({"summary.json", "every number of every step"});
  return {"Output files", {std::move(files)}};
}

}  // namespace

bool StudyResults::Has(const std::string& step) const {
  return std::find(steps_.begin(), steps_.end(), step) != steps_.end();
}

bool StudyResults::HasFile(const fs::path& name) const {
  return Has(name.begin()->string()) && fs::is_regular_file(out_ / name);
}

void StudyResults::AddPicture(const fs::path& name, const std::string& alt, const std::string& caption, Width width,
                              Section& section) const {
  if (HasFile(name)) section.blocks.push_back(Picture{out_ / name, alt, caption, width});
}

Report MakeStudyReport(const StudyFile& study, const StudyResults& results, const Json& head) {
  Report report{study.name, "From two recordings to a better knee exoskeleton", WarningsOf(results), {}};
  report.sections.push_back(ResultChapter(study, results));
  if (results.Has("redesign")) report.sections.push_back(DetailsChapter(study, results));
  for (const StepKind* kind : InOrder(results, &StepKind::chapter_place))
    report.sections.push_back(kind->chapter(study, results));
  report.sections.push_back(MethodsChapter());
  report.sections.push_back(FilesChapter(study, results, head));
  report.sections.push_back(ProvenanceSection(head));
  return report;
}

}  // namespace lake::study
