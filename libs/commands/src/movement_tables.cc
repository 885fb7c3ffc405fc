#include "movement_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "lake/core/counted.h"
#include "lake/core/deviation_text.h"
#include "lake/core/error.h"
#include "lake/core/json.h"
#include "lake/core/numbers.h"
#include "lake/core/run.h"
#include "lake/core/statistics.h"
#include "lake/figure/trial_figures.h"
#include "lake/gait/gait_cycles.h"
#include "lake/gait/leg_fit.h"
#include "lake/gait/leg_report.h"
#include "lake/gait/movement.h"
#include "lake/gait/sit_to_stand.h"
#include "lake/gait/squats.h"
#include "lake/loads/loads.h"
#include "lake/report/report.h"
#include "png_and_svg.h"

namespace lake::commands {
namespace {

using gait::Measured;
using gait::SitToStand;
using namespace report;

constexpr std::size_t kMostRises = 10;  // that a table shows beside each other

// To two significant digits of the standard deviation, three decimals at most.
std::string Text(const Measured& measured) {
  constexpr int kMostDecimals = 3;
  constexpr double kLeastSd = 0.0005;  // what is left of it in these decimals
  if (!(measured.sd >= kLeastSd)) return NumberText(measured.value, kMostDecimals);
  const int decimals = std::clamp(1 - static_cast<int>(std::floor(std::log10(measured.sd))), 0, kMostDecimals);
  return fmt::format("{} ± {}", NumberText(measured.value, decimals), NumberText(measured.sd, decimals));
}

KeyFigure Figure(const char* label, const Measured& measured, const char* unit, std::string note) {
  KeyFigure figure{.label = label, .value = measured.value, .unit = unit, .note = std::move(note)};
  constexpr double kLeastSd = 0.005;  // what is left of it in two decimals
  if (measured.sd >= kLeastSd) figure.plus_minus = measured.sd;
  return figure;
}

// The five-times test, with what it is compared with: nullopt where age or sex are not known, or the source has none.
struct FiveTimes {
  const SitToStand& test;
  const gait::Person& person;

  bool IsKnown() const { return std::isfinite(test.five_times_s.value); }
  bool HasPower() const { return std::isfinite(test.power_w_kg.value); }
  std::optional<double> ReferenceSeconds() const {
    return person.age_years ? gait::FiveTimesReference_s(*person.age_years) : std::nullopt;
  }
  std::optional<double> LowPowerWattsPerKilogram() const {
    return person.sex ? gait::LowPowerWKg(*person.sex, person.age_years) : std::nullopt;
  }
  const char* People() const { return person.sex == motion::Sex::kMale ? "men" : "women"; }
};

std::string PowerNote(const FiveTimes& of) {
  if (!of.HasPower()) return "needs lengths in mm: give --camera, --scale or --plane-points";
  if (!of.person.sex) return "Alcazar et al. 2018; give --sex to compare";
  const std::optional<double> low = of.LowPowerWattsPerKilogram();
  if (!low) return "Alcazar et al. 2018; no reference for this age";
  return fmt::format("{} for older {} (below {} W/kg is low: Baltasar-Fernandez et al. 2021)",
                     of.test.power_w_kg.value < *low ? "low" : "not low", of.People(), NumberText(*low, 1));
}

std::string ReferenceNote(const FiveTimes& of) {
  if (!of.person.age_years) return "give --age to compare";
  const std::optional<double> reference_s = of.ReferenceSeconds();
  if (!reference_s) return "no reference for this age";
  return fmt::format("{} than average at this age ({} s, Bohannon 2006)",
                     of.test.five_times_s.value > *reference_s ? "worse" : "no worse", NumberText(*reference_s, 1));
}

// For the terminal.
std::string FiveTimesText(const FiveTimes& of) {
  if (!of.IsKnown()) return "";
  std::string text = fmt::format("five times in {:.2f} s, to the fifth standing", of.test.five_times_s.value);
  if (const auto reference_s = of.ReferenceSeconds())
    text += fmt::format("; more than {:.1f} s is worse than average at this age (Bohannon 2006)", *reference_s);
  if (const auto low = of.LowPowerWattsPerKilogram(); low && of.HasPower())
    text += fmt::format(
        "; mean power {:.2f} W/kg; below {:.1f} W/kg is low among older {} (Baltasar-Fernandez et al. 2021)",
        of.test.power_w_kg.value, *low, of.People());
  return text + "\n";
}

// The mean over the rises of which it is known, and the standard deviation between them.
Measured MeanOfRises(const std::vector<SitToStand>& rows, Measured SitToStand::*quantity) {
  std::vector<double> values;
  Measured last;
  for (const SitToStand& rise : rows)
    if (rise.repetition > 0 && std::isfinite((rise.*quantity).value)) values.push_back((last = rise.*quantity).value);
  if (values.size() < 2) return last;
  return {Mean(values), StandardDeviation(values)};
}

KeyFigures Headline(const std::vector<SitToStand>& rows, const gait::Person& person) {
  const FiveTimes five_times{rows.back(), person};
  const KeyFigure rise = Figure("Mean rise time", MeanOfRises(rows, &SitToStand::rise_s), "s", "onset to standing");
  if (!five_times.IsKnown())
    return {{rise, Figure("Mean power of a rise", MeanOfRises(rows, &SitToStand::power_w_kg), "W/kg",
                          "no five-times test: it needs five rises with onset and standing")}};
  return {{Figure("Five-times sit-to-stand", five_times.test.five_times_s, "s", ReferenceNote(five_times)),
           Figure("Mean power of the test", five_times.test.power_w_kg, "W/kg", PowerNote(five_times)), rise}};
}

Table RisesTable(const std::vector<SitToStand>& rows, motion::LengthUnit unit) {
  Table table{
      .caption = "Rises, ± one standard deviation: of the two knee angles of all sources, else of the markers' noise",
      .columns = {{"quantity"}}};
  const std::size_t rises = rows.size() - 1, shown = std::min(rises, kMostRises);
  for (std::size_t i = 0; i < shown; ++i) table.columns.push_back({fmt::format("rise {}", rows[i].repetition)});
  table.columns.push_back({"five times"});
  if (rises > shown) table.caption += fmt::format("; {} more are in sit_to_stand.csv", rises - shown);
  for (const gait::Field<SitToStand>& field : SitToStand::Fields()) {
    std::vector<Cell> row = {fmt::format("{} ({})", field.meaning, field.Unit(unit))};
    for (std::size_t i = 0; i < shown; ++i) row.push_back(Text(rows[i].*field.value));
    row.push_back(Text(rows.back().*field.value));
    table.rows.push_back(std::move(row));
  }
  return table;
}

LineChart AnglesChart(const motion::LegMotion& leg, const std::vector<SitToStand>& rows) {
  Series knee{.name = "knee"}, hip{.name = "hip", .mark = Mark::kDashed}, trunk{.name = "trunk", .mark = Mark::kDotted};
  for (std::size_t i = 0; i < leg.samples.size(); i += ChartStep(leg.samples.size())) {
    const motion::LegSample& sample = leg.samples[i];
    for (Series* series : {&knee, &hip, &trunk}) series->x.push_back(leg.time_s[i]);
    knee.y.push_back(sample.knee_deg);
    hip.y.push_back(sample.trunk_deg - sample.thigh_deg);
    trunk.y.push_back(sample.trunk_deg);
  }
  LineChart chart{.title = "Flexion of knee and hip, lean of the trunk",
                  .caption = "Shaded: from onset to standing. Lines: seat-off.",
                  .x = {.label = "time (s)"},
                  .y = {.label = "angle (°)"},
                  .series = {std::move(knee), std::move(hip), std::move(trunk)}};
  for (const SitToStand& rise : rows) {
    if (rise.repetition == 0) continue;
    if (std::isfinite(rise.rise_s.value))
      chart.intervals.push_back({rise.onset_s.value, rise.standing_s.value, fmt::format("rise {}", rise.repetition)});
    if (std::isfinite(rise.seat_off_s.value)) chart.lines.push_back({rise.seat_off_s.value, "seat-off"});
  }
  return chart;
}

Section SitToStandMethod() {
  constexpr const char* kPhases =
      "Phases after Schenkman et al. 1990, doi:10.1093/ptj/70.10.638; steady is who turns hip and knee, and moves "
      "the hip up or down, at less than 5 % of the rise's peak speeds for half a second, a limit of our own; "
      "without a waist marker the hip's angle is unknown, and stabilisation is left empty. Of a rise, the "
      "standard deviations are those of markers and events; skin movement is in those of the events' times and of the "
      "knee's angle (in mm: all sources of uncertainty_budget.csv), and not in the others.";
  constexpr const char* kFiveTimes =
      "Five-times test: from the first onset to the fifth standing; values are the means of five rises, standard "
      "deviations those between them. A test timed by hand begins at the word, and is longer by the reaction.";
  constexpr const char* kPower =
      "Power: 0.9 g × rise of the hip / time of the rise (Alcazar et al. 2018, doi:10.1016/j.exger.2018.08.006). Of "
      "the five-times test the time is a ninth of the test's, which holds five rises and four lowerings; a test that "
      "is timed to the fifth sitting holds ten of them.";
  constexpr const char* kCentreOfMass =
      "Centre of mass: of the whole body, both legs moving as the one that is seen, with the segments' masses of "
      "Winter 2009, doi:10.1002/9780470549148, table 4.1; negative behind the ankle. Its speeds are the momenta "
      "per kg of body mass (after Pai and Rogers 1990). In N s, and with the knee's power, lake loads gives them "
      "(momentum.csv, loads.csv): that needs the body mass.";
  constexpr const char* kTimes =
      "Reference times by age, of both sexes: Bohannon 2006, doi:10.2466/pms.103.1.215-222. In Bohannon et al. "
      "2010, doi:10.3233/IES-2010-0389, sex did not predict the time once age and strength were known.";
  constexpr const char* kLowPower =
      "Low power among older adults, by sex: Baltasar-Fernandez et al. 2021, doi:10.1038/s41598-021-98871-3, who "
      "have the rise of the hip from stature and height of the chair, where here it is measured.";
  constexpr const char* kLean =
      "Lean to the pelvis: the trunk's lean less the angle by which the line from the marker psis to asis falls "
      "below the horizontal; without these markers it is left empty.";
  return {"How it is measured", {List{{kPhases, kFiveTimes, kPower, kCentreOfMass, kTimes, kLowPower, kLean}}}};
}

void WritePage(const gait::LegFitResult& leg, const std::vector<SitToStand>& rows, const gait::Person& person,
               Run& run) {
  Report page{.title = "Sit-to-stand", .warnings = run.Warnings()};
  if (rows.size() > 1)
    page.sections = {{"", {Headline(rows, person)}},
                     {"Rises", {AnglesChart(leg.motion, rows), RisesTable(rows, leg.motion.unit)}},
                     SitToStandMethod()};
  else
    page.sections = {{"", {Paragraph{"No rise was found in this recording."}}}};
  page.sections.push_back(ProvenanceSection(run.Head()));
  WriteReport(run.Result("sit_to_stand.html"), page);
}

bool HasWholeRise(const std::vector<motion::StsEvent>& events) {
  std::map<int, std::set<motion::StsEventKind>> kinds;
  for (const motion::StsEvent& event : events) kinds[event.repetition].insert(event.kind);
  using enum motion::StsEventKind;
  return std::ranges::any_of(kinds, [](const auto& of) {
    return of.second.contains(kOnset) && of.second.contains(kSeatOff) && of.second.contains(kStanding);
  });
}

Measured InMm(double value_m, double sd_m) {
  return std::isnan(value_m) ? Measured{} : Measured{kMmPerM * value_m, kMmPerM * sd_m};
}

// As lake-loads has them of the same markers. Places and velocities are the same whatever the body's mass.
gait::CentresOfMass FindCentresOfMass(const gait::LegFitResult& leg, const loads::LegPathOptions& path, Run& run) {
  const motion::MarkerRecording& markers = leg.trajectory;
  const bool has_trunk = markers.Find(path.shoulder) || markers.Find(path.markers.waist);
  if (markers.unit != motion::LengthUnit::kMm || !has_trunk || !HasWholeRise(leg.events)) return {};
  loads::LoadsOptions options;
  options.body.mass_kg = 70;
  options.draws = 100;  // tell a standard deviation within 7 %
  gait::CentresOfMass centres;
  try {
    for (const loads::RiseLoads& rise : loads::FindLoads(markers, leg.motion, leg.events, path, options).rises) {
      const loads::RiseMomentum& of = rise.momentum;
      const loads::MomentumSd& sd = rise.momentum_sd;
      centres[rise.repetition] = {.seat_off_mm = InMm(of.seat_off_m, sd.seat_off_m),
                                  .forward_max_mm_s = InMm(of.forward_max_m_s, sd.forward_max_m_s),
                                  .upward_max_mm_s = InMm(of.upward_max_m_s, sd.upward_max_m_s)};
    }
  } catch (const Error& error) {
    run.Warn("the centre of mass is left empty: {}", error.what());
  }
  return centres;
}

// Of the knee's angle from all sources, where the recording has lengths in mm.
double AnatomicalSdDeg(const Json& results) {
  if (!results.contains("uncertainty")) return 0;
  const double sd_deg = NumberOrNaN(results.at("uncertainty").at("knee_angle_deg").at("anatomical_sd"));
  return std::isfinite(sd_deg) ? sd_deg : 0;
}

// To each rise's knee angles what the recording's budget has of it: an interval that is narrower here would be another.
void AddSoftTissue(const Json& results, std::vector<SitToStand>& rows) {
  const double knee_sd_deg = AnatomicalSdDeg(results);
  for (SitToStand& rise : rows)
    if (rise.repetition > 0)
      for (Measured* knee : {&rise.knee_seat_off_deg, &rise.knee_max_deg}) knee->sd = std::hypot(knee->sd, knee_sd_deg);
}

// Writes sit_to_stand.csv and the page sit_to_stand.html, and puts `five_times` into the results; where age or sex are
// known, page and results compare the five-times test with people like this one. `markers`: the fit's. The knee's
// angle has the standard deviation of all sources where `results` has its `uncertainty`. Returns what there is to say
// of them at the terminal.
std::string WriteSitToStands(const gait::LegFitResult& leg, const gait::LegMarkers& markers, const gait::Person& person,
                             Json& results, Run& run) {
  gait::TrunkOnPelvis on_pelvis = gait::FindTrunkOnPelvis(leg);
  if (!on_pelvis.warning.empty()) run.Warn(on_pelvis.warning);
  const loads::LegPathOptions path{.facing = leg.motion.facing, .up = leg.up, .markers = markers};
  std::vector<SitToStand> rows = gait::MeasureSitToStands(leg, std::move(on_pelvis), FindCentresOfMass(leg, path, run));
  AddSoftTissue(results, rows);
  gait::WriteSitToStandCsv(run.Result("sit_to_stand.csv"), rows, leg.motion.unit);
  results["five_times"] = gait::FiveTimesJson(rows.back(), person);
  WritePage(leg, rows, person, run);
  std::set<int> repetitions;
  for (const motion::StsEvent& event : leg.events) repetitions.insert(event.repetition);
  return fmt::format("{}, {}\n", Counted(repetitions.size(), "rise"), Counted(leg.outliers.size(), "outlier")) +
         FiveTimesText({rows.back(), person});
}

Json WalkJson(const gait::Walk& walk, const gait::Measures<gait::GaitCycle>& cycles, motion::LengthUnit unit) {
  Json json = {{"ground", walk.ground == gait::Ground::kOverground ? "overground" : "treadmill"},
               {"events_by", walk.by_foot ? "heel and toe" : "ankle"},
               {"strides", walk.strides},
               {"incomplete_strides", walk.incomplete},
               {"left_out", walk.left_out},
               {"measures", gait::MeasuresJson(cycles, unit)}};
  if (walk.by_plate.empty()) return json;
  Json events = Json::array();
  for (const gait::PlateEvent& of : walk.by_plate)
    events.push_back({{"event", ToString(of.event.kind)},
                      {"time_s", of.event.time_s},
                      {"sd_s", NumberOrNull(of.event.sd_s)},
                      {"markers_later_s", NumberOrNull(of.markers_later_s)}});
  json["force_plates"] = events;
  return json;
}

// For the terminal.
std::string WalkText(const gait::Walk& walk) {
  std::string text = fmt::format("walking {}: complete strides: {}; incomplete, left out: {}\n",
                                 walk.ground == gait::Ground::kOverground ? "overground" : "on a treadmill",
                                 walk.strides, walk.incomplete);
  using enum motion::StsEventKind;
  for (const motion::StsEventKind kind : {kHeelStrike, kToeOff, kHeelStrikeOther, kToeOffOther}) {
    std::vector<double> later_ms;
    int events = 0;
    for (const gait::PlateEvent& of : walk.by_plate) {
      if (of.event.kind != kind) continue;
      ++events;
      if (std::isfinite(of.markers_later_s)) later_ms.push_back(1000 * of.markers_later_s);
    }
    if (events > 0) text += fmt::format("{} by force plates: {}", ToString(kind), events);
    if (const double mean_ms = Mean(later_ms); !later_ms.empty())
      text += fmt::format("; the markers show it {:.0f} ms {} (mean)", std::abs(mean_ms),
                          mean_ms < 0 ? "earlier" : "later");
    if (events > 0) text += "\n";
  }
  return text;
}

std::string WriteGaitCycles(const gait::LegFitResult& leg, const std::filesystem::path& reference, Json& results,
                            Run& run) {
  std::optional<gait::ReferenceCurve> curve;
  if (!reference.empty()) curve = gait::ReadReferenceCurve(reference);
  if (curve && !leg.motion.neutral)
    run.Warn(
        "--reference: a norm is of angles from the person's own standing, and 0° here is where the markers say so: "
        "give --neutral, else a shift against the norm means nothing");
  const motion::LengthUnit unit = leg.motion.unit;
  const auto cycles = gait::MeasureGaitCycles(leg, AnatomicalSdDeg(results));
  results["walking"] = WalkJson(leg.movement.walk, cycles, unit);
  gait::WriteMeasures(run.Result("gait_cycles.csv"), "stride", cycles, unit);
  if (!cycles.rows.empty()) DrawPngAndSvg("gait_cycles", run, figure::DrawGaitCycles, leg, cycles, curve);
  return WalkText(leg.movement.walk) + gait::MeasuresText(cycles, unit);
}

std::string WriteSquats(const gait::LegFitResult& leg, Json& results, Run& run) {
  const motion::LengthUnit unit = leg.motion.unit;
  const auto squats = gait::MeasureSquats(leg);
  results["squats"] = {{"squats", squats.rows.size()}, {"measures", gait::MeasuresJson(squats, unit)}};
  gait::WriteMeasures(run.Result("squats.csv"), "squat", squats, unit);
  return fmt::format("squats: {}\n", squats.rows.size()) + gait::MeasuresText(squats, unit);
}

// Each one's smallest, largest and mean.
std::string MeasuresText(const Json& measures) {
  std::string text;
  for (const auto& [name, of] : measures.items()) {
    if (of.is_null()) {
      text += fmt::format("{}  never seen\n", name);
      continue;
    }
    const std::string unit = gait::UnitForPeople(of["unit"].get<std::string>());
    text += fmt::format("{}  {:.1f} to {:.1f}{}{}, mean {:.1f}\n", name, of["smallest"]["value"].get<double>(),
                        of["largest"]["value"].get<double>(), unit == "°" ? "" : " ", unit, of["mean"].get<double>());
  }
  return text;
}

void WriteUncertaintyBudget(const gait::LegFitResult& leg, const compare::RecordingBudgetOptions& options,
                            Json& results, Run& run) {
  const std::vector<compare::Budget> budgets = compare::BudgetsOf(leg, options);
  if (budgets.empty()) return;
  compare::WriteUncertaintyBudgetCsv(run.Result("uncertainty_budget.csv"), budgets);
  results["uncertainty"] = compare::BudgetsJson(budgets);
  const auto knee = std::ranges::find(budgets, std::string("knee_angle"), &compare::Budget::quantity);
  run.Report("the knee beneath the skin: within {} of these angles (1 SD; uncertainty_budget.csv)\n",
             DeviationText(knee->Deviation(), 1, "°"));
}

}  // namespace

std::vector<std::string> LegResultNames(const std::string& name) {
  return {"summary.json",    "kinematics.csv",  "events.csv",      "sit_to_stand.csv", "sit_to_stand.html",
          "gait_cycles.csv", "gait_cycles.png", "gait_cycles.svg", "squats.csv",       "uncertainty_budget.csv",
          "trajectory.csv",  "tracks.csv",      "measures.csv",    "measures.png",     "measures.svg",
          name + ".png",     name + ".svg"};
}

std::string WriteMovement(const gait::LegFitResult& leg, const gait::LegMarkers& markers,
                          const compare::RecordingBudgetOptions& budget, const gait::Person& person,
                          const std::filesystem::path& reference, Json& results, Run& run) {
  motion::WriteKinematicsCsv(run.Result("kinematics.csv"), leg.motion);
  motion::WriteEventsCsv(run.Result("events.csv"), leg.events);
  run.Report(gait::LegFitText(leg));
  WriteUncertaintyBudget(leg, budget, results, run);
  using enum gait::MovementKind;
  results["movement"] = leg.movement.kind ? Json(gait::MovementOf(*leg.movement.kind).name) : Json();
  if (leg.movement.kind == kWalking) return WriteGaitCycles(leg, reference, results, run);
  if (leg.movement.kind == kSquat) return WriteSquats(leg, results, run);
  return WriteSitToStands(leg, markers, person, results, run);
}

void WriteMeasures(const motion::MarkerRecording& recording, const std::vector<gait::MarkerMeasure>& measures,
                   Json& results, Run& run) {
  if (measures.empty()) return;
  const std::vector<gait::MeasuredCourse> courses = gait::MeasureMarkers(recording, measures);
  gait::WriteMeasuresCsv(run.Result("measures.csv"), recording, courses);
  DrawPngAndSvg("measures", run, figure::DrawMeasures, recording, courses);
  results["measures"] = gait::MeasuresJson(recording, courses);
  run.Report(MeasuresText(results["measures"]));
}

}  // namespace lake::commands
