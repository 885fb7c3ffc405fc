#include "lake/commands/compare.h"

#include <algorithm>

#include "comparison_tables.h"
#include "lake/commands/gait.h"
#include "lake/compare/comparison_file.h"
#include "lake/compare/misalignment_options.h"
#include "lake/core/error.h"
#include "lake/core/shell_word.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "lake/exchange/ground_forces.h"
#include "lake/figure/charts.h"
#include "lake/gait/learnt_knee.h"
#include "lake/gait/leg_fit.h"
#include "lake/gait/persons_leg.h"
#include "lake/gait/plausibility.h"
#include "lake/gait/sit_to_stand.h"
#include "lake/motion/saved_corrections.h"
#include "lake/report/misalignment_sections.h"
#include "lake/report/report.h"
#include "lake/tracking/naming.h"
#include "lake/tracking/recording_verdicts.h"
#include "optimum_tables.h"
#include "png_and_svg.h"
#include "second_trial.h"

namespace lake::commands {
namespace {

namespace fs = std::filesystem;

constexpr const char* kKnee = "knee";
constexpr const char* kExoKnee = "exo_knee";

bool IsTracked(const fs::path& path) {
  return FindResult(path, "kinematics.csv") && FindResult(path, "events.csv");
}

// Of markers that no fit has taken in.
void PutAtDepths(const gait::MarkerDepths& depths, compare::TrialTables& tables) {
  for (const std::string_view of_leg : tracking::kLegMarkers)
    if (depths.contains(std::string(of_leg)))
      throw UsageError("--depth {}: is of the leg, which {} has fitted without: give it to lake track", of_leg,
                       tables.name);
  gait::PutAtDepths(depths, tables.sight, tables.trajectory);
}

compare::TrialTables ReadTracked(const fs::path& folder, const gait::MarkerDepths& depths, Run& run) {
  if (const std::string unapplied = motion::UnappliedCorrections(folder); !unapplied.empty()) run.Warn(unapplied);
  compare::TrialTables tables;
  tables.name = folder.string();
  // The estimates of the fit that kinematics.csv is of, which started from the measurements.
  tables.trajectory = motion::ReadMarkerCsv(exchange::TableOfFolder(folder), motion::MarkerValues::kEstimated);
  tables.motion = motion::ReadKinematicsCsv(folder / "kinematics.csv");
  tables.events = motion::ReadEventsCsv(folder / "events.csv");
  if (const auto summary = FindResult(folder, "summary.json"))
    tables.sight = gait::PlaneSightIn(ReadJsonFile(*summary), summary->string());
  PutAtDepths(depths, tables);
  if (const auto rises = FindResult(folder, "sit_to_stand.csv")) gait::ReadEventDeviations(*rises, tables.events);
  gait::LegFitOptions said;
  said.said_facing = "the direction in which the subject was said to face";
  said.unit_question = [](const std::string& unit) {
    return fmt::format("was the scale of its recording given {}?", unit.empty() ? "in mm" : "in " + unit);
  };
  gait::LegPath path = gait::PathOf(tables.motion);
  path.is_facing_given = true;
  try {
    gait::CheckPersonsLeg(path, tables.events, said);
    gait::CheckPlausible(tables.motion, tables.trajectory);
  } catch (const Error& error) {
    throw Fail("{}: {}", folder.string(), error.what());
  }
  return tables;
}

// A folder's markers have their names already.
exchange::TrialOptions FolderReading(const exchange::TrialOptions& reading) {
  exchange::TrialOptions folder;
  folder.values = reading.values;
  return folder;
}

exchange::TrialOptions ReadingOf(const fs::path& path, const exchange::TrialOptions& reading) {
  return fs::is_directory(path) ? FolderReading(reading) : reading;
}

exchange::Trial ReadMarkers(const fs::path& path, const exchange::TrialOptions& reading,
                            const gait::PictureScale& picture) {
  gait::PictureScale depths;  // of a recording in mm; one in px is fitted with its picture
  depths.depths = picture.depths;
  return ReadTrialFor(path, ReadingOf(path, reading), depths);
}

// The leg's knee where `knee` is compared.
std::string LegKneeOf(const exchange::Trial& trial, const std::string& knee) {
  return trial.recording.Find(kKnee) ? kKnee : knee;
}

compare::TrialTables FitTables(const fs::path& path, const exchange::Trial& trial, const std::string& leg_knee,
                               Run& run, const gait::PictureScale& picture, gait::LegFitOptions fit) {
  fit.facing_option = "--forward";
  fit.markers.knee = leg_knee;
  const gait::LegFitResult result = FitTrial(trial, fit, run, picture);
  return {.name = path.string(),
          .trajectory = result.trajectory,
          .motion = result.motion,
          .events = result.events,
          .sight = result.sight};
}

// The marker of the exoskeleton's knee, known only once the trial's markers are.
std::string FindExoKnee(const motion::MarkerRecording& recording, const CompareRunOptions& options) {
  if (options.exo_knee) return *options.exo_knee;
  return recording.Find(kExoKnee) || !options.knee.exo_segments.shank.empty() ? kExoKnee : kKnee;
}

std::string ExoKneeOf(const CompareRunOptions& options) {
  if (options.exo_knee || IsTracked(options.exo)) return options.exo_knee.value_or(kExoKnee);
  return FindExoKnee(exchange::ReadTrial(options.exo, ReadingOf(options.exo, options.exo_reading)).recording, options);
}

// A folder that lake-compare wrote, or the predicted path of lake-optimize: its curves are registered already.
bool IsCompared(const fs::path& path) {
  return FindResult(path, "comparison.json").has_value();
}

void CheckUnits(const compare::TrialTables& human, const compare::TrialTables& exo) {
  if (human.trajectory.unit != exo.trajectory.unit)
    throw Fail("{} is in {} and {} in {}: give the one in px a scale: {} with a plane, or {}", human.name,
               ToString(human.trajectory.unit), exo.name, ToString(exo.trajectory.unit),
               human.trajectory.unit == motion::LengthUnit::kPx ? "--camera" : "--exo-camera",
               human.trajectory.unit == motion::LengthUnit::kPx ? "--scale" : "--exo-scale");
}

compare::RegisteredTrial RegisterExo(const compare::TrialTables& tables, const std::string& joint,
                                     const CompareRunOptions& options) {
  compare::RegistrationOptions registration;
  registration.knee = joint;
  registration.marker_at_mm = {options.joint_at_mm[0], options.joint_at_mm[1]};
  if (!options.IsMarkerOnAxis() && (joint == kKnee || !tables.trajectory.Find(kKnee)))
    throw UsageError(
        "--joint-at: {} has no marker of the joint beside the leg's own knee, by which the shank's direction is known",
        tables.name);
  return compare::RegisterTrial(tables, registration);
}

// Both trials at 0..100 %, and the marker that is the exoskeleton's knee.
struct RegisteredPair {
  compare::RegisteredTrial human, exo;
  std::string exo_knee;
  bool is_human_functional = false;  // by this comparison or by the one that the curve is of
  compare::KneeAxes axes;
  double knee_hidden_share = 1;  // of the exoskeleton trial's frames
};

// One trial's part of an earlier comparison.
compare::ComparedCurves ReadCompared(const fs::path& comparison, Run& run) {
  compare::ComparedCurves curves = compare::ReadComparison(comparison);
  if (curves.knee_is_functional && !curves.axes.human_mm)
    run.Warn(
        "{} does not say how precise its functional knee is: the budget has a marker's placement for it; compare its "
        "trials again",
        comparison.string());
  return curves;
}

// A trial with the exoskeleton's marker stands second, unless --exo-knee says which marker of the second is compared.
void CheckOrder(const compare::TrialTables& human, const compare::TrialTables& exo, const CompareRunOptions& options) {
  if (options.exo_knee || !human.trajectory.Find(kExoKnee) || exo.trajectory.Find(kExoKnee)) return;
  throw UsageError(
      "{} has a marker {} and {} has none: the trials are exchanged, and the one without exoskeleton goes first: {}; "
      "if they are as meant, name the compared marker with --exo-knee",
      human.name, kExoKnee, exo.name, CommandLine({"lake", "compare", options.exo.string(), options.human.string()}));
}

void CheckMovements(gait::MovementKind human, gait::MovementKind exo, const CompareRunOptions& options, Run& run) {
  if (human != exo)
    throw Fail("{} is of {} and {} of {}: two trials of one movement can be compared", options.human.string(),
               gait::MovementOf(human).name, options.exo.string(), gait::MovementOf(exo).name);
  if (human == gait::MovementKind::kWalking && options.worn)
    run.Warn("--worn applies to sit-to-stands only and is left out: {} is a walk", options.human.string());
}

double KneeHiddenShare(const motion::MarkerRecording& recording) {
  const motion::MarkerTrack* knee = recording.Find(kKnee);
  if (!knee || knee->samples.empty()) return 1;
  const auto seen = std::ranges::count(knee->samples, motion::SampleStatus::kDetected, &motion::MarkerSample::status);
  return 1 - static_cast<double>(seen) / static_cast<double>(knee->samples.size());
}

RegisteredPair ReadPair(const CompareRunOptions& options, Run& run) {
  std::optional<FunctionalTables> human, exo;
  if (!IsCompared(options.human))
    human = ReadFunctionalTables(options.human, options.human_reading, options.human_knee, TrialSide::kHuman,
                                 options.knee, run, options.human_picture);
  if (!IsCompared(options.exo))
    exo = ReadFunctionalTables(options.exo, options.exo_reading, ExoKneeOf(options), TrialSide::kExo, options.knee, run,
                               options.exo_picture);
  std::optional<compare::ComparedCurves> human_curves, exo_curves;
  if (!human) human_curves = ReadCompared(options.human, run);
  if (!exo) exo_curves = ReadCompared(options.exo, run);
  RegisteredPair pair;
  pair.axes.human_mm = human ? human->sd_mm : human_curves->axes.human_mm;
  pair.axes.exo_mm = exo ? exo->sd_mm : exo_curves->axes.exo_mm;
  if (options.knee.knee == KneeFrom::kFunctional && !pair.axes.human_mm && !pair.axes.exo_mm)
    throw UsageError("--knee functional: no trial has markers of --segment on shank and thigh");
  for (const auto& [marker, depth] : options.exo_picture.depths)
    if (!(human && human->tables.trajectory.Find(marker)) && !(exo && exo->tables.trajectory.Find(marker)))
      throw UsageError("--depth {}: no trial whose markers are read has it", marker);
  if (human && exo) CheckUnits(human->tables, exo->tables);
  if (human && exo) CheckOrder(human->tables, exo->tables, options);
  if (exo) pair.knee_hidden_share = KneeHiddenShare(exo->tables.trajectory);
  pair.exo_knee = exo ? FindExoKnee(exo->tables.trajectory, options) : options.exo_knee.value_or(kExoKnee);
  if (human) {
    compare::RegistrationOptions registration;
    registration.knee = options.human_knee;
    pair.human = compare::RegisterTrial(human->tables, registration);
    pair.is_human_functional = pair.axes.human_mm.has_value();
  } else {
    pair.human.repetitions = {human_curves->human};
    pair.human.movement = human_curves->movement;
    pair.is_human_functional = human_curves->knee_is_functional;
  }
  if (exo)
    pair.exo = RegisterExo(exo->tables, pair.exo_knee, options);
  else
    pair.exo = {.repetitions = {exo_curves->exo},
                .warnings = {},
                .movement = exo_curves->movement,
                .sight = exo_curves->exo_sight};
  CheckMovements(pair.human.movement, pair.exo.movement, options, run);
  return pair;
}

// Precision of the markers and accuracy with respect to the joint, apart.
report::Section UncertaintySection(const std::vector<compare::Budget>& budgets) {
  report::Table headlines{.caption = "95 % intervals"};
  headlines.columns = {{"quantity"}, {"value"}, {"of all sources"}, {"of the markers alone"}};
  report::Table sources{.caption = "Uncertainty budget (GUM): standard deviations"};
  sources.columns = {{"quantity"}, {"source"}, {"size"}, {"contribution"}, {"share of the variance"}, {"from"}};
  report::Section section{"Uncertainty", {}};
  for (const compare::Budget& budget : budgets) {
    const std::string name = compare::QuantityName(budget.quantity);
    const compare::Interval all = budget.AnatomicalInterval();
    const auto rounded = [&](double value) { return KnownText(value, (all.high - all.low) / 2, 1); };
    const auto text = [&](const compare::Interval& interval) {
      return fmt::format("{} to {} {}", rounded(interval.low), rounded(interval.high), budget.unit);
    };
    headlines.rows.push_back(
        {name, fmt::format("{} {}", rounded(budget.value), budget.unit), text(all), text(budget.MarkerInterval())});
    for (const compare::BudgetRow& row : budget.rows)
      sources.rows.push_back({name, row.source, fmt::format("{} {}", SignificantText(row.size, 2), row.unit),
                              fmt::format("{} {}", SignificantText(row.Contribution(), 2), budget.unit),
                              fmt::format("{:.1f} %", budget.SharePercent(row)), row.reference});
  }
  section.blocks = {
      report::Paragraph{
          "The markers can be measured precisely and still lie some millimetres beside the joint beneath the skin. " +
          compare::WhatNarrows(budgets.front())},
      headlines, sources};
  return section;
}

// The worn linkage on the person whom the human trial shows.
WornJoint CheckWorn(const compare::Misalignment& misalignment, const CompareRunOptions& options) {
  person::BodySize size = options.body;
  std::vector<double> thigh_mm;
  thigh_mm.reserve(misalignment.human.knee.size());
  for (std::size_t i = 0; i < misalignment.human.knee.size(); ++i)
    thigh_mm.push_back((misalignment.human.hip[i] - misalignment.human.knee[i]).norm());
  size.leg = person::LegLengths{Mean(thigh_mm), Mean(misalignment.shank_mm)};
  return CheckWornJoint(linkage::ReadDesign(*options.worn), misalignment.joint->mean_mm, person::BodyOf(size),
                        options.wear);
}

// What seat and limbs allow of moving the joint: null where the worn links are not known, and in words; of walking
// nothing.
void CheckMove(const compare::Misalignment& misalignment, const CompareRunOptions& options, Json& best_placement) {
  best_placement["on_body"] = nullptr;
  if (misalignment.movement == gait::MovementKind::kWalking) return;
  if (!options.worn) {
    best_placement["body_text"] =
        "What seat and limbs allow of it is not known without the design that was worn (--worn, in a study design: "
        "worn).";
    return;
  }
  const WornJoint joint = CheckWorn(misalignment, options);
  best_placement["on_body"] = WornJointJson(joint);
  best_placement["body_text"] = WornJointText(joint, misalignment.joint->remainder_mm);
}

void DrawFigures(const Json& comparison, Run& run) {
  std::vector<report::LineChart> courses = {report::PathDifferenceChart(comparison), report::PartsChart(comparison),
                                            report::KneeAnglesChart(comparison)};
  if (auto joint = report::JointChart(comparison)) courses.push_back(*std::move(joint));
  DrawTogether({{"overlay",
                 [&](const fs::path& path) {
                   figure::DrawCharts(path, {report::LegsChart(comparison), report::KneePathsChart(comparison)}, 2);
                 }},
                {"misalignment", [&](const fs::path& path) { figure::DrawCharts(path, courses, 2); }}},
               run);
}

void WriteComparisonReport(const std::string& title, const Json& comparison, std::vector<report::Section> more,
                           Run& run) {
  report::Report report{.title = "Misalignment of human and exoskeleton knee",
                        .subtitle = title,
                        .warnings = run.Warnings(),
                        .sections = report::MisalignmentSections(comparison)};
  for (report::Section& section : more) report.sections.push_back(std::move(section));
  report.sections.push_back(
      {"Output files",
       {report::Files{{{"misalignment.csv", "the curves, a row per percent"},
                       {"uncertainty_budget.csv", "what each figure is uncertain by, source by source"},
                       {"comparison.json", "all values and curves, as lake-optimize reads them"},
                       {"overlay.svg", "knee paths and legs, a figure for print"},
                       {"misalignment.svg", "path difference, parts and angles over the repetition, for print"}}}}});
  report.sections.push_back(report::ProvenanceSection(run.Head()));
  report::WriteReport(run.Result("report.html"), report);
}

// The scale of a picture where no picture is measured in.
std::vector<exchange::UnusedOption> UnusedPicture(const fs::path& path, const exchange::TrialOptions& reading,
                                                  const gait::PictureScale& picture) {
  if (!picture.IsGiven()) return {};
  if (IsCompared(path)) return {{picture.OptionName(), "its curves have their scale already"}};
  if (exchange::ReadTrial(path, ReadingOf(path, reading)).recording.unit == motion::LengthUnit::kPx) return {};
  return {{picture.OptionName(), "its lengths are in mm"}};
}

// What reading one of the trials passes over of what its options say.
std::vector<exchange::UnusedOption> UnusedReading(const fs::path& path, const exchange::TrialOptions& reading,
                                                  const gait::PictureScale& picture) {
  const bool is_fitted = !IsCompared(path) && (!IsTracked(path) || picture.IsGiven());
  std::vector<exchange::UnusedOption> unused = UnusedPicture(path, reading, picture);
  if (is_fitted && !fs::is_directory(path)) {
    for (const exchange::UnusedOption& one : exchange::UnusedOptions(path, reading)) unused.push_back(one);
    return unused;
  }
  const char* why = "its markers have names, axes and units already";
  if (!reading.names.empty()) unused.push_back({"--map", why});
  if (reading.up) unused.push_back({"--up", why});
  if (!reading.forward.empty()) unused.push_back({"--forward", why});
  if (reading.mm_per_unit != 1) unused.push_back({"--unit", why});
  if (!reading.view.empty()) unused.push_back({"--view", why});
  if (!is_fitted && reading.values == motion::MarkerValues::kEstimated)
    unused.push_back({"--smoothed", "its curves are those of a fit already"});
  return unused;
}

bool Has(const std::vector<exchange::UnusedOption>& unused, const std::string& option) {
  return std::ranges::any_of(unused, [&](const exchange::UnusedOption& one) { return one.option == option; });
}

// An option that holds for both trials is of use if it is for one of them.
void CheckReadings(const CompareRunOptions& o) {
  const auto human = UnusedReading(o.human, o.human_reading, o.human_picture),
             exo = UnusedReading(o.exo, o.exo_reading, o.exo_picture);
  const auto is_of_one = [&](const std::string& option) {
    const bool is_of_picture = option == o.human_picture.OptionName() || option == o.exo_picture.OptionName();
    return (option == "--map" && o.exo_reading.names != o.human_reading.names) ||
           (option == "--unit" && o.exo_reading.mm_per_unit != o.human_reading.mm_per_unit) ||
           (is_of_picture && o.exo_picture != o.human_picture);
  };
  for (const auto& [option, why] : human)
    if (is_of_one(option) || Has(exo, option)) exchange::CheckNoneIsUnused(o.human, {{option, why}});
  for (const auto& [option, why] : exo)
    if (is_of_one(option)) exchange::CheckNoneIsUnused(o.exo, {{"--exo-" + option.substr(2), why}});
}

// Another joint of the leg is known by its name alone.
void CheckIsAKnee(const std::string& option, const std::string& marker) {
  for (const char* other : {"ankle", "hip", "waist", "shoulder", "heel", "toe"})
    if (marker == other)
      throw UsageError("{} {}: is the leg's {}, and knees are compared; name the marker at the knee", option, marker,
                       other);
}

// Two trials of one kind.
void CheckTrials(const CompareRunOptions& o) {
  CheckIsAKnee("--human-knee", o.human_knee);
  if (o.exo_knee) CheckIsAKnee("--exo-knee", *o.exo_knee);
  if (!o.IsMarkerOnAxis() && IsCompared(o.exo))
    throw UsageError("--joint-at needs an exoskeleton trial with a joint marker");
  if (!o.IsMarkerOnAxis() && !o.knee.exo_segments.shank.empty())
    throw UsageError("--joint-at and --exo-segment exclude each other: --exo-segment finds the axis itself");
  if (o.knee.trial && (IsCompared(o.exo) || IsTracked(o.exo) || o.knee.knee == KneeFrom::kFunctional))
    throw UsageError(
        "--knee-from only applies where EXO is a file of markers, with --knee marker; a folder of lake track or lake "
        "gait has its rebuilt knee from their own --knee-from");
}

}  // namespace

void CheckReading(const fs::path& path, const exchange::TrialOptions& reading, const gait::PictureScale& picture) {
  exchange::CheckNoneIsUnused(path, UnusedReading(path, reading, picture));
}

compare::TrialTables ReadTrialTables(const fs::path& path, const exchange::TrialOptions& reading,
                                     const std::string& knee, Run& run, const gait::PictureScale& picture,
                                     const gait::LegFitOptions& given) {
  const auto tracked = [&] {
    compare::TrialTables tables = ReadTracked(path, picture.depths, run);
    if (given.movement.kind != gait::MovementKind::kAuto && given.movement.kind != compare::MovementIn(tables))
      throw Fail("{}: its events are not of {}: run lake-gait on it with --movement {}", path.string(),
                 gait::MovementOf(given.movement.kind).name, gait::MovementOf(given.movement.kind).name);
    return tables;
  };
  if (!picture.IsGiven() && IsTracked(path)) return tracked();
  const exchange::Trial trial = ReadMarkers(path, reading, picture);
  if (trial.recording.unit == motion::LengthUnit::kMm && IsTracked(path)) return tracked();
  return FitTables(path, trial, given.knee_trial ? kKnee : LegKneeOf(trial, knee), run, picture, given);
}

FunctionalTables ReadFunctionalTables(const fs::path& path, const exchange::TrialOptions& reading,
                                      const std::string& knee, TrialSide side, const KneeOptions& options, Run& run,
                                      const gait::PictureScale& picture) {
  gait::LegFitOptions given;
  given.movement = options.movement;
  if (options.knee == KneeFrom::kMarker) {
    if (side == TrialSide::kExo) given.knee_trial = options.trial;
    return {ReadTrialTables(path, reading, knee, run, picture, given), {}};
  }
  exchange::Trial trial = ReadMarkers(path, reading, picture);
  const auto put = [&](const axis::SegmentMarkers& segments, const std::string& marker) {
    return PutAxis(segments, marker, fs::is_directory(path) ? FolderReading(reading) : reading, trial, run);
  };
  if (side == TrialSide::kHuman) {
    const std::optional<double> sd_mm = put(options.segments, knee);
    return {FitTables(path, trial, sd_mm ? knee : LegKneeOf(trial, knee), run, picture, given), sd_mm};
  }
  const bool has_joint = knee != kKnee && trial.recording.Find(knee);
  const bool is_joint_put = !options.exo_segments.shank.empty() && put(options.exo_segments, knee);
  if (!has_joint && !is_joint_put)
    throw UsageError(
        "--knee functional: {} shows no joint of the exoskeleton beside the knee: name its marker with --exo-knee, or "
        "markers on the exoskeleton's parts, --exo-segment shank=A,B --exo-segment thigh=C,D",
        path.string());
  std::optional<double> sd_mm;
  if (knee != kKnee) sd_mm = put(options.segments, kKnee);  // else the joint has the place of the person's knee
  return {FitTables(path, trial, LegKneeOf(trial, knee), run, picture, given), sd_mm};
}

std::vector<InputFile> TrialTableInputs(const fs::path& path, const std::string& role) {
  if (IsCompared(path)) return {{path / "comparison.json", role}};
  std::vector<InputFile> inputs = TrialInputs(path, role);
  if (IsTrialFolder(path)) inputs.push_back({path / "kinematics.csv", role + " motion"});
  return inputs;
}

std::vector<InputFile> InputsOf(const CompareRunOptions& options) {
  std::vector<InputFile> inputs = TrialTableInputs(options.human, "human");
  for (InputFile& input : TrialTableInputs(options.exo, "exo")) inputs.push_back(std::move(input));
  if (const auto& camera = options.human_picture.camera) inputs.push_back({*camera, "human camera"});
  if (const auto& camera = options.exo_picture.camera) inputs.push_back({*camera, "exo camera"});
  if (options.knee.trial) inputs.push_back({gait::LearntKneeFile(*options.knee.trial), "knee from"});
  if (options.worn) inputs.push_back({*options.worn, "worn"});
  return inputs;
}

Json RunCompare(const CompareRunOptions& options, Run& run) {
  CheckTrials(options);
  CheckReadings(options);
  const RegisteredPair pair = ReadPair(options, run);
  run.AddInputs(InputsOf(options));
  const std::string& exo_knee = pair.exo_knee;
  run.Begin({"summary.json", "misalignment.csv", "uncertainty_budget.csv", "cuffs.csv", "overlay.png", "overlay.svg",
             "misalignment.png", "misalignment.svg", "comparison.json", "report.html"});
  compare::MisalignmentOptions compared = options.misalignment;
  compared.event_sd_s = options.budget.event_s;
  const compare::Misalignment misalignment = compare::CompareTrials(pair.human, pair.exo, compared);
  for (const std::string& warning : misalignment.warnings) run.Warn(warning);
  if (!misalignment.joint && pair.exo_knee != kKnee)
    run.Warn("where the joint is on the leg is not known, knee hidden in {:.0f} % of the frames of {}: {}",
             100 * pair.knee_hidden_share, options.exo.string(), tracking::kHiddenKneeAdvice);
  compare::WriteMisalignmentCsv(run.Result("misalignment.csv"), misalignment);
  const std::string title = fmt::format("{} ({}) against {} ({})", options.exo.filename().string(), exo_knee,
                                        options.human.filename().string(), options.human_knee);
  Json comparison = compare::ComparisonJson(misalignment);
  comparison["markers"] = {{"human", options.human_knee}, {"exo", exo_knee}};
  comparison["joint_at_mm"] = options.joint_at_mm;
  if (const auto& sight = misalignment.exo_sight) comparison[gait::kPlaneSight] = gait::PlaneSightJson(sight->plane);
  comparison["knee_from"] = pair.is_human_functional ? "functional" : "marker";
  comparison["knee_axis_sd_mm"] = {{"human", NumberOrNull(pair.axes.human_mm)},
                                   {"exo", NumberOrNull(pair.axes.exo_mm)}};
  if (misalignment.joint) {
    CheckMove(misalignment, options, comparison["best_placement"]);
  } else if (options.worn) {
    run.Warn(
        "{} shows no knee of the leg beside the joint, so it is not checked whether seat and limbs leave room for the "
        "worn design's joint",
        options.exo.filename().string());
  }
  compare::ComparisonBudgetOptions budget = options.budget;
  budget.axes = pair.axes;
  const std::vector<compare::Budget> budgets =
      compare::BudgetsOf(misalignment, options.misalignment.replacement_sd_mm, budget);
  compare::WriteUncertaintyBudgetCsv(run.Result("uncertainty_budget.csv"), budgets);
  comparison["uncertainty"] = compare::BudgetsJson(budgets);
  std::vector<report::Section> sections{UncertaintySection(budgets)};
  std::vector<CuffCase> cases;
  // The cuffs are free of stress at standing, which a walk does not show.
  const bool is_rise = misalignment.movement == gait::MovementKind::kSitToStand;
  if (is_rise && misalignment.joint && !misalignment.exo.leg_knee.empty()) {
    cases = CuffCases(misalignment.exo, *misalignment.joint, compare::PlaceDeviation(budgets), options.cuff);
    WriteCuffTable(run.Result("cuffs.csv"), cases);
    for (const CuffCase& one : cases) comparison["cuffs"][one.name] = CuffsJson(one.course);
    sections.push_back(CuffSection(cases, options.cuff));
  }
  WriteJsonFile(run.Result("comparison.json"), comparison);
  DrawFigures(comparison, run);
  WriteComparisonReport(title, comparison, std::move(sections), run);
  run.Report(ComparisonText(comparison));
  comparison.erase("curves");
  return comparison;
}

void Describe(CompareRunOptions& o, OptionList& options) {
  options
      .AddOperand(
          "human", o.human,
          "A lake-track folder, .csv (lake, Kinovea), .trc, .c3d, .trk, .txt (Tracker), or a comparison's folder")
      .Required();
  options.AddOperand("exo", o.exo, "The trial with the exoskeleton, likewise, or lake-optimize's predicted/")
      .Required();
  options.Add("human-knee", o.human_knee, "The compared marker of the human trial");
  options.Add("exo-knee", o.exo_knee, "The compared marker of the exoskeleton trial").Otherwise("exo_knee, else knee");
  compare::DescribeJointAt(o.joint_at_mm, options);
  Describe(o.knee, options);
  gait::DescribeKneeFrom(o.knee.trial, options);
  Describe(o.misalignment, options);
  options.Add("worn", o.worn,
              "The design that was worn in EXO: whether seat and limbs allow its joint to be moved onto the knee");
  options.Add("height", o.body.height_mm, "Body height, for --worn").Unit("mm").Otherwise("by the leg");
  options.Add("mass", o.body.mass_kg, "Body mass, for --worn")
      .Unit("kg")
      .Otherwise("80 at 1800 mm, else of the same BMI");
  options
      .Add("seat-edge", o.wear.seat_edge_mm,
           "Knee to the front edge of a seat that lies under the linkage, too, for --worn; 0: half the thigh, for a "
           "linkage behind the leg")
      .Unit("mm")
      .Between(0, 5000);
  Describe(o.budget, options);
  Describe(o.cuff, options);
  Describe(o.human_reading, options);
  Describe(o.human_picture, options);
  gait::DescribeDepths(o.human_picture.depths, options);
  DescribeSecond("exo", "the exoskeleton trial", {o.human_reading, o.human_picture}, {o.exo_reading, o.exo_picture},
                 options);
  options.Check([&o](const OptionList& list) {
    for (const char* name : {"height", "mass", "seat-edge"})
      if (!o.worn && list.IsGiven(name)) throw UsageError("--{} only applies together with --worn", name);
  });
}

}  // namespace lake::commands
