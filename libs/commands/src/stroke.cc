#include "lake/commands/stroke.h"

#include <algorithm>
#include <cmath>

#include "lake/actuator/prototype_validation.h"
#include "lake/core/atomic_file.h"
#include "lake/core/error.h"
#include "lake/core/json_or_null.h"
#include "lake/core/provenance.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "lake/figure/stroke_figures.h"
#include "lake/motion/leg_motion.h"
#include "png_and_svg.h"

namespace lake::commands {
namespace {

namespace fs = std::filesystem;

motion::LegMotion ReadMotion(const fs::path& folder) {
  const std::optional<fs::path> file = FindResult(folder, "kinematics.csv");
  if (!file)
    throw Fail("{}: no kinematics.csv in it; give a folder that lake-track or lake-gait wrote", folder.string());
  return motion::ReadKinematicsCsv(*file);
}

// The knee angle nearest to a percent, meaned over the repetitions.
double AngleAtPercent(const motion::LegMotion& motion, double percent, const fs::path& folder) {
  constexpr double kNear = 3;  // percent; a sample of any ordinary frame rate is nearer
  std::vector<double> angles;
  std::vector<std::pair<double, double>> nearest;  // by repetition: distance, angle
  for (const motion::LegSample& sample : motion.samples) {
    if (!sample.repetition || std::isnan(sample.percent) || std::isnan(sample.knee_deg)) continue;
    const auto index = static_cast<std::size_t>(std::clamp(*sample.repetition, 1, 10'000));
    if (nearest.size() < index) nearest.resize(index, {kNear, 0});
    const double distance = std::abs(sample.percent - percent);
    if (distance <= nearest[index - 1].first) nearest[index - 1] = {distance, sample.knee_deg};
  }
  for (const auto& [distance, angle] : nearest)
    if (distance < kNear) angles.push_back(angle);
  if (angles.empty())
    throw Fail("{}: no rise with a knee angle at {} %; give --from-angle and --to-angle", folder.string(), percent);
  return Mean(angles);
}

// Fills in the angles between which a person rises, as far as the design has them.
void TakeMotion(const StrokeRunOptions& options, const linkage::Design& design, actuator::ScheduleOptions& schedule,
                Run& run) {
  if (!options.motion) return;
  if (!schedule.speed_mm_s && design.program && design.program->kind == linkage::StrokeProgram::Kind::kFree)
    throw UsageError(
        "--motion says where a constant program begins and ends, and this design's program has knots of its own: leave "
        "--motion out, or give a constant speed with --speed");
  const motion::LegMotion motion = ReadMotion(*options.motion);
  const actuator::SoftLimits limits = actuator::SoftLimitsOf(design, schedule.margin_mm);
  const double a = actuator::KneeDegAt(design.links, limits.lower_mm),
               b = actuator::KneeDegAt(design.links, limits.upper_mm);
  const auto take = [&](std::optional<double>& angle, double percent) {
    if (angle) return;
    const double human = AngleAtPercent(motion, percent, *options.motion);
    angle = std::clamp(human, std::min(a, b), std::max(a, b));
    if (*angle != human)
      run.Warn("the knee angle at {} % is {:.2f}°; the design's soft limits end at {:.2f}°, which is taken", percent,
               human, *angle);
  };
  take(schedule.from_deg, 0);
  take(schedule.to_deg, 100);
}

double FastestKnee(const std::vector<actuator::ScheduleRow>& rows) {
  double fastest = 0;
  for (std::size_t i = 1; i < rows.size(); ++i)
    fastest =
        std::max(fastest, std::abs(rows[i].knee_deg - rows[i - 1].knee_deg) / (rows[i].time_s - rows[i - 1].time_s));
  return fastest;
}

double FastestStroke(const std::vector<actuator::ScheduleRow>& rows) {
  double fastest = 0;
  for (const actuator::ScheduleRow& row : rows) fastest = std::max(fastest, std::abs(row.speed_mm_s));
  return fastest;
}

Json ProgramJson(const actuator::StrokeSchedule& schedule, const std::vector<actuator::ScheduleRow>& rows) {
  return {{"duration_s", schedule.Duration()},
          {"rows", rows.size()},
          {"start", {{"stroke_mm", rows.front().stroke_mm}, {"knee_deg", rows.front().knee_deg}}},
          {"end", {{"stroke_mm", rows.back().stroke_mm}, {"knee_deg", rows.back().knee_deg}}},
          {"largest_speed_mm_s", FastestStroke(rows)},
          {"largest_knee_deg_s", FastestKnee(rows)},
          {"reversals", schedule.reversals},
          {"smoothed_mm", schedule.smoothed_mm},
          {"added_rest_s", schedule.added_rest_s},
          {"soft_limits_mm", {schedule.limits.lower_mm, schedule.limits.upper_mm}},
          {"used_stroke_mm", {schedule.limits.used.stroke.lower_mm, schedule.limits.used.stroke.upper_mm}}};
}

// Who made a generated header, for its comment.
std::string MadeBy(const std::string& from) {
  return fmt::format("Made by lake-stroke {} from {}.", Version(), from);
}

Json CrawlJson(const actuator::CrawlSummary& crawl) {
  return {{"stretches", crawl.stretches},
          {"duration_s", crawl.duration_s},
          {"stroke_error_mm", crawl.stroke_error_mm},
          {"knee_error_deg", crawl.knee_error_deg},
          {"added_rest_s", crawl.added_rest_s}};
}

constexpr const char *kSchematic = "schematic.svg", *kSignOff = "SIGN-OFF.md";

// What goes into the flash, and what belongs beside it.
struct SketchFiles {
  actuator::Sketch sketch;
  actuator::DriftForecast drift;
  std::string header, notes;
  std::vector<actuator::FirmwareFile> commissioning;
};

Json DriftJson(const actuator::DriftForecast& drift, bool accepted) {
  return {{"tolerance_percent", drift.tolerance_percent},
          {"tolerance_measured", drift.is_measured},
          {"tolerable_percent", drift.tolerable_percent},
          {"end_mm", drift.end_mm},
          {"nearest", {{"time_s", drift.time_s}, {"planned_mm", drift.planned_mm}, {"drift_mm", drift.drift_mm}}},
          {"last_drift_mm", drift.last_drift_mm},
          {"fits", drift.Fits()},
          {"accepted", accepted}};
}

Json FirmwareJson(const Json& files, const SketchFiles& made) {
  const actuator::StrokeTable& stroke = made.sketch.stroke;
  return {{"files", files},
          {"segments", stroke.segments.size()},
          {"segment_bytes", stroke.segments.size() * actuator::kSegmentBytes},
          {"rounding_error_mm", stroke.rounding_error_mm},
          {"pwm_error_mm", stroke.pwm_error_mm},
          {"home_stroke_mm", made.sketch.HomeStroke()},
          {"extend_stop_mm", ValueOrNull(made.sketch.ExtendStop())},
          {"drift", DriftJson(made.drift, made.sketch.options.accept_drift)}};
}

const char* VerdictText(actuator::Verdict verdict) {
  switch (verdict) {
    case actuator::Verdict::kFollows:
      return "follows the prediction";
    case actuator::Verdict::kOtherSpeed:
      return "has the predicted angles at another speed";
    case actuator::Verdict::kOtherAngles:
      break;
  }
  return "differs from the prediction";
}

Json ValidationJson(const actuator::Validation& v, double tolerance_deg) {
  return {{"verdict", VerdictText(actuator::Judge(v, tolerance_deg))},
          {"tolerance_deg", tolerance_deg},
          {"travel_factor", v.travel_factor},
          {"start_with_factor_s", v.start_with_factor_s},
          {"rms_with_factor_deg", v.rms_with_factor_deg},
          {"drift_mm", v.drift_mm},
          {"shift_s", v.shift_s},
          {"rms_deg", v.rms_deg},
          {"max_deg", v.max_deg},
          {"max_time_s", v.max_time_s},
          {"offset_deg", v.offset_deg},
          {"rms_with_offset_deg", v.rms_with_offset_deg},
          {"speed_mm_s", v.speed_mm_s},
          {"speed_se_mm_s", v.speed_se_mm_s},
          {"program_seen", v.covered}};
}

std::vector<actuator::AngleSample> KneeAngles(const fs::path& folder) {
  const motion::LegMotion motion = ReadMotion(folder);
  std::vector<actuator::AngleSample> samples;
  for (std::size_t i = 0; i < motion.samples.size(); ++i)
    if (!std::isnan(motion.samples[i].knee_deg)) samples.push_back({motion.time_s[i], motion.samples[i].knee_deg});
  return samples;
}

// The linkage's errors and the actuator's, by what measured the stroke: "log" or "video".
struct MeasuredApart {
  const char* strokes;
  actuator::SeparatedErrors errors;
};

Json SeparatedJson(const MeasuredApart& apart) {
  const actuator::SeparatedErrors& errors = apart.errors;
  return {{"strokes", apart.strokes},
          {"linkage_rms_deg", errors.linkage_rms_deg},
          {"linkage_max_deg", errors.linkage_max_deg},
          {"stroke_offset_mm", errors.stroke_offset_mm},
          {"actuator_rms_mm", errors.actuator_rms_mm},
          {"actuator_max_mm", errors.actuator_max_mm},
          {"actuator_end_mm", errors.actuator_end_mm},
          {"program_start_s", errors.program_start_s}};
}

// None unless something measured the stroke.
std::optional<MeasuredApart> Separate(const StrokeRunOptions& options, const actuator::StrokeSchedule& schedule,
                                      const std::vector<actuator::AngleSample>& angles) {
  if (options.stroke_log)
    return MeasuredApart{
        "log", actuator::SeparateErrorsByLog(schedule, actuator::ReadMeasuredStrokes(*options.stroke_log), angles)};
  if (options.rod.empty()) return std::nullopt;
  return MeasuredApart{"video",
                       actuator::SeparateErrorsByVideo(schedule, ReadRodFilm(*options.validate, options.rod), angles)};
}

actuator::Validation Validate(const actuator::StrokeSchedule& schedule,
                              const std::vector<actuator::AngleSample>& angles, const fs::path& folder) {
  try {
    return actuator::ValidatePrototype(schedule, angles);
  } catch (const Error& error) {
    throw Fail("{}: {}", folder.string(), error.what());
  }
}

void WarnOfValidation(const actuator::Validation& v, const actuator::StrokeSchedule& schedule, Run& run) {
  if (v.covered < 0.95) run.Warn("the video shows {:.0f} % of the program", 100 * v.covered);
  if (std::abs(v.offset_deg) > 1 && v.rms_with_offset_deg < 0.5 * v.rms_deg)
    run.Warn("a constant {:+.2f}° explains most of the difference: a marker or a link off its place?", v.offset_deg);
  if (std::isnan(v.speed_mm_s)) return;
  const double planned = (schedule.knots[1].stroke_mm - schedule.knots[0].stroke_mm) / schedule.Duration();
  if (std::abs(v.speed_mm_s - planned) > std::max(0.01 * std::abs(planned), 3 * v.speed_se_mm_s))
    run.Warn("the prototype moved at {} mm/s, not at {:.3f}", PlusMinusText(v.speed_mm_s, v.speed_se_mm_s, 3), planned);
}

// The program as the motor can run it, and what is known of the motor.
struct StrokePlan {
  actuator::StrokeSchedule schedule;
  std::optional<actuator::DutyTable> table;
  actuator::CrawlSummary crawl;
};

StrokePlan MakePlan(const StrokeRunOptions& options, const linkage::Design& design, Run& run) {
  actuator::ScheduleOptions how = options.schedule;
  TakeMotion(options, design, how, run);
  StrokePlan plan;
  plan.schedule = actuator::MakeSchedule(design, how);
  if (options.duty_table) {
    plan.table = actuator::ReadDutyTable(*options.duty_table);
    actuator::CheckSpeeds(plan.schedule, *plan.table);
    plan.crawl = actuator::StepInsteadOfCrawling(plan.schedule, *plan.table, how.dead_time_s);
  }
  if (how.max_acceleration_mm_s2)
    actuator::LimitAcceleration(plan.schedule, *how.max_acceleration_mm_s2, how.dead_time_s);
  return plan;
}

// None without a duty table.
std::optional<SketchFiles> MakeSketch(const StrokeRunOptions& options, const StrokePlan& plan) {
  if (!plan.table) return std::nullopt;
  actuator::FirmwareOptions firmware = options.firmware;
  firmware.dead_time_s = options.schedule.dead_time_s;
  firmware.design_hash = Sha256OfFile(options.design).substr(0, 12);
  const actuator::Sketch sketch(plan.schedule, *plan.table, firmware);
  const std::string made_by =
      MadeBy(fmt::format("{} and {}", options.design.filename().string(), options.duty_table->filename().string()));
  return SketchFiles{
      .sketch = sketch,
      .drift = actuator::ForecastDrift(sketch),
      .header = actuator::StrokeTableHeader(sketch, made_by),
      .notes = actuator::SketchNotes(sketch, made_by),
      .commissioning = {{kSchematic, actuator::SchematicSvg(firmware)}, {kSignOff, actuator::SignOffSheet(sketch)}}};
}

Json WriteValidation(const StrokeRunOptions& options, const actuator::StrokeSchedule& schedule,
                     const actuator::Validation& validation, Run& run) {
  WarnOfValidation(validation, schedule, run);
  actuator::WriteValidationCsv(run.Result("validation.csv"), validation);
  DrawPngAndSvg("validation", run, figure::DrawValidation, schedule, validation);
  return ValidationJson(validation, options.tolerance_deg);
}

std::string ReportOf(const actuator::StrokeSchedule& schedule, const std::vector<actuator::ScheduleRow>& rows) {
  const auto pose = [](const actuator::ScheduleRow& row) {
    return fmt::format("{:.3f} mm ({:.2f}°)", row.stroke_mm, row.knee_deg);
  };
  return fmt::format(
      "{} to {} in {:.3f} s, at most {:.3f} mm/s and {:.1f} °/s of the knee; {} {}\n"
      "soft limits {:.3f} and {:.3f} mm\n",
      pose(rows.front()), pose(rows.back()), schedule.Duration(), FastestStroke(rows), FastestKnee(rows),
      schedule.reversals, schedule.reversals == 1 ? "reversal" : "reversals", schedule.limits.lower_mm,
      schedule.limits.upper_mm);
}

// Empty where it never rests instead.
std::string ReportOf(const actuator::CrawlSummary& crawl) {
  if (crawl.stretches == 0) return "";
  return fmt::format(
      "slower than anything in the duty table for {:.2f} s: rests and steps instead, at most {:.3f} mm ({:.2f}°) "
      "behind the program\n",
      crawl.duration_s, crawl.stroke_error_mm, crawl.knee_error_deg);
}

std::string ReportOf(const SketchFiles& made) {
  const actuator::DriftForecast& drift = made.drift;
  const actuator::Sketch& sketch = made.sketch;
  std::string text =
      fmt::format("firmware: {} segments, plan within {:.4f} mm, {:.3f} mm with the rounding of the PWM\n",
                  sketch.stroke.segments.size(), sketch.stroke.rounding_error_mm, sketch.stroke.pwm_error_mm);
  text += fmt::format(
      "drift: with speeds within {} % of the duty table{} {:.3f} ± {:.3f} mm at most, the linkage ends at {:.3f} mm\n",
      SignificantText(drift.tolerance_percent, 3), drift.is_measured ? "" : " (not measured)", drift.planned_mm,
      drift.drift_mm, drift.end_mm);
  text += fmt::format("home: put the retract end stop at {:.3f} mm\n", sketch.HomeStroke());
  if (const std::optional<double> stop_mm = sketch.ExtendStop())
    text += fmt::format("extend end stop: put it at {:.3f} mm; it catches the drift\n", *stop_mm);
  if (sketch.options.accept_drift) text += "DRIFT ACCEPTED: only for a bench without a person\n";
  return text + actuator::kUntried + "\n";
}

std::string ReportOf(const actuator::Validation& v, double tolerance_deg) {
  std::string text = fmt::format("prototype: RMS {:.3f}°, largest {:.3f}°, program begins at {:.3f} s", v.rms_deg,
                                 v.max_deg, v.shift_s);
  if (!std::isnan(v.speed_mm_s))
    text += fmt::format(", its own speed {} mm/s", PlusMinusText(v.speed_mm_s, v.speed_se_mm_s, 3));
  return text +
         fmt::format(
             "\nverdict: it {} (within {}° RMS); from {:.3f} s on it travels {:.4f} of the program, drift at its "
             "end {:+.2f} mm, then RMS {:.3f}°\n",
             VerdictText(actuator::Judge(v, tolerance_deg)), tolerance_deg, v.start_with_factor_s, v.travel_factor,
             v.drift_mm, v.rms_with_factor_deg);
}

std::string ReportOf(const MeasuredApart& apart) {
  const actuator::SeparatedErrors& errors = apart.errors;
  return fmt::format(
      "apart, by the {}'s strokes: linkage RMS {:.3f}° (largest {:.3f}°), actuator RMS {:.3f} mm (largest {:.3f}, at "
      "the end {:+.3f})\n",
      apart.strokes, errors.linkage_rms_deg, errors.linkage_max_deg, errors.actuator_rms_mm, errors.actuator_max_mm,
      errors.actuator_end_mm);
}

std::string InSketch(const std::string& name) {
  return std::string(actuator::kSketchFolder) + "/" + name;
}

std::vector<std::string> ResultNames(bool has_sketch, bool has_validation) {
  std::vector<std::string> names = {"summary.json", "program.csv", "program.png", "program.svg"};
  if (has_sketch) {
    names.insert(names.end(), {"stroke_table.h", InSketch("stroke_table.h"), InSketch(kSchematic), InSketch(kSignOff)});
    for (const actuator::FirmwareFile& file : actuator::FirmwareSources()) names.push_back(InSketch(file.name));
  }
  if (has_validation) names.insert(names.end(), {"validation.csv", "validation.png", "validation.svg"});
  return names;
}

}  // namespace

Json WriteSketch(actuator::Feedback feedback, const std::string& stroke_table, const std::string& notes, Run& run,
                 const std::vector<actuator::FirmwareFile>& further) {
  const auto place = [&](const std::string& name) { return run.Result(InSketch(name)); };
  WriteTextFile(place("stroke_table.h"), stroke_table);
  WriteTextFile(run.Result("stroke_table.h"), stroke_table);  // where the interfaces have it
  Json files = {"stroke_table.h", InSketch("stroke_table.h")};
  for (const actuator::FirmwareFile& file : actuator::SketchSources(feedback)) {
    const bool has_notes = file.name == actuator::kNotesFile;
    WriteTextFile(place(file.name), has_notes ? notes + file.text : file.text);
    files.push_back(InSketch(file.name));
  }
  for (const actuator::FirmwareFile& file : further) {
    WriteTextFile(place(file.name), file.text);
    files.push_back(InSketch(file.name));
  }
  return files;
}

std::vector<InputFile> InputsOf(const StrokeRunOptions& options) {
  std::vector<InputFile> inputs = {{options.design, "design"}};
  if (options.duty_table) inputs.push_back({*options.duty_table, "duty table"});
  if (options.motion) inputs.push_back({*options.motion / "kinematics.csv", "motion"});
  if (options.validate) inputs.push_back({*options.validate / "kinematics.csv", "prototype"});
  if (options.stroke_log) inputs.push_back({*options.stroke_log, "stroke log"});
  if (options.validate && !options.rod.empty()) inputs.push_back({*options.validate / "trajectory.csv", "film"});
  return inputs;
}

Json RunStroke(const StrokeRunOptions& options, Run& run) {
  if (!(options.tolerance_deg > 0 && options.tolerance_deg <= 90))
    throw UsageError("--tolerance must be above 0 and at most 90 degrees, not {}", options.tolerance_deg);
  if (!options.validate && (options.stroke_log || !options.rod.empty()))
    throw UsageError("--stroke-log and --rod-markers belong to --validate TRACKDIR");
  if (options.stroke_log && !options.rod.empty())
    throw UsageError("--stroke-log and --rod-markers both measure the stroke: give one");
  const linkage::Design design = linkage::ReadDesign(options.design);
  run.AddInputs(InputsOf(options));
  const StrokePlan plan = MakePlan(options, design, run);
  const std::optional<SketchFiles> sketch = MakeSketch(options, plan);
  std::vector<actuator::AngleSample> angles;
  if (options.validate) angles = KneeAngles(*options.validate);
  run.Begin(ResultNames(sketch.has_value(), options.validate.has_value()));
  const std::vector<actuator::ScheduleRow> rows =
      actuator::SampleSchedule(plan.schedule, options.rate_hz, plan.table ? &*plan.table : nullptr);
  std::optional<actuator::Validation> validation;
  if (options.validate) validation = Validate(plan.schedule, angles, *options.validate);
  std::optional<MeasuredApart> apart;
  if (options.validate) apart = Separate(options, plan.schedule, angles);

  if (!sketch && !validation)
    run.Warn(
        "no duty table: the duty is left empty and no firmware is written; measure one (lake-stroke calibrate) and "
        "give it with --duty-table");
  if (sketch && options.firmware.accept_drift)
    run.Warn(
        "the drift was accepted: {:.3f} ± {:.3f} mm, and the linkage ends at {:.3f} mm; only for a bench without a "
        "person",
        sketch->drift.planned_mm, sketch->drift.drift_mm, sketch->drift.end_mm);
  actuator::WriteScheduleCsv(run.Result("program.csv"), rows);
  DrawPngAndSvg("program", run, figure::DrawStrokeProgram, plan.schedule, rows);
  Json summary = ProgramJson(plan.schedule, rows);
  summary["crawling"] = CrawlJson(plan.crawl);
  summary["firmware"] = Json();
  run.Report(ReportOf(plan.schedule, rows) + ReportOf(plan.crawl));
  if (sketch) {
    const actuator::Feedback feedback = options.firmware.feedback;
    summary["firmware"] =
        FirmwareJson(WriteSketch(feedback, sketch->header, sketch->notes, run, sketch->commissioning), *sketch);
    run.Report(ReportOf(*sketch));
  }
  if (validation) {
    summary["validation"] = WriteValidation(options, plan.schedule, *validation, run);
    summary["validation"]["separated"] = apart ? SeparatedJson(*apart) : Json();
    run.Report(ReportOf(*validation, options.tolerance_deg));
    if (apart) run.Report(ReportOf(*apart));
  }
  return summary;
}

void Describe(StrokeRunOptions& o, OptionList& options) {
  options.AddOperand("design", o.design, "design.yaml, as lake-optimize writes it").Value("DESIGN");
  options.Add("duty-table", o.duty_table, "duty_table.csv of this actuator, bridge and supply; without it no firmware");
  Describe(o.schedule, options);
  options.Add("motion", o.motion, "Folder of a human trial: its seated and standing angles are the program's")
      .IsPath(Option::Path::kFolder)
      .Value("TRACKDIR");
  options.Add("rate", o.rate_hz, "Rows per second of program.csv").Unit("Hz").Positive();
  options.Add("validate", o.validate, "lake-track folder of a prototype's video to compare with the program")
      .IsPath(Option::Path::kFolder)
      .Value("TRACKDIR");
  options.Add("stroke-log", o.stroke_log,
              "With --validate: log of that run with measured strokes, to tell linkage and actuator apart");
  options.Add("rod-markers", o.rod, "Likewise: two markers of that video, on the actuator's body and on its rod")
      .Value("BODY,ROD")
      .Repeats();
  options.Add("tolerance", o.tolerance_deg, "Largest RMS at which a prototype counts as following its prediction")
      .Unit("degrees");
  Describe(o.firmware, options);
}

void Describe(DutyRunOptions& o, OptionList& options) {
  options.AddOperand("logs", o.logs, "CSV logs, or the firmware's serial output").Value("LOGS").Repeats();
  const auto set_scale = [&o](const OptionTexts& texts, const std::string& said) {
    CheckTextCount(texts, 1, said);
    o.potentiometer = actuator::ParsePotentiometerScale(texts.front());
  };
  options.AddCustom("pot", "Scale of the adc column", set_scale).Value("COUNTS=MM,COUNTS=MM");
  options.Add("video", o.video, "lake-track folder of a video of the actuator, filmed while the log was written")
      .IsPath(Option::Path::kFolder)
      .Value("TRACKDIR");
  options.Add("rod-markers", o.rod, "The two markers in --video: on the actuator's body and on its rod")
      .Value("BODY,ROD")
      .Repeats();
  Describe(o.calibrate, options);
  options.Add("write-firmware", o.write_firmware, "No logs yet: write the firmware that makes them");
  options.Add("dead-time", o.firmware.dead_time_s, "Firmware of --write-firmware: braking time before a reversal")
      .Unit("s")
      .Between(actuator::kLeastDeadTime_s, 5);
  options
      .Add("command-timeout", o.firmware.command_timeout_s,
           "Firmware of --write-firmware: stop after the host has been silent this long; 0: never")
      .Unit("s")
      .Between(0, 60);
}

}  // namespace lake::commands
