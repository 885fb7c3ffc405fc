#include "lake/study/study.h"

#include <algorithm>
#include <cmath>

#include "lake/core/error.h"
#include "lake/core/paths.h"
#include "lake/motion/leg_motion.h"
#include "lake/video/video_files.h"
#include "study_report.h"

namespace lake::study {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSummary = "summary.json";

template <typename Options>
std::vector<steps::StudyKey> KeysOf(Options options) {
  return steps::KeysOf(OptionsOf(options));
}

// What a comparison or an optimisation reads of a trial.
std::vector<fs::path> TrialTables(const fs::path& folder) {
  return {folder / "kinematics.csv", folder / "events.csv", folder / "trajectory.csv", folder / "tracks.csv"};
}

steps::StudyStep CalibrationStep(const StudyCalibration& calibration, const fs::path& folder) {
  steps::StudyStep step{
      "calibration", "the camera", "lake-calibrate", folder, {}, {}, calibration.camera_options, 30, {}};
  step.inputs = calibration.camera.pictures, step.keys = KeysOf(calibration.camera);
  step.work = [options = calibration.camera](Run& run) { run.WriteSummary(commands::RunCalibrate(options, run)); };
  return step;
}

steps::StudyStep PlaneStep(const StudyCalibration& calibration, const fs::path& camera, const fs::path& folder) {
  commands::PlaneRunOptions options = *calibration.plane;
  options.camera = camera;
  steps::StudyStep step{"plane", "the sagittal plane", "lake-calibrate", folder, {}, {}, calibration.plane_options, 2,
                        {}};
  step.inputs = {options.picture, options.camera}, step.keys = KeysOf(options);
  step.work = [options](Run& run) { run.WriteSummary(commands::RunPlane(options, run)); };
  return step;
}

// The calibration's steps, and the camera file that the videos are tracked with.
std::optional<fs::path> AddCamera(const StudyFile& study, const fs::path& out, std::vector<steps::StudyStep>& steps) {
  if (!study.calibration) return study.camera;
  steps.push_back(CalibrationStep(*study.calibration, out / "calibration"));
  fs::path camera = out / "calibration" / "camera.yaml";
  if (!study.calibration->plane) return camera;
  steps.push_back(PlaneStep(*study.calibration, camera, out / "plane"));
  return out / "plane" / "camera.yaml";
}

steps::StudyStep TrackStep(commands::TrackRunOptions options, const std::optional<fs::path>& camera) {
  if (!options.camera) options.camera = camera;
  steps::StudyStep step;
  step.program = "lake-track", step.expected_s = 20, step.keys = KeysOf(options);
  step.inputs = {video::FilesOfVideo(options.video)};
  if (options.camera) step.inputs.push_back(*options.camera);
  for (const auto& file : {options.corrections, options.events})
    if (file) step.inputs.push_back(*file);
  step.work = [options](Run& run) { run.WriteSummary(commands::RunTrack(options, run)); };
  return step;
}

steps::StudyStep GaitStep(const commands::GaitRunOptions& options) {
  steps::StudyStep step;
  step.program = "lake-gait", step.expected_s = 3, step.keys = KeysOf(options);
  step.inputs = {options.trial};
  if (options.camera) step.inputs.push_back(*options.camera);
  if (options.events) step.inputs.push_back(*options.events);
  step.work = [options](Run& run) { run.WriteSummary(commands::RunGait(options, run)); };
  return step;
}

steps::StudyStep TrialStep(const std::string& name, const std::string& what, const StudyTrial& trial,
                           const std::optional<fs::path>& camera, const fs::path& out) {
  const auto* video = std::get_if<commands::TrackRunOptions>(&trial.work);
  steps::StudyStep step = video ? TrackStep(*video, camera) : GaitStep(std::get<commands::GaitRunOptions>(trial.work));
  step.name = name, step.folder = out / name;
  step.what = fmt::format("{}, {}", what, trial.Recording().filename().string());
  step.options = trial.options;
  return step;
}

steps::StudyStep ComparisonStep(const StudyFile& study, const fs::path& out) {
  commands::CompareRunOptions options = study.compare;
  options.human = out / "human", options.exo = out / "exo";
  steps::StudyStep step{"comparison",
                        "the misalignment of exo against human",
                        "lake-compare",
                        out / "comparison",
                        {},
                        {},
                        study.compare_options,
                        4,
                        {}};
  step.keys = KeysOf(options);
  for (const fs::path& folder : {options.human, options.exo})
    for (const fs::path& table : TrialTables(folder)) step.inputs.push_back(table);
  step.work = [options](Run& run) { run.WriteSummary(commands::RunCompare(options, run)); };
  return step;
}

// What is known of an actuator: the study only names it, and its catalogue may change.
Json ActuatorJson(const problem::LinearActuator& actuator) {
  Json json = Json::array();
  for (const auto& number : {actuator.closed_mm, actuator.stroke_mm, actuator.max_force_n, actuator.no_load_speed_mm_s,
                             actuator.holding_force_n, actuator.mass_g, actuator.duty_cycle_percent})
    json.push_back(number ? Json(*number) : Json());
  for (const problem::LinearActuator::ForceSpeed& point : actuator.force_speed)
    json.push_back({point.force_n, point.speed_mm_s});
  return json;
}

// All that a design is made of, but for what is known of the person.
void AddProblemOf(const commands::OptimizeRunOptions& options, steps::StudyStep& step) {
  for (const fs::path& file : {options.problem_file, options.actuators})
    if (!file.empty()) step.inputs.push_back(file);
  if (options.problem.profile) step.inputs.push_back(options.problem.profile->file);
  if (options.problem.actuator && !options.problem.actuator->file.empty())
    step.inputs.push_back(options.problem.actuator->file);
  if (options.problem.actuator) step.options["known of the actuator"] = ActuatorJson(*options.problem.actuator);
}

void AddProblem(const StudyProblem& problem, commands::OptimizeRunOptions& options, steps::StudyStep& step) {
  options.problem = problem.problem;
  if (problem.file) options.problem_file = *problem.file;
  AddProblemOf(options, step);
}

// The leg that was measured, if the trial knows millimetres.
std::optional<linkage::LegLengths> LegOf(const fs::path& kinematics) {
  const motion::LegMotion motion = motion::ReadKinematicsCsv(kinematics);
  const double thigh = motion::MedianLength(motion, &motion::LegSample::kh),
               shank = motion::MedianLength(motion, &motion::LegSample::ak);
  if (motion.unit != motion::LengthUnit::kMm || std::isnan(thigh + shank)) return std::nullopt;
  return linkage::LegLengths{thigh, shank};
}

// The person that clearances are of, but for the leg, where the problem does not say: as the design is checked.
linkage::BodySize BodyOf(const StudyFile& study, linkage::BodySize body) {
  const commands::SimulationOptions& simulation = study.simulation;
  if (!body.mass_kg) body.mass_kg = simulation.body_mass_kg;
  if (!body.height_mm) body.height_mm = simulation.body_height_mm;
  if (!study.loads) return body;
  if (!body.mass_kg) body.mass_kg = study.loads->loads.body.mass_kg;
  if (!body.height_mm) body.height_mm = study.loads->loads.body.height_mm;
  return body;
}

// Clearances are on the body of the person, with the parts that are simulated.
void AddBody(const StudyFile& study, const fs::path& out, commands::OptimizeRunOptions& options,
             steps::StudyStep& step) {
  problem::SynthesisProblem& problem = options.problem;
  if (!study.simulation_options.empty()) problem.parts = study.simulation.parts;
  problem::Clearances& clearances = problem.clearances;
  if (!clearances.AreAsked()) return;
  clearances.body = BodyOf(study, clearances.body);
  if (clearances.seat_edge_mm == 0) clearances.seat_edge_mm = study.simulation.seat_edge_mm;
  step.options["body"] = {{"mass_kg", clearances.body.mass_kg.value_or(0)},
                          {"height_mm", clearances.body.height_mm.value_or(0)},
                          {"seat_edge_mm", clearances.seat_edge_mm},
                          {"parts", study.simulation_options}};
  const fs::path leg = out / "human" / "kinematics.csv";
  if (!clearances.body.leg && std::ranges::find(step.inputs, leg) == step.inputs.end()) step.inputs.push_back(leg);
}

std::function<void(Run&)> OptimizeWork(const commands::OptimizeRunOptions& options, const fs::path& out) {
  return [options, leg = out / "human" / "kinematics.csv"](Run& run) {
    commands::OptimizeRunOptions work = options;
    problem::Clearances& clearances = work.problem.clearances;
    if (clearances.AreAsked() && !clearances.body.leg) clearances.body.leg = LegOf(leg);
    work.study.quiet = work.study.optimize.quiet = run.Quiet();
    run.WriteSummary(commands::RunOptimize(work, run));
  };
}

steps::StudyStep OptimumStep(const StudyFile& study, const fs::path& out) {
  steps::StudyStep step{
      "optimum", "the largest range of rotation", "lake-optimize", out / "optimum", {}, {}, study.design_options, 15,
      {}};
  step.options.erase("worn");
  commands::OptimizeRunOptions options;
  AddProblem(study.design, options, step);
  options.study = study.optimum;
  AddBody(study, out, options, step);
  step.work = OptimizeWork(options, out);
  step.is_nobodys = !options.problem.clearances.AreAsked();
  return step;
}

steps::StudyStep RedesignStep(const StudyFile& study, const fs::path& out) {
  steps::StudyStep step{"redesign", "the design for this person", "lake-optimize", out / "redesign", {}, {}, {}, 20,
                        {}};
  step.options = {{"reoptimize", study.redesign->said},
                  {"problem", study.design_options.value("problem", Json())},
                  {"human_knee", study.compare.human_knee}};
  commands::OptimizeRunOptions options;
  AddProblem(study.redesign->design, options, step);
  options.study = study.redesign->search;
  options.reoptimize = study.redesign->options;
  if (study.exo) {
    options.reoptimize->comparisons = {out / "comparison"};
    step.inputs.push_back(out / "comparison" / "comparison.json");
  } else {
    options.reoptimize->human = out / "human";
    options.reoptimize->human_knee = study.compare.human_knee;
    for (const fs::path& table : TrialTables(out / "human")) step.inputs.push_back(table);
  }
  if (study.worn) options.reoptimize->worn = {*study.worn}, step.inputs.push_back(*study.worn);
  AddBody(study, out, options, step);
  step.work = OptimizeWork(options, out);
  return step;
}

steps::StudyStep LoadsStep(const StudyFile& study, const fs::path& out) {
  commands::LoadsRunOptions options = *study.loads;
  options.trial = out / "human";
  steps::StudyStep step{"loads",
                        "what the knee needs",
                        "lake-loads",
                        out / "loads",
                        TrialTables(out / "human"),
                        {},
                        study.loads_options,
                        2,
                        {}};
  if (!options.forces.empty()) step.inputs.push_back(options.forces);
  step.keys = KeysOf(options);
  step.work = [options](Run& run) { run.WriteSummary(commands::RunLoads(options, run)); };
  return step;
}

steps::StudyStep AssistanceStep(const StudyFile& study, const fs::path& out) {
  commands::OptimizeRunOptions options = study.assistance->options;
  const fs::path profile = out / "loads" / "loads.json";
  steps::StudyStep step{"assistance",
                        "what an actuator gives of it",
                        "lake-optimize",
                        out / "assistance",
                        {profile},
                        {},
                        study.assistance->said,
                        5,
                        {}};
  AddProblemOf(options, step);
  AddBody(study, out, options, step);
  step.work = [options, profile, out](Run& run) {
    commands::OptimizeRunOptions with_profile = options;
    with_profile.problem.profile = problem::ReadLoadProfile(profile);
    OptimizeWork(with_profile, out)(run);
  };
  return step;
}

// Its stature and mass are those that the loads are of, where `simulate` says no others.
void TakeBodyOf(const loads::BodyOptions& body, commands::SimulationOptions& options) {
  if (!options.body_mass_kg) options.body_mass_kg = body.mass_kg;
  if (!options.body_height_mm) options.body_height_mm = body.height_mm;
}

// What the knee needs, where the study has one actuator to give it.
std::optional<fs::path> ProfileOfOneActuator(const StudyFile& study, const fs::path& out) {
  if (!study.assistance || !study.assistance->options.actuators.empty()) return std::nullopt;
  return out / "loads" / "loads.json";
}

// The design that is simulated with the same actuator and share.
void TakeLoadOf(const fs::path& profile, const problem::SynthesisProblem& problem,
                commands::SimulationOptions& options) {
  options.load.profile = problem::ReadLoadProfile(profile);
  options.load.assist = problem.assist, options.load.actuator = problem.actuator;
  options.load.rests_anywhere = problem.rests_anywhere, options.load.duration_s = problem.duration_s;
}

steps::StudyStep SimulationStep(const StudyFile& study, const fs::path& design, const fs::path& out) {
  const fs::path leg = out / "human" / "kinematics.csv";
  steps::StudyStep step{"simulation",
                        "the design's poses",
                        "lake-simulate",
                        out / "simulation",
                        {design, leg},
                        {},
                        study.simulation_options,
                        8,
                        {}};
  const std::optional<fs::path> profile = ProfileOfOneActuator(study, out);
  if (!study.simulation.torques.empty()) step.inputs.push_back(study.simulation.torques);
  if (profile) {
    step.inputs.push_back(*profile), step.options["assistance"] = study.assistance->said;
    AddProblemOf(study.assistance->options, step);
  }
  commands::SimulationOptions options = study.simulation;
  step.keys = KeysOf(options);
  if (study.loads) {
    TakeBodyOf(study.loads->loads.body, options);
    step.options["body"] = {{"mass_kg", options.body_mass_kg.value_or(0)},
                            {"height_mm", options.body_height_mm.value_or(0)}};
  }
  step.work = [options, assistance = study.assistance, profile, design, leg](Run& run) {
    run.AddInput(design);
    run.AddInput(leg);
    commands::SimulationOptions of_person = options;
    if (const auto measured = LegOf(leg))
      of_person.thigh_mm = measured->thigh_mm, of_person.shank_mm = measured->shank_mm;
    if (profile) TakeLoadOf(*profile, assistance->options.problem, of_person);
    run.WriteSummary(commands::SimulateLinkage(linkage::ReadDesign(design), of_person, run));
  };
  return step;
}

steps::StudyStep StrokeStep(const StudyFile& study, const fs::path& design, const fs::path& out) {
  commands::StrokeRunOptions options = *study.stroke;
  options.design = design;
  if (!study.redesign && !options.schedule.speed_mm_s)
    options.schedule.speed_mm_s = linkage::StrokeProgram{}.speed_mm_s;
  // A constant program takes its ends from the person; a free one has its own.
  const bool is_free = study.redesign && study.redesign->options.program.kind == linkage::StrokeProgram::Kind::kFree;
  if (!is_free || options.schedule.speed_mm_s) options.motion = out / "human";
  steps::StudyStep step{
      "stroke", "the actuator's program", "lake-stroke", out / "stroke", {design}, {}, study.stroke_options, 2, {}};
  step.keys = KeysOf(options);
  if (options.duty_table) step.inputs.push_back(*options.duty_table);
  if (options.motion) step.inputs.push_back(*options.motion / "kinematics.csv");
  step.work = [options](Run& run) { run.WriteSummary(commands::RunStroke(options, run)); };
  return step;
}

steps::StudyStep ReportStep(const StudyFile& study, const fs::path& out, const Json& head,
                            const std::vector<steps::StudyStep>& before) {
  // A list of results of its own, as the study's summary beside it is another run's.
  steps::StudyStep step{"report", "the report", "lake-run-report", out, {study.file}, {}, {}, 1, {}};
  step.options = {{"name", study.name}};
  for (const steps::StudyStep& earlier : before) step.whole_steps.push_back(earlier.name);
  step.work = [study, out, head, steps = step.whole_steps](Run& run) {
    report::WriteReport(run.Result("report.html"), MakeStudyReport(study, {out, steps}, head));
  };
  return step;
}

// What steps left that the study does not have any more: their chapters and firmware are of another design.
void RetireOtherSteps(const std::vector<steps::StudyStep>& steps, const fs::path& out) {
  for (const std::string& name : StudyStepNames())
    if (std::none_of(steps.begin(), steps.end(), [&](const steps::StudyStep& step) { return step.name == name; }))
      steps::RetireStudyStep(out / name, name);
}

// A step's folder is emptied before the step begins, so nothing that the study reads may lie there.
void CheckInputsLieOutside(const StudyFile& study, const fs::path& out) {
  for (const StudyInput& input : study.inputs)
    for (const std::string& name : StudyStepNames())
      if (LiesIn(input.path, out / name))
        throw Fail(
            "{}: {} lies among the study's own results, which are made anew; copy it elsewhere and name the copy",
            input.where, input.path.string());
}

steps::StepRunOptions StepOptions(const StudyFile& study, const Run& run) {
  steps::StepRunOptions options;
  options.command = run.Head()["command"], options.quiet = run.Quiet();
  options.subject = {fs::weakly_canonical(study.file).string()};
  return options;
}

}  // namespace

std::vector<steps::StudyStep> StudySteps(const StudyFile& study, const fs::path& out, const Json& head) {
  std::vector<steps::StudyStep> steps;
  const std::optional<fs::path> camera = AddCamera(study, out, steps);
  steps.push_back(TrialStep("human", "the trial without exoskeleton", study.human, camera, out));
  if (study.exo) {
    steps.push_back(TrialStep("exo", "the trial with exoskeleton", *study.exo, camera, out));
    steps.push_back(ComparisonStep(study, out));
  }
  if (study.loads) steps.push_back(LoadsStep(study, out));
  steps.push_back(OptimumStep(study, out));
  if (study.redesign) steps.push_back(RedesignStep(study, out));
  if (study.assistance) steps.push_back(AssistanceStep(study, out));
  const fs::path design = out / (study.redesign ? "redesign" : "optimum") / "design.yaml";
  steps.push_back(SimulationStep(study, design, out));
  if (study.stroke) steps.push_back(StrokeStep(study, design, out));
  steps.push_back(ReportStep(study, out, head, steps));
  return steps;
}

void RunStudyStep(const StudyFile& study, const std::string& step, const Run& run) {
  CheckInputsLieOutside(study, run.Folder());
  steps::RunStep(StudySteps(study, run.Folder(), run.Head()), step, StepOptions(study, run));
}

Json RunStudyFile(const StudyFile& study, Run& run) {
  CheckInputsLieOutside(study, run.Folder());
  run.AddInput(study.file);
  for (const StudyInput& input : study.inputs) run.AddInput(input.path);
  const std::vector<steps::StudyStep> steps = StudySteps(study, run.Folder(), run.Head());
  run.Begin({kSummary});
  RetireOtherSteps(steps, run.Folder());
  const std::vector<steps::StepOutcome> outcomes = steps::RunSteps(steps, StepOptions(study, run));

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

std::string StudyText(const Json& summary) {
  std::string text;
  for (const Json& step : summary["steps"])
    text += fmt::format("{:<12} {:6.1f} s  {}\n", step["name"].get<std::string>(), step["seconds"].get<double>(),
                        step["done"].get<bool>() ? "done" : "unchanged");
  return text;
}

}  // namespace lake::study
