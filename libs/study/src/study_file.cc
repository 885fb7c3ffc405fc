#include "lake/study/study_file.h"

#include <glob.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <tuple>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/option_template.h"
#include "lake/core/options.h"
#include "lake/core/options_json.h"
#include "lake/core/removed.h"
#include "lake/core/yaml.h"
#include "lake/gait/learnt_knee.h"
#include "lake/gait/movement.h"
#include "lake/problem/problem_file.h"
#include "lake/problem/problem_options.h"
#include "lake/synthesis/synthesis_outcome.h"
#include "lake/video/video_files.h"

namespace lake::study {
namespace {

namespace fs = std::filesystem;

// What a study gives itself, of the options of the program behind each of its sections.
using OptionNames = std::vector<std::string_view>;

const OptionNames kGivenToCalibration{"pictures"};
const OptionNames kGivenToPlane{"camera"};
const OptionNames kGivenToCompare{
    "human", "exo",          "map",        "up",        "forward",          "unit", "exo-map", "exo-unit", "camera",
    "scale", "plane-points", "exo-camera", "exo-scale", "exo-plane-points", "worn", "height",  "mass",     "seat-edge"};
const OptionNames kGivenToPopulation{"comparison", "human",  "human-knee",   "map",  "up",      "forward",
                                     "unit",       "worn",   "participants", "body", "balance", "device-mass",
                                     "hold-force", "pareto", "cuff-penalty", "knee", "segment", "exo-segment"};
const OptionNames kGivenToRedesign{"comparison", "human",       "human-knee", "map",          "up",
                                   "forward",    "unit",        "worn",       "participants", "body",
                                   "balance",    "device-mass", "hold-force", "across",       "quantile",
                                   "sizes",      "knee",        "segment",    "exo-segment"};
const OptionNames kGivenToLoads{"trial", "map", "up", "forward", "unit", "rate"};
const OptionNames kGivenToAssistance{"problem", "profile", "actuator"};
const OptionNames kGivenToStroke{"design", "motion", "validate", "tolerance"};
const OptionNames kGivenToSimulation{"thigh", "shank", "mount"};

// A folder as a part of a wildcard that stands for itself.
std::string EscapedForGlob(const fs::path& folder) {
  std::string escaped;
  for (const char c : (folder / "").string()) escaped.append(std::strchr("*?[]\\", c) ? "\\" : "") += c;
  return folder.empty() ? "" : escaped;
}

// Collects the files that a study names, so that one error names all that are missing.
class InputFiles {
 public:
  explicit InputFiles(fs::path folder) : folder_(std::move(folder)) {}

  const fs::path& Folder() const { return folder_; }

  fs::path Take(const YamlNode& node) {
    const fs::path path = Resolve(node);
    Add(path, node);
    return path;
  }

  // A printf pattern (frames/%05d.png) stands for the folder it lies in.
  fs::path TakePictures(const YamlNode& node) {
    const fs::path path = Resolve(node);
    Add(video::FilesOfVideo(path), node);
    return path;
  }

  // All that a wildcard stands for, in order of their names.
  std::vector<fs::path> TakeAll(const YamlNode& node) {
    if (node.AsText().find('*') == std::string::npos) return {TakePictures(node)};
    const std::string pattern = EscapedForGlob(folder_) + node.AsText();
    glob_t found{};
    const std::unique_ptr<glob_t, void (*)(glob_t*)> cleanup(&found, globfree);
    std::vector<fs::path> paths;
    if (glob(pattern.c_str(), 0, nullptr, &found) == 0)
      for (std::size_t i = 0; i < found.gl_pathc; ++i) paths.push_back(fs::path(found.gl_pathv[i]).lexically_normal());
    if (paths.empty()) missing_.push_back(fmt::format("{} ({})", pattern, node.Where()));
    for (const fs::path& path : paths) Add(path, node);
    return paths;
  }

  void ThrowIfMissing(const fs::path& study) const {
    if (missing_.empty()) return;
    throw Fail("{}: {} missing: {}", study.string(),
               missing_.size() == 1 ? "a file is" : fmt::format("{} files are", missing_.size()),
               fmt::join(missing_, ", "));
  }

  const std::vector<StudyInput>& Found() const { return found_; }

 private:
  fs::path Resolve(const YamlNode& node) const {
    const std::string text = node.AsText();
    if (text.empty()) throw Fail("{}: a file is needed", node.Where());
    return (folder_ / text).lexically_normal();
  }

  void Add(const fs::path& path, const YamlNode& node) {
    if (!fs::exists(path)) {
      missing_.push_back(fmt::format("{} ({})", path.string(), node.Where()));
    } else if (std::none_of(found_.begin(), found_.end(), [&](const StudyInput& i) { return i.path == path; })) {
      found_.push_back({path, node.Where()});
    }
  }

  fs::path folder_;
  std::vector<StudyInput> found_;
  std::vector<std::string> missing_;
};

// The files behind an option, for ReadOptions.
ResolvePath FilesOf(InputFiles& files) {
  return [&files](const YamlNode& node, const Option& option) -> OptionTexts {
    return {(option.PathKind() == Option::Path::kVideo ? files.TakePictures(node) : files.Take(node)).string()};
  };
}

// All options of `options` but those that the study itself gives.
template <typename Options>
void ReadSection(YamlNode& node, Options& options, InputFiles& files, StudySection& section,
                 const OptionNames& without = {}) {
  OptionList list = OptionsOf(options).Without(without);
  ReadOptions(node, list, FilesOf(files));
  section.text = node.ToJson();
  section.given.update(GivenOptionsJson(list));
  for (const Option& option : list.All())  // "1.0" in the file is "1", as in the text of the section
    if (section.given.contains(option.Name()) && !option.IsRepeated() && !option.Text().empty())
      section.given[option.Name()] = option.Text();
}

StudyTrial ReadTrialSection(YamlNode node, InputFiles& files) {
  const auto video = node.Child("video"), recorded = node.Child("trial");
  if (video.has_value() == recorded.has_value())
    throw Fail("{}: give either 'video' or 'trial' (a file of markers that were tracked before)", node.Where());
  StudyTrial trial;
  if (video)
    ReadSection(node, trial.work.emplace<commands::TrackRunOptions>(), files, trial.section);
  else
    ReadSection(node, trial.work.emplace<commands::GaitRunOptions>(), files, trial.section);
  node.Finish();
  return trial;
}

commands::PlaneRunOptions ReadPlane(YamlNode& node, InputFiles& files, StudySection& section) {
  commands::PlaneRunOptions plane;
  if (!node.Has("image")) throw Fail("{}: the plane needs an 'image'", node.Where());
  ReadSection(node, plane, files, section, kGivenToPlane);
  if (plane.board.empty() == plane.points.empty()) throw Fail("{}: give either 'board' or 'points'", node.Where());
  node.Finish();
  return plane;
}

StudyCalibration ReadCalibration(YamlNode node, InputFiles& files) {
  StudyCalibration calibration;
  const auto images = node.Child("images"), video = node.Child("video");
  if (images.has_value() == video.has_value())
    throw Fail("{}: give either 'images' or 'video' of the board", node.Where());
  if (!node.Has("board")) throw Fail("{}: 'board' is missing, e.g. chessboard:9x6:25", node.Where());
  if (video) calibration.camera.pictures = {files.TakePictures(*video)};
  if (images && images->IsList()) {
    for (const YamlNode& image : images->Elements())
      for (const fs::path& path : files.TakeAll(image)) calibration.camera.pictures.push_back(path);
  } else if (images) {
    calibration.camera.pictures = files.TakeAll(*images);
  }
  ReadSection(node, calibration.camera, files, calibration.camera_section, kGivenToCalibration);
  if (auto plane = node.Child("plane")) calibration.plane = ReadPlane(*plane, files, calibration.plane_section);
  node.Finish();
  calibration.camera_section.text.erase("plane");
  return calibration;
}

void ReadCamera(YamlNode& root, InputFiles& files, StudyFile& study) {
  auto camera = root.Child("camera");
  if (!camera) return;
  if (!camera->IsMap()) {
    study.camera = files.Take(*camera);
    return;
  }
  auto calibrate = camera->Child("calibrate");
  if (!calibrate) throw Fail("{}: 'camera' is a file or has 'calibrate'", camera->Where());
  study.calibration = ReadCalibration(std::move(*calibrate), files);
  camera->Finish();
}

// A compared marker that is not among those looked for would be missed only after minutes of tracking.
void CheckCompared(const std::optional<std::string>& marker, const StudyTrial& trial, const YamlNode& node) {
  const commands::TrackRunOptions* video = std::get_if<commands::TrackRunOptions>(&trial.work);
  if (!marker || !video) return;
  const std::vector<std::string>& names = video->track.names;
  if (std::find(names.begin(), names.end(), *marker) == names.end())
    throw Fail("{}: '{}' is not among the markers of {} ({})", node.Where(), *marker, video->video.filename().string(),
               fmt::join(names, ", "));
}

void ReadCompare(YamlNode node, InputFiles& files, StudyFile& study) {
  ReadSection(node, study.compare, files, study.compare_section, kGivenToCompare);
  node.Finish();
  if (!study.exo) throw Fail("{}: 'compare' needs an 'exo' trial", node.Where());
  CheckCompared(study.compare.human_knee, study.human, node);
  CheckCompared(study.compare.exo_knee, *study.exo, node);
}

// A file is only named here; it is read when it is known that none is missing.
void ReadProblemKey(YamlNode& node, InputFiles& files, StudyProblem& problem) {
  auto child = node.Child("problem");
  if (child && child->IsMap())
    problem = {.file = {},
               .problem = problem::ReadProblem(std::move(*child), files.Folder()),
               .clearances = problem.clearances};
  else if (child)
    problem = {.file = files.Take(*child), .problem = {}, .clearances = problem.clearances};
  problem::SynthesisProblem asked;
  problem::ReadClearances(node, asked);
  if (asked.clearances.AreAsked()) problem.clearances = asked.clearances;
}

// What the study asks for stands above the problem's own.
void TakeClearances(StudyProblem& problem) {
  if (problem.clearances.AreAsked()) problem.problem.clearances = problem.clearances;
  problem::CheckMount(problem.problem);
}

void ReadDesignSection(YamlNode node, InputFiles& files, StudyFile& study) {
  ReadProblemKey(node, files, study.design);
  if (const auto worn = node.Child("worn")) study.worn = files.Take(*worn);
  ReadSection(node, study.optimum, files, study.design_section);
  node.Finish();
  if (study.worn && !study.exo) throw Fail("{}: 'worn' needs an 'exo' trial", node.Where());
}

problem::LinearActuator ActuatorOf(const YamlNode& node, const InputFiles& files) {
  try {
    return problem::FindActuator(node.AsText(), files.Folder());
  } catch (const Error& error) {
    throw Fail("{}: {}", node.Where(), error.what());
  }
}

// balance: {margin_mm: 20, device_mass_kg: 2, hold_force_n: 50}
void ReadBalance(YamlNode& node, StudyRedesign& redesign) {
  auto balance = node.Child("balance");
  if (!balance) return;
  redesign.options.balance_mm = balance->Number("margin_mm");
  if (!redesign.options.balance_mm || !(*redesign.options.balance_mm >= 0))
    throw Fail("{}: 'balance' needs 'margin_mm', how far the centre of pressure is inside the foot, 0 or more",
               balance->Where());
  Json& given = redesign.section.given;  // as the options of lake-optimize
  given["balance"] = FormatNumber(*redesign.options.balance_mm);
  for (const auto& [key, option, value] :
       {std::tuple{"device_mass_kg", "device-mass", &redesign.options.aids.device_kg},
        std::tuple{"hold_force_n", "hold-force", &redesign.options.aids.hold_n}}) {
    const auto number = balance->Number(key);
    if (!number) continue;
    if (!(*number >= 0)) throw Fail("{}: '{}' must be 0 or more, for this leg", balance->Where(), key);
    given[option] = FormatNumber(*value = *number);
  }
  balance->Finish();
}

StudyRedesign ReadRedesign(YamlNode node, InputFiles& files, const StudyProblem& design, const OptionNames& given) {
  StudyRedesign redesign{.options = {}, .search = {}, .design = design, .section = {}};
  ReadProblemKey(node, files, redesign.design);
  ReadBalance(node, redesign);
  ReadSection(node, redesign.search, files, redesign.section);
  ReadSection(node, redesign.options, files, redesign.section, given);
  node.Finish();
  return redesign;
}

commands::LoadsRunOptions ReadLoads(YamlNode node, InputFiles& files, StudySection& section) {
  if (!node.IsMap()) throw Fail("{}: 'loads' needs mass_kg: write loads: {{mass_kg: …}}", node.Where());
  commands::LoadsRunOptions options;
  ReadSection(node, options, files, section, kGivenToLoads);
  node.Finish();
  try {
    options.loads.body.Check();
  } catch (const Error& error) {
    throw Fail("{}: {}", node.Where(), error.what());
  }
  return options;
}

StudyAssistance ReadAssistance(YamlNode node, InputFiles& files) {
  StudyAssistance assistance;
  problem::SynthesisProblem& problem = assistance.options.problem;
  StudyProblem named;
  ReadProblemKey(node, files, named);
  if (named.file && fs::exists(*named.file)) named.problem = problem::ReadProblem(*named.file);
  TakeClearances(named);
  problem = named.problem;
  if (named.file) assistance.options.problem_file = *named.file;
  if (const auto actuator = node.Child("actuator")) {
    problem.actuator = ActuatorOf(*actuator, files);
    assistance.section.given["actuator"] = actuator->AsText();
  }
  ReadSection(node, assistance.options, files, assistance.section, kGivenToAssistance);
  node.Finish();
  if (assistance.options.actuators.empty() && !problem.actuator)
    throw Fail("{}: 'assistance' needs an 'actuator', or a catalogue of 'actuators'", node.Where());
  return assistance;
}

// Keys that earlier versions had.
void RefuseRemoved(const YamlNode& node, std::string_view program) {
  for (const Removed& removed : AllRemoved())
    if (removed.program == program && !removed.key.empty() && node.Has(removed.key))
      throw Fail("{}: '{}' is removed: {}", node.Where(), removed.key, removed.instead);
}

commands::StrokeRunOptions ReadStroke(YamlNode node, InputFiles& files, StudySection& section) {
  RefuseRemoved(node, "lake-stroke");
  commands::StrokeRunOptions options;
  ReadSection(node, options, files, section, kGivenToStroke);
  node.Finish();
  return options;
}

void ReadSimulation(YamlNode node, InputFiles& files, StudyFile& study) {
  ReadSection(node, study.simulation, files, study.simulation_section, kGivenToSimulation);
  node.Finish();
  study.simulation.Check();
}

void ReadProblemFile(StudyProblem& problem) {
  if (problem.file) problem.problem = problem::ReadProblem(*problem.file);
  TakeClearances(problem);
}

// Technical markers are on the person in both trials; a knee that the exoskeleton hides is as learnt in the human one.
void TakeTechnical(StudyFile& study) {
  const gait::TechnicalMarkers technical = study.human.Fit().technical;
  if (technical.empty() || !study.exo || study.exo->Fit().knee_trial) return;
  study.exo->Fit().technical = technical;
  if (auto* video = std::get_if<commands::TrackRunOptions>(&study.exo->work))
    gait::AddTechnical(technical, video->track.names);
  study.exo->section.text["technical"] = study.human.section.text["technical"];
  study.exo->section.given["technical"] = study.human.section.given["technical"];
}

YamlNode Required(YamlNode& root, const char* key) {
  auto child = root.Child(key);
  if (!child) throw Fail("{}: '{}' is missing", root.Where(), key);
  return std::move(*child);
}

// ---- the file to be filled in

template <typename Options>
std::string KeysOf(const OptionNames& without = {}, int indent = 2) {
  Options options;
  return OptionTemplate(OptionsOf(options).Without(without), indent);
}

std::string Section(std::string_view name, std::string_view meaning, const std::string& keys) {
  return fmt::format("\n# {}\n{}:\n{}", meaning, name, keys);
}

// One that may be left out.
std::string Optional(std::string_view name, std::string_view meaning, const std::string& keys) {
  return fmt::format("\n# {}\n{}", meaning, AsComment(fmt::format("{}:\n{}", name, keys)));
}

std::string Line(std::string_view key, std::string_view value, std::string_view meaning) {
  return TemplateLine(key, value, meaning, 2);
}

std::string CalibrationSection() {
  return "# Instead of the line above:\n" +
         AsComment("camera:\n  calibrate:\n" +
                   TemplateLine("images", "'board/*.png'", "pictures of the board; or video: FILE", 4) +
                   KeysOf<commands::CalibrateRunOptions>(kGivenToCalibration, 4) + "    plane:\n" +
                   KeysOf<commands::PlaneRunOptions>(kGivenToPlane, 6));
}

}  // namespace

const fs::path& StudyTrial::Recording() const {
  const auto* video = std::get_if<commands::TrackRunOptions>(&work);
  return video ? video->video : std::get<commands::GaitRunOptions>(work).trial;
}

gait::LegFitOptions& StudyTrial::Fit() {
  auto* video = std::get_if<commands::TrackRunOptions>(&work);
  return video ? video->fit : std::get<commands::GaitRunOptions>(work).fit;
}

void StudyFile::SetMovement(gait::MovementKind movement) {
  const auto set = [movement](gait::MovementOptions& options, StudySection& section) {
    options.kind = movement;
    section.text["movement"] = section.given["movement"] = gait::NameOf(movement);
  };
  set(human.Fit().movement, human.section);
  if (!exo) return;
  set(exo->Fit().movement, exo->section);
  set(compare.knee.movement, compare_section);
}

std::string StudyFile::ResultName() const {
  if (out) return out->string();
  const fs::path absolute = fs::absolute(file).lexically_normal();
  const fs::path stem = absolute.stem();
  return (stem == "study" ? absolute.parent_path().filename() : stem).string();
}

StudyRedesign ReadPopulation(YamlNode node, const fs::path& folder) {
  InputFiles files(folder);
  const std::string where = node.Where();
  StudyRedesign population = ReadRedesign(std::move(node), files, {}, kGivenToPopulation);
  files.ThrowIfMissing(where);
  ReadProblemFile(population.design);
  return population;
}

StudyFile ReadStudyFile(const fs::path& path) {
  YamlNode root = YamlNode::ReadFile(path);
  if (!root.IsMap()) throw Fail("{}: a study is a map with the keys human, exo, camera, …", path.string());
  ExpectKind(root, "study");
  // Where 'human' is missing because it is misspelt, that is said.
  for (const char* key : {"name", "out", "folder", "camera", "human", "exo", "compare", "design", "reoptimize", "loads",
                          "assistance", "simulate", "stroke"})
    root.Child(key);
  root.Finish();
  InputFiles files((path.parent_path() / root.Text("folder").value_or("")).lexically_normal());
  StudyFile study;
  study.file = path;
  study.name = root.Text("name").value_or(path.stem().string());
  if (const auto out = root.Text("out")) study.out = fs::absolute(path.parent_path() / *out).lexically_normal();
  ReadCamera(root, files, study);
  study.human = ReadTrialSection(Required(root, "human"), files);
  if (auto exo = root.Child("exo")) study.exo = ReadTrialSection(std::move(*exo), files);
  TakeTechnical(study);
  if (auto compare = root.Child("compare")) ReadCompare(std::move(*compare), files, study);
  if (auto design = root.Child("design")) ReadDesignSection(std::move(*design), files, study);
  if (auto reoptimize = root.Child("reoptimize")) {
    const std::string where = reoptimize->Where();
    study.redesign = ReadRedesign(std::move(*reoptimize), files, study.design, kGivenToRedesign);
    if (study.exo && !study.worn && !study.redesign->options.human_only)
      throw Fail(
          "{}: 'reoptimize' uses the exo trial: name the design that was worn in it with design: {{worn: FILE}}, or "
          "leave the trial out with human_only: true",
          where);
  }
  if (auto loads = root.Child("loads")) study.loads = ReadLoads(std::move(*loads), files, study.loads_section);
  if (study.redesign && study.redesign->options.balance_mm && !study.loads)
    throw Fail("{}: 'balance' needs the person's body: add loads: {{mass_kg: …}}", root.Where());
  if (auto assistance = root.Child("assistance")) {
    if (!study.loads)
      throw Fail("{}: 'assistance' is a share of the knee moment: add loads: {{mass_kg: …}}", assistance->Where());
    study.assistance = ReadAssistance(std::move(*assistance), files);
  }
  if (auto simulate = root.Child("simulate")) ReadSimulation(std::move(*simulate), files, study);
  if (auto stroke = root.Child("stroke")) study.stroke = ReadStroke(std::move(*stroke), files, study.stroke_section);
  files.ThrowIfMissing(path);
  ReadProblemFile(study.design);
  if (study.redesign) ReadProblemFile(study.redesign->design);
  study.inputs = files.Found();
  return study;
}

std::string StudyTemplate() {
  return "# A study for `lake run`. Paths are relative to this file. Remove the '#' before a key, and before its "
         "section,\n"
         "# to set it; the values shown are the defaults or examples.\n" +
         TemplateLine("name", "My study", "stands above the report") +
         AsComment(TemplateLine("out", "lake-out/my-study", "folder for the results") +
                   TemplateLine("folder", "recordings", "folder that all paths below are relative to")) +
         TemplateLine("camera", "camera.yaml", "lens and sagittal plane, from lake calibrate") + CalibrationSection() +
         Section("human", "The trial without exoskeleton.",
                 Line("video", "human.mp4", "video, or image sequence as frames/%05d.png") +
                     AsComment(KeysOf<commands::TrackRunOptions>({"video"}), 2)) +
         Section("exo", "The trial with it. Without this section there is nothing to compare.",
                 Line("video", "exo.mp4", "the keys are those of `human`") +
                     Line("markers", "[ankle, knee, hip, waist, exo_knee]",
                          "the leg's, and that of the exoskeleton's joint") +
                     Line("seeds", "['exo_knee=640,360']", "where the joint's marker is in the first frame, px")) +
         Optional("human", "A trial that was tracked before, in the place of a video; exo likewise.",
                  Line("trial", "human.trc", "a lake track folder, or .csv, .trc, .c3d, .trk, .txt") +
                      KeysOf<commands::GaitRunOptions>({"trial"})) +
         Optional("compare", "How the two trials are compared.", KeysOf<commands::CompareRunOptions>(kGivenToCompare)) +
         Optional("design", "The largest range of rotation, whoever wears it.",
                  Line("problem", "problem.yaml", "what it must satisfy: lake optimize --template problem.yaml") +
                      Line("worn", "worn.yaml", "the design that was worn in the exo trial") +
                      KeysOf<synthesis::SynthesisOptions>()) +
         Optional("reoptimize", "A design for this person; with an exo trial it needs design: {worn: FILE}.",
                  Line("balance", "{margin_mm: 20}", "the person keeps the balance all along; needs loads") +
                      KeysOf<synthesis::SynthesisOptions>() +
                      KeysOf<commands::ReoptimizeRunOptions>(kGivenToRedesign)) +
         Optional("loads", "The moments at the joints of the trial without exoskeleton.",
                  KeysOf<commands::LoadsRunOptions>(kGivenToLoads)) +
         Optional("assistance", "The links with which an actuator provides the knee moment; needs loads.",
                  Line("problem", "problem.yaml", "as in design") +
                      Line("actuator", "LA31-1000", "a name of the catalogue, or a file") +
                      KeysOf<commands::OptimizeRunOptions>(kGivenToAssistance)) +
         Optional("simulate", "The body on which designs are drawn and held against seat and limbs.",
                  KeysOf<commands::SimulationOptions>(kGivenToSimulation)) +
         Optional("stroke", "The actuator's stroke program and firmware.",
                  KeysOf<commands::StrokeRunOptions>(kGivenToStroke));
}

}  // namespace lake::study
