#include "lake/study/study.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/core/json_or_null.h"
#include "lake/core/paths.h"
#include "lake/report/report.h"
#include "lake/study/study_file.h"
#include "step_work.h"
#include "study_chapters.h"

namespace lake::study {
namespace {

// The one table of a study's steps: what each is called, needs, leaves and shows, and who makes it.
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
const std::vector<StepKind>& StepKinds() {
  static const std::vector<StepKind> kInOrder = {
      {.name = "calibration",
       .program = "lake-calibrate",
       .make = CalibrationStep,
       .needs = {.threads = 2, .memory_mb = 2000, .minutes = 60},
       .outputs = {"camera.yaml", "summary.json"},
       .warnings = "Camera",
       .warnings_place = 10},
      {.name = "plane",
       .program = "lake-calibrate",
       .make = PlaneStep,
       .outputs = {"camera.yaml", "summary.json"},
       .warnings = "Sagittal plane",
       .warnings_place = 9},
      {.name = "human",
       .program = nullptr,  // lake-track of a video, lake-gait of a trial
       .make = HumanStep,
       .needs = {.threads = 2, .memory_mb = 2000, .minutes = 60},
       .outputs = {"kinematics.csv", "events.csv", "summary.json"},
       .files = {{"overlay.mp4", "the human trial with skeleton, trails and angle"},
                 {"track.png", "figure of the human trial: paths, knee angle, residuals"},
                 {"kinematics.csv", "angles and vectors frame by frame"}},
       .chapter = TrialsChapter,
       .chapter_place = 6,
       .warnings = "Human trial",
       .warnings_place = 7},
      {.name = "exo",
       .program = nullptr,
       .make = ExoStep,
       .needs = {.threads = 2, .memory_mb = 2000, .minutes = 60},
       .outputs = {"kinematics.csv", "events.csv", "summary.json"},
       .files = {{"overlay.mp4", "the exoskeleton trial with skeleton, trails and angle"},
                 {"track.png", "figure of the exoskeleton trial"},
                 {"kinematics.csv", "the same for the exoskeleton trial"}},
       .warnings = "Exoskeleton trial",
       .warnings_place = 8},
      {.name = "comparison",
       .program = "lake-compare",
       .make = ComparisonStep,
       .outputs = {"comparison.json", "misalignment.csv", "summary.json"},
       .files = {{"report.html", "the whole comparison, all figures"},
                 {"misalignment.csv", "its curves, a row per percent"}},
       .chapter = MisalignmentChapter,
       .chapter_place = 5,
       .warnings = "Misalignment",
       .warnings_place = 6},
      {.name = "loads",
       .program = "lake-loads",
       .make = LoadsStep,
       .outputs = {"loads.csv", "momentum.csv", "loads.json", "summary.json"},
       .files = {{"loads.csv", "moments at ankle, knee and hip of each rise"},
                 {"momentum.csv", "the whole body's centre of mass at seat-off, its largest momenta"},
                 {"centre_of_mass.csv", "where it is over each rise, and how it moves"},
                 {"pace.csv", "the same path at other paces: the knee's moment, and whether balance is kept"}},
       .chapter = LoadsChapter,
       .chapter_place = 2,
       .warnings = "Loads",
       .warnings_place = 5},
      {.name = "optimum",
       .program = "lake-optimize",
       .make = OptimumStep,
       .needs = {.minutes = 120},
       .outputs = {"design.yaml", "summary.json"},
       .files = {{"design.yaml", "the optimum of the design problem"}},
       .chapter = OptimumChapter,
       .chapter_place = 7,
       .warnings = "Benchmark optimum",
       .warnings_place = 11},
      {.name = "redesign",
       .program = "lake-redesign",
       .make = RedesignStep,
       .needs = {.minutes = 120},
       .outputs = {"design.yaml", "summary.json"},
       .files = {{"design.yaml", "the re-optimised design"},
                 {"balance.csv", "centre of pressure, knee moment and lean along its program"}},
       .chapter = RedesignChapter,
       .chapter_place = 1,
       .warnings = "New design",
       .warnings_place = 2},
      {.name = "assistance",
       .program = "lake-optimize",
       .make = AssistanceStep,
       .needs = {.minutes = 120},
       .outputs = {"summary.json"},
       .files = {{"design.yaml", "the links for the actuator and the knee moment"},
                 {"assistance.csv", "its force, speed and power over the rise"},
                 {"actuators_front.csv", "each actuator's shortest rise and links"}},
       .warnings = "Assistance",
       .warnings_place = 4},
      {.name = "simulation",
       .program = "lake-simulate",
       .make = SimulationStep,
       .needs = {.minutes = 30},
       .outputs = {"angle_vs_stroke.csv", "summary.json"},
       .files = {{"angle_vs_stroke.csv", "angle, moment arm and force over stroke"},
                 {"animation.mp4", "the linkage moving"},
                 {"design.dxf", "link plates, 1:1 in mm"},
                 {"schematic.svg", "schematic with the symbols"},
                 {"mannequin.png", "the design on the body"}},
       .chapter = SimulationChapter,
       .chapter_place = 3,
       .warnings = "Fit on the body",
       .warnings_place = 1},
      {.name = "stroke",
       .program = "lake-stroke",
       .make = StrokeStep,
       .outputs = {"program.csv", "summary.json"},
       .files = {{"program.csv", "the stroke program"}},
       .chapter = StrokeChapter,
       .chapter_place = 4,
       .warnings = "Stroke program",
       .warnings_place = 3},
  };
  return kInOrder;
}

// Of all steps: it comes last, into the study's own folder.
inline constexpr const char* kReportStep = "report";

namespace fs = std::filesystem;

using namespace report;

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

Section MethodsChapter(const StudyResults& results) {
  const char* percent =
      RepetitionIn(results) == "rise"
          ? "Sit-to-stand: 0 % where hip or trunk leaves rest, 100 % where the knee's extension speed falls below "
            "5 % of its peak. Repetitions are averaged at each percent."
          : "Walking: 0 % at heel strike, 100 % at the next one of the same leg, by heel and toe or the ankle against "
            "the hip. Strides are averaged at each percent.";
  return {
      "Methods",
      // NOLINTNEXTLINE(bugprone-suspicious-missing-comma): sentences over several lines
      {List{{"Markers: the centre of each from a model of its blob, with its own standard deviation from the "
             "recording's noise. Smoothers, whose stiffness and noise are learnt from the recording, give segment "
             "angles and lengths; the knee angle is that of the vectors ankle–knee and knee–hip, 0° straight.",
             percent,
             "Path difference: the distance between the exoskeleton's and the human's knee at the same percent, over "
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
  if (const Json only = head.at("options").value("only", Json("")); only.is_string() && only.get<std::string>().empty())
    files.files.push_back({"summary.json", "every number of every step"});
  return {"Output files", {std::move(files)}};
}

// Of the steps' folders; a step that the study has not is left out. `head` is what Run::Head() says.
Report MakeStudyReport(const StudyFile& study, const StudyResults& results, const Json& head) {
  Report report{study.name, "From two recordings to a better knee exoskeleton", WarningsOf(results), {}};
  report.sections.push_back(ResultChapter(study, results));
  if (results.Has("redesign")) report.sections.push_back(DetailsChapter(study, results));
  for (const StepKind* kind : InOrder(results, &StepKind::chapter_place))
    report.sections.push_back(kind->chapter(study, results));
  report.sections.push_back(MethodsChapter(results));
  report.sections.push_back(FilesChapter(study, results, head));
  report.sections.push_back(ProvenanceSection(head));
  constexpr std::size_t kOpen = 2;  // result, and why
  for (std::size_t i = kOpen; i < report.sections.size(); ++i) report.sections[i].folded = true;
  return report;
}

constexpr const char* kSummary = "summary.json";
constexpr const char* kReportPage = "report.html";

steps::StudyStep ReportStep(const StudyFile& study, const fs::path& out, const Json& head,
                            const std::vector<steps::StudyStep>& before) {
  // A list of results of its own, as the study's summary beside it is another run's.
  steps::StudyStep step{.name = kReportStep,
                        .what = "the report",
                        .program = "lake-run-report",
                        .folder = out,
                        .inputs = {study.file},
                        .options = {{"name", study.name}}};
  for (const steps::StudyStep& earlier : before) step.whole_steps.push_back(earlier.name);
  step.work = [study, out, head, steps = step.whole_steps](Run& run) {
    report::WriteReport(run.Result(kReportPage), MakeStudyReport(study, {out, steps}, head));
  };
  return step;
}

// What steps left that the study does not have any more: their chapters and firmware are of another design.
void RetireOtherSteps(const std::vector<steps::StudyStep>& steps, const fs::path& out) {
  for (const std::string& name : StudyStepNames())
    if (std::none_of(steps.begin(), steps.end(), [&](const steps::StudyStep& step) { return step.name == name; }))
      steps::RetireStudyStep(out / name, name);
}

// A step's results are replaced, so nothing that the study reads may lie there.
void CheckInputsLieOutside(const StudyFile& study, const fs::path& out) {
  for (const StudyInput& input : study.inputs)
    for (const std::string& name : StudyStepNames())
      if (LiesIn(input.path, out / name))
        throw Fail(
            "{}: {} lies among the study's own results, which are made anew; copy it elsewhere and name the copy",
            input.where, input.path.string());
}

steps::StepRunOptions StepOptions(const StudyFile& study, const Run& run) {
  return {
      .command = run.Head()["command"], .quiet = run.Quiet(), .subject = {fs::weakly_canonical(study.file).string()}};
}

fs::path Absolute(const fs::path& path) {
  return fs::absolute(path).lexically_normal();
}

// The report's row stands for itself.
const StepKind& KindOf(const std::string& step) {
  static const StepKind kReport{.name = kReportStep, .program = nullptr, .make = nullptr, .outputs = {kReportPage}};
  for (const StepKind& kind : StepKinds())
    if (step == kind.name) return kind;
  return kReport;
}

Json CostJson(const steps::StepCost& cost) {
  return {{"seconds", std::round(10 * cost.seconds) / 10}, {"memory_mb", std::round(cost.memory_mb)}};
}

PlannedStep PlanOf(const steps::StudyStep& step, const std::vector<std::string>& before, const std::string& why) {
  const StepKind& kind = KindOf(step.name);
  PlannedStep plan{.name = step.name,
                   .what = step.what,
                   .program = step.program,
                   .folder = Absolute(step.folder),
                   .after = before,
                   .inputs = {},
                   .outputs = {},
                   .due = why.empty() ? std::nullopt : std::optional(why),
                   .failed = steps::StepFailure(step),
                   .needs = kind.needs,
                   .last_run = steps::LastCost(step)};
  for (const fs::path& input : step.inputs) plan.inputs.push_back(Absolute(input));
  for (const char* output : kind.outputs) plan.outputs.push_back(Absolute(step.folder / output));
  return plan;
}

std::vector<std::string> Texts(const std::vector<fs::path>& paths) {
  return {paths.begin(), paths.end()};
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

std::vector<std::string> StudyStepNames() {
  std::vector<std::string> names;
  for (const StepKind& kind : StepKinds()) names.push_back(kind.name);
  return names;
}

std::vector<steps::StudyStep> StudySteps(const StudyFile& study, const fs::path& out, const Json& head) {
  std::vector<steps::StudyStep> steps;
  for (const StepKind& kind : StepKinds()) {
    OptionalStep step = kind.make(study, out);
    if (!step) continue;
    step->name = kind.name;
    step->folder = out / kind.name;
    if (kind.program) step->program = kind.program;
    steps.push_back(std::move(*step));
  }
  steps.push_back(ReportStep(study, out, head, steps));
  return steps;
}

void RunStudySteps(const StudyFile& study, const std::vector<std::string>& names, bool keep_going, const Run& run) {
  CheckInputsLieOutside(study, run.Folder());
  steps::StepRunOptions options = StepOptions(study, run);
  options.only = names;
  options.keep_going = keep_going;
  steps::RunSteps(StudySteps(study, run.Folder(), run.Head()), options);
}

Json RunStudyFile(const StudyFile& study, Run& run, bool keep_going) {
  CheckInputsLieOutside(study, run.Folder());
  if (!keep_going) CheckFiles(study);
  run.AddInput(study.file, "study");
  for (const StudyInput& input : study.inputs) run.AddInput(input.path, "input");
  const std::vector<steps::StudyStep> steps = StudySteps(study, run.Folder(), run.Head());
  run.Begin({kSummary});
  steps::StepRunOptions options = StepOptions(study, run);
  options.keep_going = keep_going;
  const std::vector<steps::StepOutcome> outcomes = steps::RunSteps(steps, options);
  RetireOtherSteps(steps, run.Folder());
  run.Report(StudyText(outcomes));
  if (fs::is_regular_file(run.Folder() / kReportPage)) {
    std::vector<std::string> names;
    for (const steps::StudyStep& step : steps) names.push_back(step.name);
    run.Report("{}report: {}\n", ResultText(study, {run.Folder(), names}), (run.Folder() / kReportPage).string());
  }

  Json summary = {{"name", study.name}, {"warnings", Json::array()}, {"steps", Json::array()}};
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const steps::StepOutcome& outcome = outcomes[i];
    summary["steps"].push_back({{"name", outcome.name},
                                {"folder", steps[i].folder.lexically_relative(run.Folder()).string()},
                                {"done", outcome.done},
                                {"why", outcome.why},
                                {"seconds", outcome.seconds}});
    const fs::path file = steps[i].folder / kSummary;
    if (steps[i].folder == run.Folder() || !fs::is_regular_file(file)) continue;
    summary[outcome.name] = ReadJsonFile(file);
    for (const Json& warning : summary[outcome.name]["warnings"])
      summary["warnings"].push_back(fmt::format("{}: {}", outcome.name, warning.get<std::string>()));
  }
  return summary;
}

StudyPlan PlanStudy(const StudyFile& study, const fs::path& out, const std::string& made_by) {
  const std::vector<steps::StudyStep> steps = StudySteps(study, out, Json::object());
  const std::vector<std::string> reasons = steps::WhyDoSteps(steps, made_by);
  StudyPlan plan{.name = study.name, .study = Absolute(study.file), .out = Absolute(out), .steps = {}};
  plan.steps.reserve(steps.size());
  for (std::size_t i = 0; i < steps.size(); ++i)
    plan.steps.push_back(PlanOf(steps[i], steps::StepsBefore(steps, steps[i]), reasons[i]));
  return plan;
}

Json PlanJson(const StudyPlan& plan) {
  Json json = {
      {"name", plan.name}, {"study", plan.study.string()}, {"out", plan.out.string()}, {"steps", Json::array()}};
  for (const PlannedStep& step : plan.steps)
    json["steps"].push_back(
        {{"name", step.name},
         {"what", step.what},
         {"program", step.program},
         {"folder", step.folder.string()},
         {"after", step.after},
         {"inputs", Texts(step.inputs)},
         {"outputs", Texts(step.outputs)},
         {"due", ValueOrNull(step.due)},
         {"failed", ValueOrNull(step.failed)},
         {"last_run", step.last_run ? CostJson(*step.last_run) : Json()},
         {"resources",
          {{"threads", step.needs.threads}, {"memory_mb", step.needs.memory_mb}, {"minutes", step.needs.minutes}}}});
  return json;
}

std::string StudyText(const std::vector<steps::StepOutcome>& outcomes) {
  std::string text;
  for (const steps::StepOutcome& step : outcomes)
    text += fmt::format("{:<12} {:6.1f} s  {}\n", step.name, step.seconds, step.done ? "done" : "unchanged");
  return text;
}

}  // namespace lake::study
