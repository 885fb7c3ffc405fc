#include "step_work.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "lake/core/options_json.h"
#include "lake/core/run.h"
#include "lake/motion/leg_motion.h"
#include "lake/motion/marker_recording.h"
#include "lake/overlay/pictures.h"
#include "lake/problem/problem_file.h"
#include "lake/problem/problem_options.h"
#include "lake/study/study_file.h"
#include "lake/synthesis/synthesis_outcome.h"
#include "lake/tracking/naming.h"
#include "lake/video/image.h"
#include "lake/video/video_reader.h"

namespace lake::study {
namespace {

namespace fs = std::filesystem;

struct Apart {
  std::size_t row = 0;
  double mm = 0;
};

// The row of the median distance, of those that show both.
std::optional<Apart> UsuallyApart(const motion::MarkerTrack& knee, const motion::MarkerTrack& joint) {
  std::vector<std::pair<double, std::size_t>> apart;
  for (std::size_t row = 0; row < knee.samples.size(); ++row) {
    const motion::MarkerSample &a = knee.samples[row], &b = joint.samples[row];
    if (a.status == motion::SampleStatus::kDetected && b.status == motion::SampleStatus::kDetected)
      apart.emplace_back((a.position - b.position).norm(), row);
  }
  if (apart.empty()) return std::nullopt;
  const auto middle = apart.begin() + static_cast<std::ptrdiff_t>(apart.size() / 2);
  std::nth_element(apart.begin(), middle, apart.end());
  return Apart{middle->second, middle->first};
}

// Adds knees.png to the run's results: a frame in which both are apart as they usually are. Nothing where the trial is
// no video, its plane has no mm, or it shows no knee beside the joint. `exo`: the trial's results.
void DrawKneesOf(const StudyTrial& trial, const fs::path& exo, const std::string& joint, Run& run) {
  if (!trial.IsVideo() || joint == "knee" || !fs::is_regular_file(exo / "trajectory.csv")) return;
  const auto& options = std::get<commands::TrackRunOptions>(trial.work);
  const motion::MarkerRecording px = motion::ReadMarkerCsv(exo / "tracks.csv"),
                                mm = motion::ReadMarkerCsv(exo / "trajectory.csv");
  const motion::MarkerTrack *knee = mm.Find("knee"), *worn = mm.Find(joint);
  if (!knee || !worn) return;
  const auto apart = UsuallyApart(*knee, *worn);
  if (!apart) return;
  const auto place = [&](const std::string& name) { return px.Find(name)->samples[apart->row]; };
  overlay::KneesPicture picture{.frame = video::ReadLuma(options.video, px.frame[apart->row], options.track.reader),
                                .knee = place("knee").position,
                                .joint = place(joint).position,
                                .leg = {},
                                .distance = fmt::format("{:.0f} mm", apart->mm)};
  for (const std::string_view name : tracking::kLegMarkers)
    if (const motion::MarkerTrack* marker = px.Find(std::string(name)); marker && marker->samples[apart->row].IsKnown())
      picture.leg.push_back(marker->samples[apart->row].position);
  video::WriteImage(run.Result("knees.png"), overlay::DrawKnees(picture));
}

// What a step's summary and its errors say of these options.
void Describe(const OptionList& list, const Json& given, steps::StudyStep& step) {
  step.summary_options.update(OptionsJson(list));
  step.summary_options.update(given);
  for (const auto& [name, value] : given.items()) step.given.push_back(name);
  for (steps::StudyKey& key : steps::KeysOf(list)) step.keys.push_back(std::move(key));
}

// The values of all options of a program, whoever gave them: all but its files, which are a step's inputs. Described
// with the program's defaults, as what differs from these has a text.
template <typename Options>
Json ValuesOf(const Options& options) {
  Options described;
  const OptionList list = OptionsOf(described);
  described = options;
  Json values = Json::object();
  for (const Option& option : list.All())
    if (option.PathKind() == Option::Path::kNone) values[option.Name()] = option.Text();
  return values;
}

// What the results of a command depend on but for its files.
template <typename Options>
Json KeyOf(const Options& options) {
  return ValuesOf(options);
}

Json KeyOf(const commands::OptimizeRunOptions& options) {
  Json key = {{"problem", problem::ProblemJson(options.problem)}, {"search", ValuesOf(options.study)}};
  if (options.reoptimize) key["reoptimize"] = ValuesOf(*options.reoptimize);
  return key;
}

Json KeyOf(const commands::SimulationOptions& options) {
  commands::SimulationOptions unloaded = options;
  unloaded.load = {};
  return {{"simulation", ValuesOf(unloaded)},
          {"wide seat", options.has_wide_seat},
          {"load", problem::ProblemJson(options.load)}};
}

Json KeyOf(const commands::CompareRunOptions& options) {
  const auto& [bar_width_mm, actuator_diameter_mm, seat_edge_mm, placement_mm, mount, has_wide_seat] = options.wear;
  return {{"comparison", ValuesOf(options)},
          {"wear",
           {bar_width_mm, actuator_diameter_mm, seat_edge_mm, placement_mm, linkage::NameOf(mount), has_wide_seat}}};
}

void AddInputs(const std::vector<InputFile>& inputs, steps::StudyStep& step) {
  for (const InputFile& input : inputs) step.inputs.push_back(input.path);
}

// One command with these options.
template <typename Options>
steps::StudyStep StepOf(Options options, Json (*command)(const Options&, Run&), const StudySection& section) {
  steps::StudyStep step{.options = section.text};
  step.options["all options"] = KeyOf(options);
  AddInputs(InputsOf(options), step);
  Describe(OptionsOf(options), section.given, step);
  step.work = [options = std::move(options), command](Run& run) { run.WriteSummary(command(options, run)); };
  return step;
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

// The leg that was measured, if the trial knows millimetres.
std::optional<person::LegLengths> LegOf(const fs::path& kinematics) {
  const motion::LegMotion motion = motion::ReadKinematicsCsv(kinematics);
  const double thigh = motion::MedianLength(motion, &motion::LegSample::kh);
  const double shank = motion::MedianLength(motion, &motion::LegSample::ak);
  if (motion.unit != motion::LengthUnit::kMm || std::isnan(thigh + shank)) return std::nullopt;
  return person::LegLengths{thigh, shank};
}

// The body that a design is made for and held against: as `simulate` says, else as the problem does, else as the loads
// do. Leg lengths come from the fit, where the problem has none.
person::BodySize BodyOf(const StudyFile& study, person::BodySize body) {
  const person::BodySize& simulated = study.simulation.body;
  if (simulated.mass_kg) body.mass_kg = simulated.mass_kg;
  if (simulated.height_mm) body.height_mm = simulated.height_mm;
  if (!study.loads) return body;
  if (!body.mass_kg) body.mass_kg = study.loads->loads.body.mass_kg;
  if (!body.height_mm) body.height_mm = study.loads->loads.body.height_mm;
  return body;
}

// Sets these options to what `simulate` says of them.
void TakeSimulated(const StudyFile& study, OptionList options) {
  for (Option& option : options.All()) {
    const auto said = study.simulation_section.given.find(option.Name());
    if (said == study.simulation_section.given.end()) continue;
    option.SetFromFile(said->is_array() ? said->get<OptionTexts>() : OptionTexts{said->get<std::string>()});
  }
}

// The problem's parts, but for what `simulate` says of them.
parts::PartOptions PartsOf(const StudyFile& study, parts::PartOptions parts) {
  TakeSimulated(study, OptionsOf(parts));
  return parts;
}

bool IsAssisted(const StudyFile& study) {
  return study.assistance && study.assistance->options.actuators.empty();
}

// What the design is simulated with: the load of its own problem, or where the study has one actuator for what the knee
// needs, that (its profile is read once it has been found); but for what `simulate` says.
problem::SynthesisProblem LoadOf(const StudyFile& study, const problem::SynthesisProblem& design) {
  const problem::SynthesisProblem& from = IsAssisted(study) ? study.assistance->options.problem : design;
  problem::SynthesisProblem load;
  load.profile = from.profile;
  load.assist = from.assist;
  load.actuator = from.actuator;
  load.rests_anywhere = from.rests_anywhere;
  load.duration_s = from.duration_s;
  OptionList options;
  problem::DescribeLoad(load, options);
  TakeSimulated(study, options);
  return load;
}

// As the options of lake-optimize, for its summary.
void TellParts(const StudyFile& study, problem::SynthesisProblem problem, StudySection& section) {
  const OptionList options = OptionsOf(problem.parts);
  for (const Option& option : options.All())
    if (study.simulation_section.given.contains(option.Name())) section.given[option.Name()] = option.Text();
}

}  // namespace

commands::SimulationOptions SimulationOf(const StudyFile& study) {
  const problem::SynthesisProblem& problem = (study.redesign ? study.redesign->design : study.design).problem;
  commands::SimulationOptions options = study.simulation;
  options.parts = PartsOf(study, problem.parts);
  options.load = LoadOf(study, problem);
  if (!study.simulation_section.given.contains("knee-torque")) options.knee_torque_nm = problem.knee_torque_nm;
  if (options.seat_edge_mm == 0) options.seat_edge_mm = problem.clearances.seat_edge_mm;
  options.has_wide_seat = problem.clearances.seat_mm.has_value();
  options.body = BodyOf(study, problem.clearances.body);
  if (!options.body.leg) options.body.leg = study.simulation.body.leg;
  return options;
}

namespace {

// A step of lake-optimize. Clearances are on the body of the person, with the parts that are simulated. `profile` is
// read once it has been found.
steps::StudyStep DesignStep(const StudyFile& study, const fs::path& out, commands::OptimizeRunOptions options,
                            StudySection section, const std::optional<fs::path>& profile = std::nullopt) {
  problem::SynthesisProblem& problem = options.problem;
  problem::Clearances& clearances = problem.clearances;
  problem.parts = PartsOf(study, problem.parts);
  TellParts(study, problem, section);
  const fs::path leg = out / "human" / "kinematics.csv";
  const bool needs_leg = clearances.AreAsked() && !clearances.body.leg;
  if (clearances.AreAsked()) {
    clearances.body = BodyOf(study, clearances.body);
    if (study.simulation.seat_edge_mm != 0) clearances.seat_edge_mm = study.simulation.seat_edge_mm;
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
  StudyTrial trial = *study.exo;
  if (!trial.Fit().technical.empty() && !trial.Fit().knee_trial) {
    trial.Fit().knee_trial = out / "human";
    trial.section.given["knee-from"] = (out / "human").string();
  }
  return TrialStep(trial, "the trial with exoskeleton", CameraOf(study, out));
}

// What was worn, on the body and with the parts that a design of the study is checked with.
void TakeWorn(const StudyFile& study, StudySection& section, commands::CompareRunOptions& options) {
  if (!study.worn) return;
  const commands::SimulationOptions simulation = SimulationOf(study);
  options.worn = study.worn;
  options.body = {.height_mm = simulation.body.height_mm, .mass_kg = simulation.body.mass_kg, .leg = {}};
  options.wear = {.bar_width_mm = simulation.parts.bar_width_mm,
                  .actuator_diameter_mm = simulation.parts.actuator_diameter_mm,
                  .seat_edge_mm = simulation.seat_edge_mm,
                  .has_wide_seat = simulation.has_wide_seat};
  section.given["worn"] = study.worn->string();
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
  steps::StudyStep step = StepOf(options, commands::RunLoads, study.loads_section);
  step.what = "the knee moment";
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
  commands::SimulationOptions options = SimulationOf(study);
  const bool is_assisted = IsAssisted(study);
  steps::StudyStep step{.what = "the design's poses", .options = study.simulation_section.text, .keys = {}};
  step.options["all options"] = KeyOf(options);
  const fs::path design = DesignOf(study, out), leg = out / "human" / "kinematics.csv";
  const std::vector<InputFile> own = {{design, "design"}, {leg, "leg"}};
  AddInputs(own, step);
  AddInputs(InputsOf(options), step);
  if (is_assisted) {
    AddInputs(InputsOf(study.assistance->options), step);
    step.inputs.push_back(ProfileIn(out));
  }
  Describe(OptionsOf(options), study.simulation_section.given, step);
  step.work = [options, is_assisted, profile = ProfileIn(out), own, design, leg](Run& run) {
    run.AddInputs(own);
    commands::SimulationOptions of_person = options;
    if (!of_person.body.leg) of_person.body.leg = LegOf(leg);
    if (is_assisted) of_person.load.profile = problem::ReadLoadProfile(profile);
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
