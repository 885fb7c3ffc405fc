#include "step_work.h"

#include <cmath>
#include <utility>

#include "knees_picture.h"
#include "lake/core/json_or_null.h"
#include "lake/core/options_json.h"
#include "lake/motion/leg_motion.h"
#include "step_costs.h"

namespace lake::study {
namespace {

namespace fs = std::filesystem;

// What the study says of these options.
void Tell(const OptionList& list, const Json& given, steps::StudyStep& step) {
  step.summary_options.update(OptionsJson(list));
  step.summary_options.update(given);
  for (const auto& [name, value] : given.items()) step.given.push_back(name);
  for (steps::StudyKey& key : steps::KeysOf(list)) step.keys.push_back(std::move(key));
}

void AddInputs(const std::vector<InputFile>& inputs, steps::StudyStep& step) {
  for (const InputFile& input : inputs) step.inputs.push_back(input.path);
}

// One command with these options.
template <typename Options>
steps::StudyStep StepOf(Options options, Json (*command)(const Options&, Run&), const StudySection& section,
                        const steps::StepCost& expected) {
  steps::StudyStep step{.options = section.text, .expected = expected};
  AddInputs(InputsOf(options), step);
  Tell(OptionsOf(options), section.given, step);
  step.work = [options = std::move(options), command](Run& run) { run.WriteSummary(command(options, run)); };
  return step;
}

template <typename Options>
steps::StudyStep StepOf(const Options& options, Json (*command)(const Options&, Run&), const StudySection& section) {
  return StepOf(options, command, section, CostOf(options));
}

// The camera file that the videos are tracked with.
std::optional<fs::path> CameraOf(const StudyFile& study, const fs::path& out) {
  if (!study.calibration) return study.camera;
  return out / (study.calibration->plane ? "plane" : "calibration") / "camera.yaml";
}

steps::StudyStep TrialStep(const StudyTrial& trial, const std::string& what, const std::optional<fs::path>& camera) {
  steps::StudyStep step;
  if (trial.IsVideo()) {
    commands::TrackRunOptions options = std::get<commands::TrackRunOptions>(trial.work);
    if (!options.camera) options.camera = camera;
    step = StepOf(options, commands::RunTrack, trial.section);
    step.program = "lake-track";
  } else {
    step = StepOf(std::get<commands::GaitRunOptions>(trial.work), commands::RunGait, trial.section);
    step.program = "lake-gait";
  }
  step.what = fmt::format("{}, {}", what, trial.Recording().filename().string());
  return step;
}

// What is known of an actuator: the study only names it, and its catalogue may change.
Json ActuatorJson(const problem::LinearActuator& actuator) {
  Json json = Json::array();
  for (const auto& number : {actuator.closed_mm, actuator.stroke_mm, actuator.max_force_n, actuator.no_load_speed_mm_s,
                             actuator.holding_force_n, actuator.mass_g, actuator.duty_cycle_percent})
    json.push_back(ValueOrNull(number));
  for (const problem::LinearActuator::ForceSpeed& point : actuator.force_speed)
    json.push_back({point.force_n, point.speed_mm_s});
  return json;
}

// The leg that was measured, if the trial knows millimetres.
std::optional<linkage::LegLengths> LegOf(const fs::path& kinematics) {
  const motion::LegMotion motion = motion::ReadKinematicsCsv(kinematics);
  const double thigh = motion::MedianLength(motion, &motion::LegSample::kh);
  const double shank = motion::MedianLength(motion, &motion::LegSample::ak);
  if (motion.unit != motion::LengthUnit::kMm || std::isnan(thigh + shank)) return std::nullopt;
  return linkage::LegLengths{thigh, shank};
}

// Body size for clearances, where the problem does not say: as the design is checked. Leg lengths come from the fit.
linkage::BodySize BodyOf(const StudyFile& study, linkage::BodySize body) {
  const commands::SimulationOptions& simulation = study.simulation;
  if (!body.mass_kg) body.mass_kg = simulation.body_mass_kg;
  if (!body.height_mm) body.height_mm = simulation.body_height_mm;
  if (!study.loads) return body;
  if (!body.mass_kg) body.mass_kg = study.loads->loads.body.mass_kg;
  if (!body.height_mm) body.height_mm = study.loads->loads.body.height_mm;
  return body;
}

// A step of lake-optimize. Clearances are on the body of the person, with the parts that are simulated. `profile` is
// read once it has been found.
steps::StudyStep DesignStep(const StudyFile& study, const fs::path& out, commands::OptimizeRunOptions options,
                            StudySection section, const std::optional<fs::path>& profile = std::nullopt) {
  problem::SynthesisProblem& problem = options.problem;
  problem::Clearances& clearances = problem.clearances;
  if (problem.actuator) section.text["known of the actuator"] = ActuatorJson(*problem.actuator);
  if (!study.simulation_section.text.empty()) problem.parts = study.simulation.parts;
  const fs::path leg = out / "human" / "kinematics.csv";
  const bool needs_leg = clearances.AreAsked() && !clearances.body.leg;
  if (clearances.AreAsked()) {
    clearances.body = BodyOf(study, clearances.body);
    if (clearances.seat_edge_mm == 0) clearances.seat_edge_mm = study.simulation.seat_edge_mm;
    section.text["body"] = {{"mass_kg", clearances.body.mass_kg.value_or(0)},
                            {"height_mm", clearances.body.height_mm.value_or(0)},
                            {"seat_edge_mm", clearances.seat_edge_mm},
                            {"parts", study.simulation_section.text}};
  }
  steps::StudyStep step = StepOf(options, commands::RunOptimize, section);
  for (const char* key : {"problem", "clearances"})
    if (const auto map = section.text.find(key); map != section.text.end() && map->is_object())
      step.summary_options[key] = *map;
  if (profile) step.inputs.push_back(*profile);
  if (needs_leg) step.inputs.push_back(leg);
  step.work = [options = std::move(options), profile, needs_leg, leg](Run& run) {
    commands::OptimizeRunOptions work = options;
    if (profile) work.problem.profile = problem::ReadLoadProfile(*profile);
    if (needs_leg) work.problem.clearances.body.leg = LegOf(leg);
    work.study.quiet = work.study.optimize.quiet = run.Quiet();
    run.WriteSummary(commands::RunOptimize(work, run));
  };
  return step;
}

commands::OptimizeRunOptions OptionsFor(const StudyProblem& problem, const synthesis::SynthesisOptions& search) {
  commands::OptimizeRunOptions options;
  options.problem = problem.problem;
  if (problem.file) options.problem_file = *problem.file;
  options.study = search;
  return options;
}

fs::path DesignOf(const StudyFile& study, const fs::path& out) {
  return out / (study.redesign ? "redesign" : "optimum") / "design.yaml";
}

fs::path ProfileIn(const fs::path& out) {
  return out / "loads" / "loads.json";
}

// The design that is simulated with the same actuator and share.
void TakeLoadOf(const fs::path& profile, const problem::SynthesisProblem& problem,
                commands::SimulationOptions& options) {
  options.load.profile = problem::ReadLoadProfile(profile);
  options.load.assist = problem.assist;
  options.load.actuator = problem.actuator;
  options.load.rests_anywhere = problem.rests_anywhere;
  options.load.duration_s = problem.duration_s;
}

}  // namespace

OptionalStep CalibrationStep(const StudyFile& study, const fs::path&) {
  if (!study.calibration) return std::nullopt;
  steps::StudyStep step = StepOf(study.calibration->camera, commands::RunCalibrate, study.calibration->camera_section);
  step.what = "the camera";
  return step;
}

OptionalStep PlaneStep(const StudyFile& study, const fs::path& out) {
  if (!study.calibration || !study.calibration->plane) return std::nullopt;
  commands::PlaneRunOptions options = *study.calibration->plane;
  options.camera = out / "calibration" / "camera.yaml";
  steps::StudyStep step = StepOf(options, commands::RunPlane, study.calibration->plane_section);
  step.what = "the sagittal plane";
  return step;
}

OptionalStep HumanStep(const StudyFile& study, const fs::path& out) {
  return TrialStep(study.human, "the trial without exoskeleton", CameraOf(study, out));
}

OptionalStep ExoStep(const StudyFile& study, const fs::path& out) {
  if (!study.exo) return std::nullopt;
  return TrialStep(*study.exo, "the trial with exoskeleton", CameraOf(study, out));
}

// What was worn, on the body and with the parts that a design of the study is checked with.
void TakeWorn(const StudyFile& study, StudySection& section, commands::CompareRunOptions& options) {
  if (!study.worn) return;
  options.worn = study.worn;
  options.body = BodyOf(study, {});
  options.wear = {.bar_width_mm = study.simulation.parts.bar_width_mm,
                  .actuator_diameter_mm = study.simulation.parts.actuator_diameter_mm,
                  .seat_edge_mm = study.simulation.seat_edge_mm};
  section.given["worn"] = study.worn->string();
  section.text["body"] = {{"mass_kg", options.body.mass_kg.value_or(0)},
                          {"height_mm", options.body.height_mm.value_or(0)},
                          {"seat_edge_mm", options.wear.seat_edge_mm},
                          {"bar_width_mm", options.wear.bar_width_mm},
                          {"actuator_diameter_mm", options.wear.actuator_diameter_mm}};
}

OptionalStep ComparisonStep(const StudyFile& study, const fs::path& out) {
  if (!study.exo) return std::nullopt;
  commands::CompareRunOptions options = study.compare;
  options.human = out / "human";
  options.exo = out / "exo";
  StudySection section = study.compare_section;
  TakeWorn(study, section, options);
  steps::StudyStep step = StepOf(options, commands::RunCompare, section);
  step.what = "the misalignment of exo against human";
  if (study.exo->IsVideo()) step.inputs.push_back(study.exo->Recording());
  step.work = [options, trial = *study.exo](Run& run) {
    const Json comparison = commands::RunCompare(options, run);
    if (options.IsMarkerOnAxis()) DrawKneesOf(trial, options.exo, comparison.at("markers").at("exo"), run);
    run.WriteSummary(comparison);
  };
  return step;
}

OptionalStep LoadsStep(const StudyFile& study, const fs::path& out) {
  if (!study.loads) return std::nullopt;
  commands::LoadsRunOptions options = *study.loads;
  options.trial = out / "human";
  steps::StudyStep step = StepOf(options, commands::RunLoads, study.loads_section, CostOfLoads(study.human));
  step.what = "what the knee needs";
  return step;
}

OptionalStep OptimumStep(const StudyFile& study, const fs::path& out) {
  StudySection section = study.design_section;
  section.text.erase("worn");
  if (study.design.file) section.given["problem"] = study.design.file->string();
  steps::StudyStep step = DesignStep(study, out, OptionsFor(study.design, study.optimum), std::move(section));
  step.what = "the largest range of rotation";
  return step;
}

// What the redesign does not say of its cuffs is as in the comparison.
void TakeCuffs(const StudyFile& study, StudySection& section, commands::ReoptimizeRunOptions& reoptimize) {
  const auto take = [&](const char* name, auto cuffs::CuffOptions::*value) {
    const auto given = study.compare_section.given.find(name);
    if (section.given.contains(name) || given == study.compare_section.given.end()) return;
    reoptimize.cuffs.*value = study.compare.cuff.*value;
    section.given[name] = section.text[name] = *given;
  };
  take("thigh-cuff", &cuffs::CuffOptions::thigh);
  take("shank-cuff", &cuffs::CuffOptions::shank);
  take("cuff-softest", &cuffs::CuffOptions::softest_n_mm);
  take("cuff-stiffest", &cuffs::CuffOptions::stiffest_n_mm);
}

OptionalStep RedesignStep(const StudyFile& study, const fs::path& out) {
  if (!study.redesign) return std::nullopt;
  commands::OptimizeRunOptions options = OptionsFor(study.redesign->design, study.redesign->search);
  commands::ReoptimizeRunOptions& reoptimize = options.reoptimize.emplace(study.redesign->options);
  if (study.exo) {
    reoptimize.comparisons = {out / "comparison"};
  } else {
    reoptimize.human = out / "human";
    reoptimize.human_knee = study.compare.human_knee;
  }
  if (study.worn) reoptimize.worn = {*study.worn};
  if (study.loads) reoptimize.body = ProfileIn(out);
  StudySection section = study.redesign->section;
  section.text["human_knee"] = study.compare.human_knee;
  for (const char* key : {"problem", "clearances"})  // where it says none, those of the study's own design hold
    if (!section.text.contains(key) && study.design_section.text.contains(key))
      section.text[key] = study.design_section.text[key];
  section.given["human-knee"] = study.compare.human_knee;
  TakeCuffs(study, section, reoptimize);
  if (study.redesign->design.file) section.given["problem"] = study.redesign->design.file->string();
  steps::StudyStep step = DesignStep(study, out, std::move(options), std::move(section));
  step.what = "the design for this person";
  return step;
}

OptionalStep AssistanceStep(const StudyFile& study, const fs::path& out) {
  if (!study.assistance) return std::nullopt;
  StudySection section = study.assistance->section;
  if (const fs::path& file = study.assistance->options.problem_file; !file.empty())
    section.given["problem"] = file.string();
  steps::StudyStep step = DesignStep(study, out, study.assistance->options, std::move(section), ProfileIn(out));
  step.what = "what an actuator gives of it";
  return step;
}

OptionalStep SimulationStep(const StudyFile& study, const fs::path& out) {
  commands::SimulationOptions options = study.simulation;
  steps::StudyStep step{
      .what = "the design's poses", .options = study.simulation_section.text, .expected = CostOf(options), .keys = {}};
  const fs::path design = DesignOf(study, out), leg = out / "human" / "kinematics.csv";
  const std::vector<InputFile> own = {{design, "design"}, {leg, "leg"}};
  AddInputs(own, step);
  AddInputs(InputsOf(options), step);
  // What the knee needs, where the study has one actuator to give it.
  const bool is_assisted = study.assistance && study.assistance->options.actuators.empty();
  if (is_assisted) {
    const commands::OptimizeRunOptions& assistance = study.assistance->options;
    step.options["assistance"] = study.assistance->section.text;
    if (assistance.problem.actuator) step.options["known of the actuator"] = ActuatorJson(*assistance.problem.actuator);
    AddInputs(InputsOf(assistance), step);
    step.inputs.push_back(ProfileIn(out));
  }
  if (study.loads) {
    // Stature and mass are those that the loads are of, where `simulate` says no others.
    const loads::BodyOptions& body = study.loads->loads.body;
    if (!options.body_mass_kg) options.body_mass_kg = body.mass_kg;
    if (!options.body_height_mm) options.body_height_mm = body.height_mm;
    step.options["body"] = {{"mass_kg", options.body_mass_kg.value_or(0)},
                            {"height_mm", options.body_height_mm.value_or(0)}};
  }
  Tell(OptionsOf(options), study.simulation_section.given, step);
  step.work = [options, is_assisted, assistance = study.assistance, profile = ProfileIn(out), own, design,
               leg](Run& run) {
    run.AddInputs(own);
    commands::SimulationOptions of_person = options;
    if (const auto measured = LegOf(leg)) {
      of_person.thigh_mm = measured->thigh_mm;
      of_person.shank_mm = measured->shank_mm;
    }
    if (is_assisted) TakeLoadOf(profile, assistance->options.problem, of_person);
    run.WriteSummary(commands::SimulateLinkage(linkage::ReadDesign(design), of_person, run));
  };
  return step;
}

OptionalStep StrokeStep(const StudyFile& study, const fs::path& out) {
  if (!study.stroke) return std::nullopt;
  commands::StrokeRunOptions options = *study.stroke;
  options.design = DesignOf(study, out);
  if (!study.redesign && !options.schedule.speed_mm_s)
    options.schedule.speed_mm_s = linkage::StrokeProgram{}.speed_mm_s;
  // A constant program takes its ends from the person; a free one has its own.
  const auto has_own_ends = [](const redesign::ProgramLimits& program) {
    return program.kind == linkage::StrokeProgram::Kind::kFree || program.free_ends;
  };
  const bool is_free = study.redesign && has_own_ends(study.redesign->options.program);
  if (!is_free || options.schedule.speed_mm_s) options.motion = out / "human";
  steps::StudyStep step = StepOf(options, commands::RunStroke, study.stroke_section);
  step.what = "the actuator's program";
  return step;
}

}  // namespace lake::study
