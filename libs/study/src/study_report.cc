#include "study_report.h"

#include <algorithm>

#include "lake/core/error.h"
#include "lake/report/misalignment_sections.h"
#include "study_chapters.h"

namespace lake::study {

using namespace report;

namespace {

namespace fs = std::filesystem;

// What each step's warnings are about, by weight: first what is to be built, last the benchmark.
struct WarningsFrom {
  const char *step, *what;
};
constexpr WarningsFrom kByWeight[] = {{"simulation", "Fit on the body"},
                                      {"redesign", "New design"},
                                      {"stroke", "Stroke program"},
                                      {"assistance", "Assistance"},
                                      {"loads", "Loads"},
                                      {"comparison", "Misalignment"},
                                      {"human", "Human trial"},
                                      {"exo", "Exoskeleton trial"},
                                      {"plane", "Sagittal plane"},
                                      {"calibration", "Camera"},
                                      {"optimum", "Benchmark optimum"}};

std::vector<std::string> WarningsOf(const StudyResults& results) {
  std::vector<std::string> warnings;
  for (const auto& [step, what] : kByWeight) {
    if (!results.Has(step)) continue;
    const Json summary = results.Summary(step);
    for (const Json& warning : summary.at("warnings"))
      warnings.push_back(fmt::format("{}: {}", what, warning.get<std::string>()));
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

// A step alone writes no summary of all.
Section FilesChapter(const StudyResults& results, const Json& head) {
  const bool has_summary = head.at("options").value("only", "").empty();
  const std::vector<Files::File> all = {
      {"human/overlay.mp4", "the human trial with skeleton, trails and angle"},
      {"exo/overlay.mp4", "the exoskeleton trial with skeleton, trails and angle"},
      {"human/track.png", "figure of the human trial: paths, knee angle, residuals"},
      {"exo/track.png", "figure of the exoskeleton trial"},
      {"human/kinematics.csv", "angles and vectors frame by frame"},
      {"exo/kinematics.csv", "the same for the exoskeleton trial"},
      {"comparison/report.html", "the whole comparison, all figures"},
      {"comparison/misalignment.csv", "its curves, a row per percent"},
      {"loads/loads.csv", "moments at ankle, knee and hip of each rise"},
      {"assistance/design.yaml", "the links for the actuator and what the knee needs"},
      {"assistance/assistance.csv", "its force, speed and power over the rise"},
      {"assistance/actuators_front.csv", "each actuator's shortest rise and links"},
      {"optimum/design.yaml", "the optimum of the design problem"},
      {"redesign/design.yaml", "the re-optimised design"},
      {"simulation/angle_vs_stroke.csv", "angle, moment arm and force over stroke"},
      {"simulation/animation.mp4", "the linkage moving"},
      {"simulation/design.dxf", "link plates, 1:1 in mm"},
      {"simulation/schematic.svg", "schematic with the symbols"},
      {"simulation/mannequin.png", "the design on the body"},
      {"stroke/lake_stroke/lake_stroke.ino", "firmware for the Arduino UNO"},
      {"stroke/program.csv", "the stroke program"},
      {"summary.json", "every number of every step"}};
  Files files;
  for (const Files::File& file : all)
    if (file.path == "summary.json" ? has_summary : results.HasFile(file.path)) files.files.push_back(file);
  return {"Output files", {std::move(files)}};
}

}  // namespace

const std::vector<std::string>& StudyStepNames() {
  static const std::vector<std::string> kInOrder = {"calibration", "plane",      "human",   "exo",
                                                    "comparison",  "loads",      "optimum", "redesign",
                                                    "assistance",  "simulation", "stroke"};
  return kInOrder;
}

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
  Report report{
      study.name, "From two recordings of a sit-to-stand to a better knee exoskeleton", WarningsOf(results), {}};
  report.sections.push_back(ResultChapter(results));
  if (results.Has("redesign")) report.sections.push_back(RedesignChapter(results));
  if (results.Has("loads")) report.sections.push_back(LoadsChapter(results));
  report.sections.push_back(SimulationChapter(results));
  if (results.Has("stroke")) report.sections.push_back(StrokeChapter(results));
  if (results.Has("comparison")) report.sections.push_back(MisalignmentChapter(results));
  report.sections.push_back(TrialsChapter(study, results));
  report.sections.push_back(OptimumChapter(study, results));
  report.sections.push_back(MethodsChapter());
  report.sections.push_back(FilesChapter(results, head));
  report.sections.push_back(ProvenanceSection(head));
  return report;
}

}  // namespace lake::study
