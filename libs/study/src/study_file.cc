#include "lake/study/study_file.h"

#include <glob.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <memory>

#include "lake/camera/plane_fit.h"
#include "lake/commands/track_text.h"
#include "lake/core/error.h"
#include "lake/core/yaml.h"
#include "lake/problem/problem_file.h"
#include "lake/video/video_files.h"

namespace lake::study {
namespace {

namespace fs = std::filesystem;

// What `read` complains of, with the line it stands in.
template <typename Read>
auto At(const YamlNode& node, Read read) {
  try {
    return read();
  } catch (const Error& error) {
    throw Fail("{}: {}", node.Where(), error.what());
  }
}

// A folder as a part of a wildcard that stands for itself.
std::string EscapedForGlob(const fs::path& folder) {
  std::string escaped;
  for (const char c : (folder / "").string()) escaped.append(std::strchr("*?[]\\", c) ? "\\" : "") += c;
  return folder.empty() ? "" : escaped;
}

// Collects the files that a study names, so that all missing ones can be told of at once.
class Files {
 public:
  explicit Files(fs::path folder) : folder_(std::move(folder)) {}

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

std::vector<std::string> Texts(const YamlNode& list) {
  std::vector<std::string> texts;
  for (const YamlNode& element : list.Elements()) texts.push_back(element.AsText());
  return texts;
}

template <std::size_t kCount>
void ReadNumbers(YamlNode& node, const char* key, std::optional<std::array<double, kCount>>& field) {
  const auto numbers = node.Numbers(key, kCount);
  if (numbers) std::copy(numbers->begin(), numbers->end(), field.emplace().begin());
}

void ReadFilter(YamlNode& node, gait::LegFitOptions& fit) {
  if (const auto filter = node.Child("filter"))
    fit.filter = At(*filter, [&] { return gait::ParseLegFilter(filter->AsText()); });
  fit.cutoff_hz = node.Number("cutoff_hz");
  if (fit.cutoff_hz && !(*fit.cutoff_hz > 0)) throw Fail("{}: 'cutoff_hz' must be positive", node.Where());
}

void ReadDetector(YamlNode& node, tracking::TrackOptions& track) {
  if (const auto markers = node.Child("markers")) track.names = Texts(*markers);
  if (const auto seeds = node.Child("seeds"))
    for (const YamlNode& seed : seeds->Elements())
      track.seeds.push_back(At(seed, [&] { return commands::ParseSeed(seed.AsText()); }));
  if (const auto detector = node.Child("detector"))
    track.detector = At(*detector, [&] { return commands::ParseDetector(detector->AsText()); });
  if (const auto polarity = node.Child("polarity"))
    track.polarity = At(*polarity, [&] { return commands::ParsePolarity(polarity->AsText()); });
  if (const auto colors = node.Child("colors")) track.colors = Texts(*colors);
  if (const auto dictionary = node.Text("dictionary")) track.dictionary = *dictionary;
  if (const auto crop = node.Numbers("crop", 4)) track.crop = At(node, [&] { return commands::CropOf(*crop); });
}

commands::TrackRunOptions ReadVideo(YamlNode& node, const YamlNode& video, Files& files) {
  commands::TrackRunOptions options;
  options.video = files.TakePictures(video);
  ReadDetector(node, options.track);
  video::VideoReaderOptions& reader = options.track.reader;
  reader.start_s = node.Number("start_s"), reader.end_s = node.Number("end_s");
  if (reader.start_s && reader.end_s && *reader.end_s < *reader.start_s)
    throw Fail("{}: 'end_s' is before 'start_s'", node.Where());
  reader.capture_rate_hz = node.Number("capture_rate_hz").value_or(0);
  if (const auto camera = node.Child("camera")) options.camera = files.Take(*camera);
  ReadNumbers(node, "scale", options.scale);
  ReadNumbers(node, "vertical", options.vertical);
  if (auto depths = node.Child("depth_mm"))
    for (const auto& [name, depth] : depths->Pairs()) options.depth_mm[name] = depth.AsNumber();
  if (const auto corrections = node.Child("corrections")) options.corrections = files.Take(*corrections);
  options.overlay = node.Boolean("overlay").value_or(options.overlay);
  ReadFilter(node, options.fit);
  At(node, [&] { options.track.Check(); });
  return options;
}

commands::GaitRunOptions ReadRecordedTrial(YamlNode& node, const YamlNode& trial, Files& files) {
  commands::GaitRunOptions options;
  options.trial = files.Take(trial);
  if (auto map = node.Child("map"))
    for (const auto& [name, marker] : map->Pairs()) options.reading.names[name] = marker.AsText();
  if (const auto up = node.Text("up")) {
    if (up->size() != 1) throw Fail("{}: 'up' must be x, y or z, not '{}'", node.Where(), *up);
    options.reading.up = up->front();
  }
  options.reading.forward = node.Text("forward").value_or("");
  if (const auto unit = node.Child("unit"))
    options.reading.mm_per_unit = At(*unit, [&] { return commands::MmPerUnit(unit->AsText()); });
  if (const auto facing = node.Child("facing"))
    options.fit.facing = At(*facing, [&] { return commands::ParseFacing(facing->AsText()); });
  ReadFilter(node, options.fit);
  return options;
}

StudyTrial ReadTrialSection(YamlNode node, Files& files) {
  const auto video = node.Child("video"), recorded = node.Child("trial");
  if (video.has_value() == recorded.has_value())
    throw Fail("{}: give either 'video' or 'trial' (a file of markers that were tracked before)", node.Where());
  StudyTrial trial;
  if (video)
    trial.work = ReadVideo(node, *video, files);
  else
    trial.work = ReadRecordedTrial(node, *recorded, files);
  node.Finish();
  trial.options = node.ToJson();
  return trial;
}

commands::PlaneRunOptions ReadPlane(YamlNode& node, Files& files) {
  commands::PlaneRunOptions plane;
  const auto image = node.Child("image");
  if (!image) throw Fail("{}: the plane needs an 'image'", node.Where());
  plane.picture = files.Take(*image);
  plane.board = node.Text("board").value_or(""), plane.points = node.Text("points").value_or("");
  if (plane.board.empty() == plane.points.empty()) throw Fail("{}: give either 'board' or 'points'", node.Where());
  At(node, [&] {
    plane.board.empty() ? void(camera::ParsePlanePoints(plane.points)) : void(camera::ParseBoard(plane.board));
  });
  plane.click_sigma_px = node.Number("click_sigma_px").value_or(plane.click_sigma_px);
  node.Finish();
  return plane;
}

StudyCalibration ReadCalibration(YamlNode node, Files& files) {
  StudyCalibration calibration;
  const auto images = node.Child("images"), video = node.Child("video"), board = node.Child("board");
  if (images.has_value() == video.has_value())
    throw Fail("{}: give either 'images' or 'video' of the board", node.Where());
  if (!board) throw Fail("{}: 'board' is missing, e.g. chessboard:9x6:25", node.Where());
  if (video) calibration.camera.pictures = {files.TakePictures(*video)};
  if (images && images->IsList()) {
    for (const YamlNode& image : images->Elements())
      for (const fs::path& path : files.TakeAll(image)) calibration.camera.pictures.push_back(path);
  } else if (images) {
    calibration.camera.pictures = files.TakeAll(*images);
  }
  calibration.camera.board = board->AsText();
  At(*board, [&] { camera::ParseBoard(calibration.camera.board); });
  calibration.camera.calibration.fix_k3 = node.Boolean("fix_k3").value_or(false);
  calibration.camera.calibration.square_pixels = node.Boolean("square_pixels").value_or(false);
  if (auto plane = node.Child("plane")) {
    calibration.plane = ReadPlane(*plane, files);
    calibration.plane_options = plane->ToJson();
  }
  node.Finish();
  calibration.camera_options = node.ToJson();
  calibration.camera_options.erase("plane");
  return calibration;
}

void ReadCamera(YamlNode& root, Files& files, StudyFile& study) {
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

void ReadCompare(YamlNode node, StudyFile& study) {
  study.compare.human_knee = node.Text("human_knee").value_or(study.compare.human_knee);
  study.compare.exo_knee = node.Text("exo_knee");
  double& replacement_mm = study.compare.misalignment.replacement_sd_mm;
  replacement_mm = node.Number("replacement_sd_mm").value_or(replacement_mm);
  if (replacement_mm < 0) throw Fail("{}: 'replacement_sd_mm' must not be negative", node.Where());
  node.Finish();
  study.compare_options = node.ToJson();
  if (!study.exo) throw Fail("{}: 'compare' needs an 'exo' trial", node.Where());
  CheckCompared(study.compare.human_knee, study.human, node);
  CheckCompared(study.compare.exo_knee, *study.exo, node);
}

std::optional<double> PositiveNumber(YamlNode& node, const char* key) {
  const std::optional<double> value = node.Number(key);
  if (value && !(*value > 0)) throw Fail("{}: '{}' must be positive", node.Where(), key);
  return value;
}

// A file is only named here; it is read when it is known that none is missing.
void ReadProblemKey(YamlNode& node, Files& files, StudyProblem& problem) {
  auto child = node.Child("problem");
  if (child && child->IsMap())
    problem = {std::nullopt, problem::ReadProblem(std::move(*child))};
  else if (child)
    problem = {files.Take(*child), {}};
}

void ReadDesignSection(YamlNode node, Files& files, StudyFile& study) {
  study.design_options = node.ToJson();
  ReadProblemKey(node, files, study.design);
  if (const auto worn = node.Child("worn")) study.worn = files.Take(*worn);
  study.certify_gap_deg = PositiveNumber(node, "certify_deg");
  study.yield_tolerance_mm = PositiveNumber(node, "yield_mm");
  node.Finish();
  if (study.worn && !study.exo) throw Fail("{}: 'worn' needs an 'exo' trial", node.Where());
}

linkage::StrokeProgram::Kind ParseProgram(const YamlNode& node) {
  const std::string text = node.AsText();
  if (text != "constant" && text != "free") throw Fail("{}: program '{}': constant or free", node.Where(), text);
  return text == "free" ? linkage::StrokeProgram::Kind::kFree : linkage::StrokeProgram::Kind::kConstant;
}

StudyRedesign ReadRedesign(YamlNode node, Files& files, const StudyProblem& design) {
  StudyRedesign redesign{{}, design, node.ToJson()};
  ReadProblemKey(node, files, redesign.design);
  commands::ReoptimizeRunOptions& options = redesign.options;
  options.max_misalignment_percent = PositiveNumber(node, "max_misalignment_percent");
  options.penalty_deg_per_mm = PositiveNumber(node, "penalty").value_or(options.penalty_deg_per_mm);
  if (const auto program = node.Child("program")) options.program.kind = ParseProgram(*program);
  options.program.max_speed_mm_s = PositiveNumber(node, "max_speed_mm_s").value_or(options.program.max_speed_mm_s);
  options.program.duration_s = PositiveNumber(node, "duration_s");
  options.program.monotone = node.Boolean("monotone").value_or(options.program.monotone);
  options.program.knots = node.Integer("knots").value_or(options.program.knots);
  options.fit_placement = node.Boolean("fit_placement").value_or(options.fit_placement);
  options.placement_reach_mm = PositiveNumber(node, "placement_reach_mm").value_or(options.placement_reach_mm);
  options.human_only = node.Boolean("human_only").value_or(options.human_only);
  options.pareto_points = node.Integer("pareto");
  if (options.pareto_points && *options.pareto_points < 2)
    throw Fail("{}: 'pareto' must be at least 2 points", node.Where());
  node.Finish();
  return redesign;
}

commands::StrokeRunOptions ReadStroke(YamlNode node, Files& files) {
  commands::StrokeRunOptions options;
  if (const auto table = node.Child("duty_table")) options.duty_table = files.Take(*table);
  actuator::ScheduleOptions& schedule = options.schedule;
  schedule.speed_mm_s = node.Number("speed_mm_s");
  schedule.from_deg = node.Number("from_deg"), schedule.to_deg = node.Number("to_deg");
  schedule.margin_mm = node.Number("margin_mm").value_or(schedule.margin_mm);
  schedule.max_speed_mm_s = node.Number("max_speed_mm_s");
  schedule.return_trip = node.Boolean("return").value_or(schedule.return_trip);
  schedule.hold_s = node.Number("hold_s").value_or(schedule.hold_s);
  schedule.dead_time_s = node.Number("dead_time_s").value_or(schedule.dead_time_s);
  actuator::FirmwareOptions& firmware = options.firmware;
  firmware.home_stroke_mm = PositiveNumber(node, "home_stroke_mm").value_or(firmware.home_stroke_mm);
  firmware.extend_stop_mm = PositiveNumber(node, "extend_stop_mm").value_or(firmware.extend_stop_mm);
  firmware.speed_tolerance_percent = PositiveNumber(node, "speed_tolerance_percent");
  firmware.accept_drift = node.Boolean("accept_drift").value_or(firmware.accept_drift);
  options.rate_hz = PositiveNumber(node, "rate_hz").value_or(options.rate_hz);
  node.Finish();
  At(node, [&] { schedule.Check(), firmware.Check(); });
  return options;
}

void ReadProblemFile(StudyProblem& problem) {
  if (problem.file) problem.problem = problem::ReadProblem(*problem.file);
}

YamlNode Required(YamlNode& root, const char* key) {
  auto child = root.Child(key);
  if (!child) throw Fail("{}: '{}' is missing", root.Where(), key);
  return std::move(*child);
}

}  // namespace

const fs::path& StudyTrial::Recording() const {
  const auto* video = std::get_if<commands::TrackRunOptions>(&work);
  return video ? video->video : std::get<commands::GaitRunOptions>(work).trial;
}

std::string StudyFile::ResultName() const {
  if (out) return out->string();
  const fs::path absolute = fs::absolute(file).lexically_normal();
  const fs::path stem = absolute.stem();
  return (stem == "study" ? absolute.parent_path().filename() : stem).string();
}

StudyFile ReadStudyFile(const fs::path& path) {
  YamlNode root = YamlNode::ReadFile(path);
  if (!root.IsMap()) throw Fail("{}: a study is a map with the keys human, exo, camera, …", path.string());
  Files files(path.parent_path());
  StudyFile study;
  study.file = path;
  study.name = root.Text("name").value_or(path.stem().string());
  if (const auto out = root.Text("out")) study.out = fs::absolute(path.parent_path() / *out).lexically_normal();
  ReadCamera(root, files, study);
  study.human = ReadTrialSection(Required(root, "human"), files);
  if (auto exo = root.Child("exo")) study.exo = ReadTrialSection(std::move(*exo), files);
  if (auto compare = root.Child("compare")) ReadCompare(std::move(*compare), study);
  if (auto design = root.Child("design")) ReadDesignSection(std::move(*design), files, study);
  if (auto reoptimize = root.Child("reoptimize")) {
    const std::string where = reoptimize->Where();
    study.redesign = ReadRedesign(std::move(*reoptimize), files, study.design);
    if (study.exo && !study.worn && !study.redesign->options.human_only)
      throw Fail(
          "{}: 'reoptimize' uses the exo trial: name the design that was worn in it with design: {{worn: FILE}}, or "
          "leave the trial out with human_only: true",
          where);
  }
  if (auto stroke = root.Child("stroke")) {
    study.stroke_options = stroke->ToJson();
    study.stroke = ReadStroke(std::move(*stroke), files);
  }
  root.Finish();
  files.ThrowIfMissing(path);
  ReadProblemFile(study.design);
  if (study.redesign) ReadProblemFile(study.redesign->design);
  study.inputs = files.Found();
  return study;
}

}  // namespace lake::study
