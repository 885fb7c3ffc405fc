#include "lake/pipeline/compare.h"

#include "lake/compare/comparison_file.h"
#include "lake/core/error.h"
#include "lake/gait/leg_fit.h"
#include "lake/pipeline/gait.h"
#include "lake/render/misalignment_figures.h"
#include "lake/report/misalignment_sections.h"
#include "lake/report/report.h"

namespace lake {
namespace {

namespace fs = std::filesystem;

constexpr const char* kKnee = "knee";
constexpr const char* kExoKnee = "exo_knee";

bool IsTracked(const fs::path& path) {
  return FindResult(path, "kinematics.csv") && FindResult(path, "events.csv");
}

TrialTables ReadTracked(const fs::path& folder, Run& run) {
  TrialTables tables;
  tables.name = folder.string();
  const fs::path markers = TableOfFolder(folder);
  tables.trajectory = ReadMarkerCsv(markers);
  tables.motion = ReadKinematicsCsv(folder / "kinematics.csv");
  tables.events = ReadEventsCsv(folder / "events.csv");
  for (const fs::path& file : {markers, folder / "kinematics.csv", folder / "events.csv"}) run.AddInput(file);
  return tables;
}

TrialTables FitTables(const fs::path& path, const TrialOptions& reading, const std::string& knee, Run& run) {
  const Trial trial = ReadTrialFor(path, fs::is_directory(path) ? TrialOptions{} : reading, run);
  LegFitOptions fit;
  fit.facing_option = "--forward";
  if (!trial.recording.Find(kKnee)) fit.markers.knee = knee;
  const LegFitResult result = FitTrial(trial, fit, run);
  return {path.string(), result.trajectory, result.motion, result.events};
}

// The marker of the exoskeleton's knee, known only once the trial's markers are.
std::string FindExoKnee(const MarkerRecording& recording, const CompareRunOptions& options) {
  if (options.exo_knee) return *options.exo_knee;
  return recording.Find(kExoKnee) ? kExoKnee : kKnee;
}

std::string ExoKneeOf(const CompareRunOptions& options) {
  if (options.exo_knee || IsTracked(options.exo)) return options.exo_knee.value_or(kExoKnee);
  const TrialOptions reading = fs::is_directory(options.exo) ? TrialOptions{} : options.exo_reading;
  return FindExoKnee(ReadTrial(options.exo, reading).recording, options);
}

// A folder that lake-compare wrote, or the predicted path of lake-optimize: its curves are registered already.
bool IsCompared(const fs::path& path) {
  return FindResult(path, "comparison.json").has_value();
}

void CheckUnits(const TrialTables& human, const TrialTables& exo) {
  if (human.trajectory.unit != exo.trajectory.unit)
    throw Fail("{} is in {} and {} in {}: give the one in px a scale (lake-track --camera with a plane, or --scale)",
               human.name, ToString(human.trajectory.unit), exo.name, ToString(exo.trajectory.unit));
}

RegisteredTrial Register(const TrialTables& tables, const std::string& knee) {
  RegistrationOptions options;
  options.knee = knee;
  return RegisterTrial(tables, options);
}

RegisteredTrial ReadCurve(const fs::path& folder, StsCurve ComparedCurves::*side, Run& run) {
  run.AddInput(folder / "comparison.json");
  return {{ReadComparison(folder).*side}, {}};
}

// Both trials at 0..100 %, and the marker that is the exoskeleton's knee.
struct RegisteredPair {
  RegisteredTrial human, exo;
  std::string exo_knee;
};

RegisteredPair ReadPair(const CompareRunOptions& options, Run& run) {
  std::optional<TrialTables> human, exo;
  if (!IsCompared(options.human))
    human = ReadTrialTables(options.human, options.human_reading, options.human_knee, run);
  if (!IsCompared(options.exo)) exo = ReadTrialTables(options.exo, options.exo_reading, ExoKneeOf(options), run);
  if (human && exo) CheckUnits(*human, *exo);
  if (human && exo && human->trajectory.Find(kExoKnee) && !exo->trajectory.Find(kExoKnee))
    run.Warn(fmt::format("{} has a marker {} and {} has none: the trial without exoskeleton goes first", human->name,
                         kExoKnee, exo->name));
  RegisteredPair pair;
  pair.exo_knee = exo ? FindExoKnee(exo->trajectory, options) : options.exo_knee.value_or(kExoKnee);
  pair.human = human ? Register(*human, options.human_knee) : ReadCurve(options.human, &ComparedCurves::human, run);
  pair.exo = exo ? Register(*exo, pair.exo_knee) : ReadCurve(options.exo, &ComparedCurves::exo, run);
  return pair;
}

void WriteComparisonReport(const std::string& title, const Json& comparison, Run& run) {
  Report report{"Misalignment of human and exoskeleton knee", title, run.Warnings(), MisalignmentSections(comparison)};
  report.sections.push_back({"Files beside this page",
                             {report::Files{{{"misalignment.csv", "the curves, a row per percent"},
                                             {"comparison.json", "all figures and curves, as lake-optimize reads them"},
                                             {"overlay.png", "both paths"},
                                             {"misalignment.png", "error, parts and angles over the rise"}}}}});
  report.sections.push_back(ProvenanceSection(run.Head()));
  WriteReport(run.Result("report.html"), report);
}

}  // namespace

TrialTables ReadTrialTables(const fs::path& path, const TrialOptions& reading, const std::string& knee, Run& run) {
  return IsTracked(path) ? ReadTracked(path, run) : FitTables(path, reading, knee, run);
}

Json RunCompare(const CompareRunOptions& options, Run& run) {
  const RegisteredPair pair = ReadPair(options, run);
  const std::string& exo_knee = pair.exo_knee;
  run.Begin({"summary.json", "misalignment.csv", "overlay.png", "misalignment.png", "comparison.json", "report.html"});
  const Misalignment misalignment = CompareTrials(pair.human, pair.exo, options.misalignment);
  for (const std::string& warning : misalignment.warnings) run.Warn(warning);
  WriteMisalignmentCsv(run.Result("misalignment.csv"), misalignment);
  const std::string title = fmt::format("{} ({}) against {} ({})", options.exo.filename().string(), exo_knee,
                                        options.human.filename().string(), options.human_knee);
  DrawOverlayFigure(run.Result("overlay.png"), misalignment, title);
  DrawMisalignmentFigure(run.Result("misalignment.png"), misalignment, title);
  Json comparison = ComparisonJson(misalignment);
  comparison["markers"] = {{"human", options.human_knee}, {"exo", exo_knee}};
  WriteJsonFile(run.Result("comparison.json"), comparison);
  WriteComparisonReport(title, comparison, run);
  comparison.erase("curves");
  return comparison;
}

}  // namespace lake
