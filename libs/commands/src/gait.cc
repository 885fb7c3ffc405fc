#include "lake/commands/gait.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/core/numbers.h"
#include "lake/core/run.h"
#include "lake/core/statistics.h"
#include "lake/exchange/trial.h"
#include "lake/figure/trial_figures.h"
#include "lake/gait/learnt_knee.h"
#include "lake/gait/leg_report.h"
#include "lake/gait/movement.h"
#include "lake/gait/sit_to_stand.h"
#include "lake/motion/leg_motion.h"
#include "lake/motion/saved_corrections.h"
#include "movement_tables.h"
#include "png_and_svg.h"

namespace lake::commands {
namespace {

// Degrees of the first component of the output called `name` in each frame, NaN where missing. Throws Error listing the
// outputs of the file if it has none of this name, and for one that is no angle.
std::vector<double> ModelAngle(const exchange::Trial& trial, const std::string& name) {
  const auto found = std::ranges::find(trial.outputs, name, &exchange::ModelOutput::name);
  std::vector<std::string> names;
  for (const exchange::ModelOutput& output : trial.outputs) names.push_back(output.name);
  if (found == trial.outputs.end())
    throw Fail("--compare-with {}: {} has no such output of a model; it has: {}", name, trial.file.string(),
               names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", ")));
  if (found->kind != "angle")
    throw Fail("--compare-with {}: is a {} ({}), not an angle", name, found->kind, found->unit);
  const bool in_radians = found->unit.starts_with("rad");
  std::vector<double> angle_deg;
  for (const Eigen::Vector3d& value : found->positions)
    angle_deg.push_back(in_radians ? DegreesFromRadians(value.x()) : value.x());
  return angle_deg;
}

// Writes model_output.csv, and puts `compare_with` into the results: over the frames that have both, the mean of knee
// angle − output, the standard deviation about it, and the correlation of the two.
void WriteModelOutput(const std::string& name, const std::vector<double>& model_deg, const motion::LegMotion& motion,
                      Json& results, Run& run) {
  CsvWriter table({"frame", "time_s", "knee_deg", "model_deg", "difference_deg"});
  std::vector<double> ours, theirs, difference;
  for (std::size_t i = 0; i < motion.samples.size(); ++i) {
    const double knee_deg = motion.samples[i].knee_deg, other_deg = model_deg.at(i);
    table.AddRow(motion.frame[i], motion.time_s[i], knee_deg, other_deg, knee_deg - other_deg);
    if (!std::isfinite(knee_deg - other_deg)) continue;
    ours.push_back(knee_deg);
    theirs.push_back(other_deg);
    difference.push_back(knee_deg - other_deg);
  }
  if (difference.size() < 2) throw Fail("--compare-with {}: no frames have both it and a knee angle", name);
  if (!(StandardDeviation(theirs) > 0))
    throw Fail("--compare-with {}: is {:g}° in all frames: was it worked out?", name, theirs.front());
  const double mean_ours = Mean(ours), mean_theirs = Mean(theirs);
  double product = 0;
  for (std::size_t i = 0; i < ours.size(); ++i) product += (ours[i] - mean_ours) * (theirs[i] - mean_theirs);
  const double offset_deg = Mean(difference), sd_deg = StandardDeviation(difference),
               correlation = product / static_cast<double>(ours.size() - 1) /
                             (StandardDeviation(ours) * StandardDeviation(theirs));
  table.Write(run.Result("model_output.csv"));
  results["compare_with"] = {{"name", name},
                             {"frames", difference.size()},
                             {"offset_deg", offset_deg},
                             {"sd_deg", sd_deg},
                             {"correlation", correlation}};
  run.Report("knee angle − {}: {:.1f}° on average, ± {:.1f}° about that (1 SD over {} frames), correlation {:.4f}\n",
             name, offset_deg, sd_deg, difference.size(), correlation);
}

// Positions without standard deviations that scatter less about smooth curves than any camera's.
bool WasSmoothed(const exchange::Trial& trial, const gait::LegFitResult& result) {
  const double least = trial.recording.unit == motion::LengthUnit::kMm ? 0.01 : 0.003;
  for (const motion::MarkerTrack& marker : trial.recording.markers)
    for (const motion::MarkerSample& sample : marker.samples)
      if (sample.IsKnown() && sample.sigma > 0) return false;
  return std::all_of(result.markers.begin(), result.markers.end(),
                     [&](const gait::MarkerReport& marker) { return marker.rms < least; });
}

// What to ask of a trial whose leg is far too short or long.
std::string UnitQuestion(const exchange::Trial& trial, const std::string& unit) {
  exchange::TrialOptions in_unit;
  in_unit.mm_per_unit = kMmPerM;
  const bool states_none = exchange::UnusedOptions(trial.file, in_unit).empty();
  return "is the file in another unit? " +
         (states_none    ? "Give it with --unit" + (unit.empty() ? "" : " " + unit)
          : unit.empty() ? "It says mm"
                         : fmt::format("It says mm, and the lengths look like {}: write them in mm", unit));
}

gait::LegView ViewOf(const exchange::Trial& trial, const gait::PictureScale& picture, Run& run) {
  if (trial.recording.unit == motion::LengthUnit::kMm) return gait::MakeLegView(trial.recording.unit, std::nullopt);
  gait::PictureScale seen = picture;
  seen.pixel_aspect = trial.pixel_aspect;
  return gait::ViewOf(seen, trial.recording, trial.mm_per_px, [&run](const std::string& text) { run.Warn(text); });
}

// What is up in the view's plane; a trial in px says it of its picture, with y up.
Eigen::Vector2d UpIn(const gait::LegView& view, const exchange::Trial& trial) {
  if (!view.camera && view.pixel_aspect == 1) return *trial.up;
  constexpr double kLength_px = 100;
  const Eigen::Vector2d up_px(trial.up->x(), -trial.up->y());
  const Eigen::Vector2d middle =
      view.camera ? Eigen::Vector2d(view.camera->cx, view.camera->cy) : Eigen::Vector2d(0, 0);
  return gait::UpFromPlumbLine(view, middle + kLength_px * up_px, middle, up_px);
}

// Of a marker that somebody filled in, or that was lost and kept its place.
void WarnOfFrozenMarkers(const motion::MarkerRecording& recording, Run& run) {
  constexpr std::size_t kLeastFrames = 100;
  for (const motion::MarkerTrack& marker : recording.markers) {
    std::vector<Eigen::Vector2d> places;
    for (const motion::MarkerSample& sample : marker.samples)
      if (sample.IsKnown()) places.push_back(sample.position);
    if (places.size() >= kLeastFrames &&
        std::all_of(places.begin(), places.end(), [&](const Eigen::Vector2d& place) { return place == places[0]; }))
      run.Warn(
          "marker '{}' has the same coordinates to the last digit in all its {} frames: that is no measurement, and no "
          "standard deviation here says how far it is off",
          marker.name, places.size());
  }
}

void SayWarnings(const exchange::Trial& trial, const gait::LegFitResult& result, Run& run) {
  for (const std::string& warning : trial.warnings) run.Warn(warning);
  WarnOfFit(result, run);
  WarnOfFrozenMarkers(trial.recording, run);
  if (result.motion.unit == motion::LengthUnit::kPx)
    run.Warn("the trial has no scale: lengths are in px; give --scale, or a --camera with the sagittal plane");
  if (WasSmoothed(trial, result))
    run.Warn(
        "the positions were smoothed before, and the file does not say how certain they are: the standard deviations "
        "here describe the remaining noise only, and are too small");
  if (result.events.empty()) run.Warn("no sit-to-stand, walking or squat found: repetition and percent are left empty");
}

// Of summaries, true where a person moved events.
constexpr const char* kEventsCorrected = "events_corrected";

// events.csv of the folder that the trial is from, if a person moved events there: to be found again, they would be
// lost.
std::optional<std::filesystem::path> CorrectedEventsOf(const exchange::Trial& trial) {
  const std::filesystem::path folder = trial.file.parent_path(), events = folder / "events.csv";
  const std::string table = trial.file.filename().string();
  if ((table != "trajectory.csv" && table != "tracks.csv") || !std::filesystem::is_regular_file(events)) return {};
  const std::filesystem::path summary = folder / "summary.json";
  if (!std::filesystem::is_regular_file(summary)) return {};
  const Json said = ReadJsonFile(summary);
  return said.contains(kEventsCorrected) && said[kEventsCorrected] == true ? std::optional(events) : std::nullopt;
}

// In a picture it is the leg nearer to the camera.
std::optional<motion::Side> LegOf(const exchange::Trial& trial, const gait::LegFitResult& fit) {
  if (trial.leg || trial.recording.unit == motion::LengthUnit::kMm) return trial.leg;
  return motion::NearLeg(fit.motion.facing);
}

bool HasLeg(const motion::MarkerRecording& recording, const gait::LegFitOptions& fit) {
  const gait::LegMarkers& markers = fit.markers;
  return recording.Find(markers.ankle) && (fit.knee_trial || recording.Find(markers.knee)) &&
         recording.Find(markers.hip);
}

// Markers that are no leg: what is measured of them, and nothing else.
Json MeasureWithoutLeg(const exchange::Trial& trial, const GaitRunOptions& options, Run& run) {
  for (const std::string& warning : trial.warnings) run.Warn(warning);
  Json results = Json::object();
  WriteMeasures(gait::InPlane(trial.recording, ViewOf(trial, options, run)), options.measures, results, run);
  return results;
}

void TakeEvents(const std::filesystem::path& file, gait::LegFitResult& result) {
  result.events = motion::ReadEventsCsv(file);
  gait::SetRepetitions(result.events, result.motion);
}

// The other leg's markers, put on alike, have the same distances, and carry another knee.
void CheckSameLeg(const std::filesystem::path& knee_trial, const Json& results) {
  const std::filesystem::path summary = gait::LearntKneeFile(knee_trial);
  const auto learnt = exchange::LegInSummary(ReadJsonFile(summary)), own = exchange::LegInSummary(results);
  if (learnt && own && learnt != own)
    throw Fail("{}: the knee was learnt there at the {} leg, and this trial shows the {} one: learn it at the same leg",
               summary.string(), ToString(*learnt), ToString(*own));
}

// The fit; what is wrong with it is said with the file's name, as there may be two.
gait::LegFitResult FitOrName(const exchange::Trial& trial, const gait::LegView& view, const gait::LegFitOptions& fit) {
  try {
    return gait::FitLeg(trial.recording, view, fit, trial.lateral_mm);
  } catch (const UsageError&) {
    throw;
  } catch (const SolverError&) {
    throw;
  } catch (const Error& error) {
    throw Fail("{}: {}", trial.file.string(), error.what());
  }
}

}  // namespace

void Describe(GaitRunOptions& o, OptionList& options) {
  DescribeTrialFit(o, options);
  Describe(o.person, options);
  Describe(o.measures, options);
  Describe(o.budget, options);
  Describe(static_cast<FurtherInputs&>(o), options);
  options
      .Add("range-limit", o.range_limit_deg,
           "A mechanism's markers: is its knee shown to keep within these limits? range_limit.csv and .html")
      .Unit("degrees")
      .Value("LOW,HIGH");
  options
      .Add("compare-with", o.compare_with,
           "An angle of another program's model in the same C3D, beside the knee angle: model_output.csv")
      .Value("LKneeAngles")
      .Otherwise("none");
  options.Check([&o](const OptionList&) {
    if (o.range_limit_deg && !((*o.range_limit_deg)[0] < (*o.range_limit_deg)[1]))
      throw UsageError("--range-limit {},{}: the lower limit first", (*o.range_limit_deg)[0], (*o.range_limit_deg)[1]);
  });
}

void DescribeTrialFit(GaitRunOptions& o, OptionList& options) {
  options.AddOperand("trial", o.trial, "A lake-track folder, or " + exchange::ReadableEndings()).Required();
  Describe(o.reading, options);
  Describe(static_cast<gait::PictureScale&>(o), options);
  gait::DescribeDepths(o.depths, options);
  gait::DescribeFacing(o.fit, options);
  Describe(o.fit, options);
  gait::DescribeEvents(o.events, options);
}

bool IsTrialFolder(const std::filesystem::path& trial) {
  return std::filesystem::is_directory(trial) || !trial.has_extension();
}

std::vector<InputFile> TrialInputs(const std::filesystem::path& trial, const std::string& role) {
  if (!IsTrialFolder(trial)) return {{trial, role}};
  return {{trial / "trajectory.csv", role},
          {trial / "tracks.csv", role, true},
          {trial / "events.csv", role + " events"},
          {trial / motion::kSavedCorrections, role + " corrections"},
          {trial / motion::kSavedEvents, role + " corrected events"}};
}

std::vector<InputFile> InputsOf(const GaitRunOptions& options) {
  std::vector<InputFile> inputs = TrialInputs(options.trial, "trial");
  if (options.camera) inputs.push_back({*options.camera, "camera"});
  if (options.events) inputs.push_back({*options.events, "events"});
  if (options.fit.knee_trial) inputs.push_back({gait::LearntKneeFile(*options.fit.knee_trial), "knee from"});
  for (InputFile& input : InputsOf(static_cast<const FurtherInputs&>(options))) inputs.push_back(std::move(input));
  return inputs;
}

exchange::Trial ReadTrialFor(const std::filesystem::path& path, const exchange::TrialOptions& reading,
                             const gait::PictureScale& picture) {
  exchange::CheckNoneIsUnused(path, exchange::UnusedOptions(path, reading));
  exchange::Trial trial = exchange::ReadTrial(path, reading);
  if (trial.recording.unit == motion::LengthUnit::kMm) PutAtDepths(picture.depths, trial.sight, trial.recording);
  if (picture.IsGiven() && trial.recording.unit == motion::LengthUnit::kMm)
    exchange::CheckNoneIsUnused(trial.file, {{picture.OptionName(), "its lengths are in mm"}});
  return trial;
}

gait::LegFitResult FitTrial(const exchange::Trial& trial, gait::LegFitOptions fit, Run& run,
                            const gait::PictureScale& picture, const std::optional<std::filesystem::path>& events,
                            const FurtherInputs& further) {
  fit.quiet = run.Quiet();
  const gait::LegView view = ViewOf(trial, picture, run);
  if (trial.up) fit.up = UpIn(view, trial);
  fit.known_sigmas = trial.known_sigmas;
  fit.lasting_share = trial.lasting_share;
  if (trial.faces_right && !fit.facing) {
    fit.facing = *trial.faces_right ? motion::Facing::kRight : motion::Facing::kLeft;
    fit.said_facing = "--forward";
  }
  fit.unit_question = [&](const std::string& unit) { return UnitQuestion(trial, unit); };
  gait::ReadKneeFrom(fit);
  gait::LegFitResult result = FitOrName(trial, view, fit);
  if (!result.sight) result.sight = trial.sight;
  fit.movement.walking.contacts = ContactsOf(further, trial, run);
  gait::ChooseMovement(fit.movement, result);
  if (const auto corrected = CorrectedEventsOf(trial)) TakeEvents(*corrected, result);
  if (events) CorrectEventsBy(*events, result);
  SayWarnings(trial, result, run);
  return result;
}

void WarnOfFit(const gait::LegFitResult& fit, Run& run) {
  for (const std::string& warning : fit.warnings) run.Warn(warning);
  for (const std::string& warning : gait::UncertainEvents(fit.events)) run.Warn(warning);
  if (const std::string warning = gait::OnsetsWithoutLean(fit.signals, fit.events); !warning.empty()) run.Warn(warning);
}

void LearnKnee(const gait::LegFitResult& fit, const gait::LegFitOptions& options, const gait::LateralPlaces& lateral,
               Json& results, Run& run) {
  if (options.knee_trial) return CheckSameLeg(*options.knee_trial, results);
  if (options.technical.empty()) return;
  try {
    results[gait::kLearntKnee] = gait::LearntKneeJson(gait::LearnKnee(fit, options.technical, lateral));
  } catch (const UsageError&) {
    throw;
  } catch (const Error& error) {
    run.Warn("{}; where an exoskeleton hides the knee, --knee-from takes it from the trial without", error.what());
  }
}

Json CorrectEventsBy(const std::filesystem::path& file, gait::LegFitResult& fit) {
  gait::CorrectEvents(motion::ReadEventCorrections(file), fit);
  return {{kEventsCorrected, true}};
}

Json RunGait(const GaitRunOptions& options, Run& run) {
  exchange::TrialOptions reading = options.reading;
  for (const auto& [segment, markers] : options.fit.technical)
    for (const std::string& marker : markers)
      if (!reading.names.empty()) reading.names.try_emplace(marker, marker);  // not renamed: as the file calls it
  const exchange::Trial trial = ReadTrialFor(options.trial, reading, options);
  for (const auto& [name, depth] : options.depths)
    if (!trial.recording.Find(name))
      throw UsageError("--depth {}: {} has no such marker", name, options.trial.string());
  run.AddInputs(InputsOf(options));
  CheckFiles(options);
  gait::CheckMarkers(options.measures, gait::MarkerNames(trial.recording));
  const bool measures_alone = !options.measures.empty() && !HasLeg(trial.recording, options.fit);
  if (measures_alone && options.range_limit_deg)
    throw UsageError("--range-limit needs the markers ankle, knee and hip, which are not all in the file; see --map");
  if (options.events)
    motion::CheckAreInside(motion::ReadEventCorrections(*options.events), trial.recording.frame,
                           trial.recording.time_s);
  const std::vector<double> model_deg =
      options.compare_with.empty() ? std::vector<double>{} : ModelAngle(trial, options.compare_with);
  std::vector<std::string> names = LegResultNames("gait");
  names.insert(names.end(), {"range_limit.csv", "range_limit.html", "model_output.csv"});
  run.Begin(names);
  if (measures_alone) return MeasureWithoutLeg(trial, options, run);
  gait::LegFitResult result = FitTrial(trial, options.fit, run, options, options.events, options);
  SetNeutral(options, trial, options.reading, options.fit, run, result);
  Json results = Json::object();
  if (CorrectedEventsOf(trial) || options.events) results = {{kEventsCorrected, true}};
  const std::string repetitions =
      WriteMovement(result, options.fit.markers, options.budget, options.person, options.reference, results, run);
  if (options.range_limit_deg) WriteRangeLimit(result, options.budget, *options.range_limit_deg, results, run);
  run.Report(repetitions);
  if (result.trajectory.unit == motion::LengthUnit::kMm)
    motion::WriteTrajectoryCsv(run.Result("trajectory.csv"), result.trajectory, result.measured);
  if (result.tracks.unit == motion::LengthUnit::kPx) motion::WriteMarkerCsv(run.Result("tracks.csv"), result.tracks);
  if (!model_deg.empty()) WriteModelOutput(options.compare_with, model_deg, result.motion, results, run);
  DrawPngAndSvg("gait", run, figure::DrawLegFigure, result,
                figure::OtherAngle{.name = options.compare_with, .angle_deg = model_deg});
  results.update(gait::LegFitJson(result));
  if (const auto leg = LegOf(trial, result)) results[exchange::kLegKey] = ToString(*leg);
  LearnKnee(result, options.fit, trial.lateral_mm, results, run);
  WriteMeasures(result.measured, options.measures, results, run);
  return results;
}

}  // namespace lake::commands
