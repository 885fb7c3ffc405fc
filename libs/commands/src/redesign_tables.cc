#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "comparison_tables.h"
#include "lake/commands/optimize_tables.h"
#include "lake/core/angles.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/uncertain_text.h"
#include "lake/redesign/redesign_outcome.h"
#include "optimum_tables.h"

namespace lake::commands {
namespace {

// As a key ends in it: "_n".
std::string KeyEnding(std::string_view unit) {
  if (unit == "1") return "";
  return unit == "%" ? "_percent" : unit == "N" ? "_n" : fmt::format("_{}", unit);
}

// The designs that are compared, by the names of their columns and keys.
struct NamedDesign {
  const char* name;
  const redesign::DesignInMotion* design;  // nullptr: there is none
};

std::array<NamedDesign, 4> DesignsOf(const redesign::RedesignOutcome& outcome) {
  const auto of = [](const std::optional<redesign::DesignInMotion>& design) { return design ? &*design : nullptr; };
  return {{{"before", &outcome.before},
           {"joint_moved", of(outcome.joint_moved)},
           {"other_program", of(outcome.other_program)},
           {"after", &outcome.after}}};
}

// Of those that can make the motion.
std::vector<CuffCase> CuffCases(const redesign::RedesignOutcome& outcome) {
  std::vector<CuffCase> cases;
  for (const auto& [name, design] : DesignsOf(outcome))
    if (design)
      if (const auto course = redesign::CuffsOf(outcome.problem, *design, outcome.measured.joint_sd_mm))
        cases.push_back({name, *course});
  return cases;
}

void WriteBeforeAfter(const redesign::RedesignOutcome& outcome, Run& run) {
  std::vector<std::string> header = {"quantity", "unit"};
  for (const NamedDesign& named : DesignsOf(outcome)) header.emplace_back(named.name);
  CsvWriter table(header);
  for (const DesignFigure& figure : DesignFigures()) {
    table.Add(figure.name).Add(figure.unit);
    for (const NamedDesign& named : DesignsOf(outcome)) table.Add(named.design ? figure.value(*named.design) : kNaN);
    table.EndRow();
  }
  table.Write(run.Result("before_after.csv"));
}

Json BeforeAfterJson(const redesign::DesignInMotion& design) {
  Json json = Json::object();
  for (const DesignFigure& figure : DesignFigures()) json[figure.Key()] = NumberOrNull(figure.value(design));
  json["program"] = redesign::ProgramName(design.design.program->kind);
  return json;
}

// What varies beside the links.
std::vector<LimitedRow> ProgramRows(const redesign::RedesignOutcome& outcome, const OptimumView& optimum) {
  const redesign::RedesignProblem& problem = outcome.problem;
  std::vector<LimitedRow> rows;
  for (const int axis : {0, 1})
    rows.push_back({.name = redesign::PlacementName(axis),
                    .before = outcome.before.design.placement_mm[axis],
                    .after = outcome.after.design.placement_mm[axis],
                    .limits = problem.PlacementBounds(axis),
                    .multiplier = optimum.MultiplierOf({redesign::PlacementName(axis)})});
  rows.push_back({.name = "duration",
                  .before = outcome.before.duration_s,
                  .after = outcome.after.duration_s,
                  .limits = {0, problem.program.duration_s.value_or(kNaN)},
                  .multiplier = optimum.MultiplierOf({redesign::kDuration.name})});
  return rows;
}

// What the person's own limits are on; the misalignment with or without one.
std::vector<LimitedRow> PersonRows(const redesign::RedesignOutcome& outcome, const OptimumView& optimum) {
  std::vector<LimitedRow> rows;
  for (const redesign::Quantity& quantity : redesign::kQuantities) {
    const std::optional<double>& limit = quantity.limit(outcome.problem);
    const bool is_variable = &quantity == &redesign::kDuration;  // and in optimum.csv
    if (is_variable || (!limit && &quantity != &redesign::kMisalignment)) continue;
    std::string name(quantity.name);
    std::ranges::replace(name, ' ', '_');
    problem::Bounds limits{kNaN, kNaN};
    (quantity.is_lower ? limits.lower : limits.upper) = limit.value_or(kNaN);
    rows.push_back({.name = std::move(name),
                    .before = ValueOf(quantity, outcome.before),
                    .after = ValueOf(quantity, outcome.after),
                    .limits = limits,
                    .multiplier = optimum.MultiplierOf({quantity.name}),
                    .unit = quantity.unit});
  }
  return rows;
}

std::vector<StartRow> StartRows(const redesign::RedesignResult& result) {
  std::vector<StartRow> rows;
  for (const redesign::RedesignSolve& solve : result.starts)
    rows.push_back(
        {solve.local,
         {},
         StartRow::Motion{solve.IsUsable(), solve.Predicted() ? solve.objective : kNaN, solve.Misalignment_percent()}});
  return rows;
}

// A path as lake-compare writes it, so that lake-compare can evaluate it again.
void WritePath(const redesign::DesignInMotion& design, const std::string& folder, Run& run) {
  if (!design.misalignment) return;
  compare::WriteMisalignmentCsv(run.Result(folder + "/misalignment.csv"), *design.misalignment);
  WriteJsonFile(run.Result(folder + "/comparison.json"), compare::ComparisonJson(*design.misalignment));
}

// Worn, repaired and new design beside the fronts.
void AddDesignRow(const NamedDesign& named, CsvWriter& table) {
  if (!named.design || !named.design->misalignment) return;
  const redesign::DesignInMotion& of = *named.design;
  table.AddRow(named.name, redesign::ProgramName(of.design.program->kind), of.duration_s, std::nullopt,
               of.evaluation.range_deg, 100 * of.misalignment->metrics.relative_rms, of.misalignment->metrics.rms_mm,
               of.tracking_time_s.value_or(kNaN), of.design.placement_mm[0], of.design.placement_mm[1],
               of.design.links.Values());
}

void WritePareto(const redesign::RedesignOutcome& outcome, Run& run) {
  std::vector<std::string> header{"design",
                                  "program",
                                  "duration_limit_s",
                                  "least_range_deg",
                                  "range_deg",
                                  "misalignment_percent",
                                  "misalignment_rms_mm",
                                  "exact_tracking_time_s",
                                  "placement_x_mm",
                                  "placement_y_mm"};
  std::ranges::copy(LinkColumns(""), std::back_inserter(header));
  CsvWriter table(header);
  for (const redesign::NamedFront& front : outcome.fronts)
    for (const redesign::ParetoPoint& point : front.points) {
      const auto tracking = redesign::TrackingStrokes(outcome.problem.Driven(point.point.links), outcome.problem.human);
      table.AddRow("front", redesign::ProgramName(front.program.kind), front.program.duration_s, point.least_range_deg,
                   point.range_deg, point.misalignment_percent, point.rms_mm,
                   tracking ? redesign::TrackingTime(*tracking, outcome.problem.program.max_speed_mm_s) : kNaN,
                   point.point.placement_mm.x(), point.point.placement_mm.y(), point.point.links.Values());
    }
  for (const NamedDesign& named : DesignsOf(outcome)) AddDesignRow(named, table);
  table.Write(run.Result("pareto.csv"));
}

// Of which rise the moments of the load profile are, and how surely they are those of the program.
Json MomentsJson(const std::optional<redesign::MomentsOfProgram>& moments) {
  if (!moments) return Json();
  return {{"of_s", moments->duration_s}, {"rounds", moments->rounds}, {"off_nm", moments->off_nm}};
}

Json FrontsJson(const redesign::RedesignOutcome& outcome) {
  Json fronts = Json::array();
  for (const redesign::NamedFront& front : outcome.fronts) {
    Json points = Json::array();
    for (const redesign::ParetoPoint& point : front.points)
      points.push_back({point.range_deg, point.misalignment_percent});
    fronts.push_back({{"program", front.name},
                      {"range_deg_and_misalignment_percent", points},
                      {"moments", MomentsJson(front.moments)}});
  }
  return fronts;
}

Json InfeasibleJson(const redesign::Infeasibility& report) {
  Json json = {{"reason", report.sentence}, {"blocking", Json::array()}, {"ways_out", Json::array()}};
  const redesign::Quantity* held = report.quantity;
  for (const redesign::Quantity& quantity : redesign::kQuantities) {
    if (!*quantity.best_key) continue;
    json[quantity.best_key] = &quantity == held ? Json(*report.best) : Json();
    json["limit_that_holds" + KeyEnding(quantity.unit)] = &quantity == held ? NumberOrNull(report.working) : Json();
  }
  for (const synthesis::ActiveSet::Entry& entry : report.blocking)
    json["blocking"].push_back({{"limit", entry.name},
                                {"multiplier", NumberOrNull(held->Merit(entry.multiplier))},
                                {"unit", fmt::format("{} {} per {}", held->unit, held->name, entry.unit)}});
  for (const redesign::WayOut& way : report.ways) {
    json["ways_out"].push_back({{"change", way.text},
                                {"enough", way.enough},
                                {"misalignment_percent", nullptr},
                                {"duration_s", NumberOrNull(way.duration_s)}});
    if (way.best) json["ways_out"].back()[std::string(held->column) + KeyEnding(held->unit)] = *way.best;
  }
  return json;
}

Json ProgramJson(const redesign::RedesignOutcome& outcome) {
  const redesign::ProgramLimits& limits = outcome.problem.program;
  Json json = {{"kind", redesign::ProgramName(limits.kind)},
               {"max_speed_mm_s", limits.max_speed_mm_s},
               {"duration_limit_s", NumberOrNull(limits.duration_s)},
               {"duration_s", outcome.after.prediction ? Json(outcome.after.duration_s) : Json()},
               {"exact_tracking_time_s", NumberOrNull(outcome.after.tracking_time_s)}};
  if (outcome.after.prediction)
    json["stroke_from_to_mm"] = {outcome.after.prediction->stroke_mm.front(),
                                 outcome.after.prediction->stroke_mm.back()};
  return json;
}

// The bound is of the linkage alone: nothing that a redesign asks for in the motion is in it.
std::vector<std::string> NotInBound(const redesign::RedesignProblem& problem) {
  std::vector<std::string> names = certificate::NotInBound(problem.design);
  names.emplace_back("program");
  for (const redesign::Quantity& quantity : redesign::kQuantities)
    if (&quantity != &redesign::kDuration && quantity.Counts(problem)) names.emplace_back(quantity.name);
  return names;
}

// The force of an actuator is limited by what the knee needs along a program, and that program is sought under the
// limit.
void WarnOfMoments(const redesign::RedesignOutcome& outcome, Run& run) {
  const auto are_others = [](const std::optional<redesign::MomentsOfProgram>& moments) {
    return moments && moments->off_nm > redesign::kOtherMoments_nm;
  };
  if (are_others(outcome.moments))
    run.Warn(
        "the program was sought under moments of the knee that are up to {:.1f} N m off those along it, and the forces "
        "said of it are of the former; write the links of design.yaml as 'start' into the problem's file and run it "
        "again, so that the search goes on from there",
        outcome.moments->off_nm);
  if (are_others(outcome.moments_without_balance))
    run.Warn(
        "the design without --balance was sought under moments of the knee that are up to {:.1f} N m off those along "
        "its program, so what balance costs is known less surely",
        outcome.moments_without_balance->off_nm);
  for (const redesign::NamedFront& front : outcome.fronts)
    if (are_others(front.moments))
      run.Warn(
          "the front '{}' was sought under the moments of one rise, in {} s, and along the programs of its other "
          "points they are up to {:.1f} N m off those: where a force is limited, ask for such a point by itself, "
          "without --pareto",
          front.name, SignificantText(front.moments->duration_s, 3), front.moments->off_nm);
}

// Of walking: whether the actuator is quick enough, for what part of the stride, and how slow a walk it could follow.
Json WalkJson(const redesign::RedesignOutcome& outcome) {
  if (!outcome.problem.program.cyclic) return nullptr;
  const double stride_s = outcome.measured.human.duration_s, speed_mm_s = outcome.problem.program.max_speed_mm_s;
  constexpr double kRounding = 1 + 1e-5;
  const bool is_quick_enough = outcome.IsSolved() && outcome.after.duration_s <= kRounding * stride_s;
  std::string text = fmt::format("A stride takes {} s and the actuator moves {} mm/s.", SignificantText(stride_s, 3),
                                 SignificantText(speed_mm_s, 3));
  const auto of = [&](const char* name, const redesign::DesignInMotion& design) -> Json {
    if (!design.tracking_time_s) return nullptr;
    const double needed_mm_s = speed_mm_s * *design.tracking_time_s / stride_s,
                 share_percent = 100 * design.tracked_share.value_or(0),
                 speed_percent = std::min(100.0, 100 * stride_s / *design.tracking_time_s);
    text += fmt::format(
        " To follow the knee exactly the {} linkage needs {} mm/s: it can for {} % of the cycle, or all of it at {} % "
        "of the walking speed.",
        name, SignificantText(needed_mm_s, 3), SignificantText(share_percent, 2), SignificantText(speed_percent, 2));
    return {{"needed_mm_s", needed_mm_s},
            {"share_of_cycle_percent", share_percent},
            {"shortest_stride_s", *design.tracking_time_s},
            {"walking_speed_percent", speed_percent}};
  };
  Json json = {{"stride_s", stride_s},
               {"max_speed_mm_s", speed_mm_s},
               {"is_quick_enough", is_quick_enough},
               {"worn", outcome.measured.worn ? of("worn", outcome.before) : Json()},
               {"new", of("new", outcome.after)}};
  if (is_quick_enough)
    text += fmt::format(" The new program follows within {}° in that time.",
                        SignificantText(outcome.after.prediction->angle_mismatch_deg, 2));
  else
    text += " NOT USABLE FOR WALKING at this person's speed: the actuator is too slow.";
  json["text"] = text;
  return json;
}

// What `walk`, of WalkJson(), says: a warning where the actuator is too slow.
void SayWalk(const Json& walk, Run& run) {
  if (walk.is_null()) return;
  const auto text = walk.at("text").get<std::string>();
  if (walk.at("is_quick_enough").get<bool>())
    run.Report(text + "\n");
  else
    run.Warn("{}", text);
}

void WarnOfRedesign(const redesign::RedesignOutcome& outcome, Run& run) {
  const redesign::RedesignProblem& problem = outcome.problem;
  if (outcome.measured.exo && outcome.measured.worn && !outcome.slip)
    run.Warn(
        "the exoskeleton trial shows no leg of its own (a marker knee beside exo_knee), so the slip of its "
        "mount is unknown and left out of the prediction");
  constexpr double kOtherAngles_deg = 10;
  if (outcome.worn_angle_off_deg && *outcome.worn_angle_off_deg > kOtherAngles_deg)
    run.Warn(
        "{}: the knee angle of its program differs from that of its trial by {:.0f}° RMS; check links and program, or "
        "leave the program out of the file: then the trial's own knee angles are taken",
        outcome.measured.worn_file, *outcome.worn_angle_off_deg);
  if (const auto& after = outcome.after.misalignment;
      after && 100 * after->metrics.relative_rms < outcome.measured.noise_floor_percent)
    run.Warn(
        "the predicted path difference, {:.1f} % of the shank, is below the noise floor of the comparison, {:.1f} %: a "
        "recording of the new design cannot be expected to show less than that",
        100 * after->metrics.relative_rms, outcome.measured.noise_floor_percent);
  WarnWithoutLimit(problem, run);
  if (const auto& after = outcome.after.prediction; after && after->balance && after->balance->margin_mm < 0)
    run.Warn(
        "nobody keeps the balance along this program: at {:.0f} % of the rise, in {} s, the ground's force has to act "
        "{:.0f} mm outside the foot; require it with --balance, or let something hold the person",
        after->balance->at_percent, SignificantText(after->balance->duration_s, 3), -after->balance->margin_mm);
  WarnOfMoments(outcome, run);
  if (!outcome.IsSolved()) return;
  WarnOfMultipliers(outcome.active, run);
  if (outcome.certificate) {
    WarnOfCertificate(*outcome.certificate, NotInBound(problem), run);
    run.Warn(
        "the certified bound is one on the range alone, without the limit on misalignment; the largest range found "
        "without that limit is {:.4f}°",
        *outcome.widest_deg);
    if (outcome.moments)
      run.Warn(
          "the certified bound is one under the moments along the program found, of a rise in {} s: under those of "
          "another program the range may be larger",
          SignificantText(outcome.moments->duration_s, 3));
  }
}

Json TrialJson(const redesign::RedesignOutcome& outcome) {
  if (!outcome.measured_percent) return nullptr;
  Json trial = {{"misalignment_percent", *outcome.measured_percent},
                {"worn_angle_off_deg", NumberOrNull(outcome.worn_angle_off_deg)}};
  if (!outcome.slip) return trial;
  const redesign::MountSlip& slip = *outcome.slip;
  trial.update({{"slip_rms_mm", slip.slip_mm},
                {"mount_rms_mm", slip.mount_mm},
                {"mount_mm", {slip.placement_mm.x(), slip.placement_mm.y()}},
                {"pace_rms_mm", slip.pace_mm},
                {"lean_rms_mm", slip.lean_mm}});
  return trial;
}

Json PlacementRangeJson(const redesign::RedesignOutcome& outcome) {
  if (!outcome.placement_range) return nullptr;
  const redesign::PlacementRange& range = *outcome.placement_range;
  return {{"within_percent", range.within_percent},
          {"x_mm", {range.x_mm.lower, range.x_mm.upper}},
          {"y_mm", {range.y_mm.lower, range.y_mm.upper}},
          {"range_at_knee_deg", NumberOrNull(outcome.range_at_knee_deg)}};
}

// From where it was worn to where the new design has it: "5 mm further back and 32 mm lower". Without an axis along
// which the worn place is as good.
std::string MoveText(const redesign::RedesignOutcome& outcome, const std::array<double, 2>& worn_mm) {
  const auto& to_mm = outcome.after.design.placement_mm;
  std::vector<std::string> moves;
  const auto add = [&](std::size_t axis, const problem::Bounds* as_good, const char* less, const char* more) {
    const double way_mm = to_mm[axis] - worn_mm[axis];
    if (as_good && as_good->lower <= worn_mm[axis] && worn_mm[axis] <= as_good->upper) return;
    moves.push_back(fmt::format("{:.0f} mm {}", std::abs(way_mm), way_mm < 0 ? less : more));
  };
  const auto& range = outcome.placement_range;
  add(0, range ? &range->x_mm : nullptr, "further back", "further forward");
  add(1, range ? &range->y_mm : nullptr, "lower", "higher");
  return fmt::format("{}", fmt::join(moves, " and "));
}

// One sentence that says what to build, and how free that is.
std::string BuildText(const redesign::RedesignOutcome& outcome) {
  const auto& placement = outcome.after.design.placement_mm;
  std::string text = fmt::format("Build it with the joint {}", compare::DescribeJoint({placement[0], placement[1]}));
  if (outcome.measured.worn)
    if (const std::string move = MoveText(outcome, outcome.measured.worn->placement_mm); !move.empty())
      text += fmt::format(", that is {} than it was worn", move);
  text += ".";
  if (const auto& range = outcome.placement_range)
    text += fmt::format(
        " With the stroke program adapted, a joint {} to {} mm in front of the knee, or {} to {} mm above it, keeps "
        "the misalignment within {:.1f} %.",
        RoundedText(range->x_mm.lower, 0), RoundedText(range->x_mm.upper, 0), RoundedText(range->y_mm.lower, 0),
        RoundedText(range->y_mm.upper, 0), range->within_percent);
  if (outcome.range_at_knee_deg)
    text += fmt::format(" With the joint on the knee the range would be {:.1f}°.", *outcome.range_at_knee_deg);
  return text;
}

// Where the trial with the worn design differs from the human's, and what of it the prediction keeps.
std::string TrialText(const redesign::RedesignOutcome& outcome) {
  if (!outcome.measured_percent)
    return "No exoskeleton trial was used, so the slip of its mount is unknown and left out.";
  if (!outcome.slip)
    return "The exoskeleton trial shows no leg of its own, so the slip of its mount is unknown and left out.";
  return fmt::format(
      "In the exoskeleton trial the joint sat {} relative to the leg; its mount slipped by {} mm RMS, which the "
      "prediction assumes for the new design too. The rest of the difference between the trials is pace ({} mm RMS) "
      "and lean ({} mm RMS), which the prediction leaves out.",
      compare::DescribeJoint(outcome.slip->placement_mm), SignificantText(outcome.slip->slip_mm, 2),
      SignificantText(outcome.slip->pace_mm, 2), SignificantText(outcome.slip->lean_mm, 2));
}

// For the terminal: the designs side by side, as a joint that is moved may do as well as new links.
std::string MotionText(const redesign::RedesignOutcome& outcome) {
  constexpr struct {
    const char *label, *figure;
  } kRows[] = {{"range (°)", "range"},
               {"misalignment (% of the shank)", "misalignment"},
               {"misalignment (mm RMS)", "misalignment_rms"},
               {"joint before the knee (mm)", "placement_x"},
               {"joint above the knee (mm)", "placement_y"},
               {"program (s)", "program_duration"},
               {"exact tracking (s)", "exact_tracking_time"}};
  const std::array<const char*, 4> headings = {outcome.measured.worn ? "worn" : "start", "joint moved", "other program",
                                               "new links"};
  const std::array<NamedDesign, 4> designs = DesignsOf(outcome);
  std::string text;
  const auto add_row = [&](const char* label, const auto& cell_of) {
    text += fmt::format("  {:<30}", label);
    for (std::size_t i = 0; i < designs.size(); ++i)
      if (designs[i].design) text += fmt::format("{:>14}", cell_of(i));
    text += "\n";
  };
  add_row("", [&](std::size_t i) { return headings[i]; });
  const std::vector<DesignFigure> figures = DesignFigures();
  for (const auto& row : kRows) {
    const auto figure = std::ranges::find(figures, row.figure, &DesignFigure::name);
    add_row(row.label, [&](std::size_t i) {
      const double value = figure->value(*designs[i].design);
      return std::isfinite(value) ? RoundedText(value, 1) : "-";
    });
  }
  add_row("keeps the limits on links",
          [&](std::size_t i) { return designs[i].design->evaluation.IsFeasible() ? "yes" : "no"; });
  return text + TrialText(outcome) + "\n" + BuildText(outcome) + "\n";
}

double Largest_deg(const std::vector<double>& lean_rad) {
  double largest = 0;
  for (const double lean : lean_rad)
    if (std::abs(lean) > std::abs(largest)) largest = lean;
  return DegreesFromRadians(largest);
}

// Whether the person is in balance along the program, how they lean for it, and what that costs; null where the body
// is not known.
Json ProgramBalanceJson(const redesign::RedesignOutcome& outcome) {
  if (!outcome.after.prediction || !outcome.after.prediction->balance) return nullptr;
  const redesign::BalanceCourse& course = *outcome.after.prediction->balance;
  const loads::Foot& foot = outcome.problem.body->body.sole;
  Json json = {{"asked_mm", NumberOrNull(outcome.problem.balance_mm)},
               {"device_mass_kg", outcome.problem.body->aids.device_kg},
               {"hold_force_n", outcome.problem.body->aids.hold_n},
               {"margin_mm", course.margin_mm},
               {"at_percent", course.at_percent},
               {"duration_s", course.duration_s},
               {"peak_knee_nm", course.peak_knee_nm},
               {"foot_mm", {kMmPerM * foot.heel_m, kMmPerM * foot.toe_m}},
               {"trunk_lean_deg", Largest_deg(outcome.lean.trunk_rad)},
               {"leg_lean_deg", Largest_deg(outcome.lean.leg_rad)},
               {"without", nullptr}};
  if (!outcome.without_balance) return json;
  json["without"] = BeforeAfterJson(*outcome.without_balance);
  json["without"]["moments"] = MomentsJson(outcome.moments_without_balance);
  return json;
}

// The centre of pressure and the knee's moment at the program's pace, and how the person leans for it.
void WriteProgramBalance(const redesign::RedesignOutcome& outcome, Run& run) {
  const auto& prediction = outcome.after.prediction;
  if (!prediction || !prediction->balance) return;
  const redesign::BalanceCourse& course = *prediction->balance;
  const redesign::HumanMotion& human = outcome.problem.human;
  const std::size_t seated = human.size() - course.samples.size();
  CsvWriter table({"percent", "time_s", "pressure_mm", "margin_mm", "knee_nm", "leg_lean_deg", "trunk_lean_deg",
                   "trunk_deg", "human_trunk_deg"});
  for (std::size_t i = 0; i < human.size(); ++i) {
    const double percent = redesign::PercentOf(i, human);
    const auto lean_deg = [i](const std::vector<double>& lean) {
      return lean.empty() ? 0 : DegreesFromRadians(lean[i]);
    };
    const double trunk_deg = DegreesFromRadians(outcome.problem.body->trunk[i].tilt_rad);
    const redesign::BalanceSample sample =
        i < seated ? redesign::BalanceSample{percent, kNaN, kNaN, kNaN} : course.samples[i - seated];
    table.AddRow(percent, course.duration_s * percent / 100, sample.pressure_mm, sample.margin_mm, sample.knee_nm,
                 lean_deg(outcome.lean.leg_rad), lean_deg(outcome.lean.trunk_rad),
                 trunk_deg + lean_deg(outcome.lean.trunk_rad), trunk_deg);
  }
  table.Write(run.Result("balance.csv"));
}

void WriteTables(const redesign::RedesignOutcome& outcome, const OptimumView& optimum, Run& run) {
  WriteOptimumDesign(outcome.after.design, optimum, run);
  WriteOptimum(optimum, ProgramRows(outcome, optimum), run);
  WriteConstraints(optimum, PersonRows(outcome, optimum), run);
  WriteStarts(StartRows(outcome.result), run);
  WriteConvergence(outcome.result.BestOrFirst().local, "objective_deg", run);
  WriteBeforeAfter(outcome, run);
  WriteCuffTable(run.Result("cuffs.csv"), CuffCases(outcome));
  WriteProgramTable(outcome.after, outcome.problem.human, run.Result("program.csv"));
  WritePath(outcome.after, "predicted", run);
  if (outcome.joint_moved) WritePath(*outcome.joint_moved, "joint_moved", run);
  WriteProgramBalance(outcome, run);
  if (!outcome.fronts.empty()) WritePareto(outcome, run);
}

// What the summary has of the misalignment, the program and the trial, solved or not.
Json MotionJson(const redesign::RedesignOutcome& outcome) {
  Json json = {
      {"misalignment_of", outcome.problem.misalignment_of == redesign::MisalignmentOf::kJoint ? "joint" : "path"},
      {"misalignment_percent", NumberOrNull(ValueOf(redesign::kMisalignment, outcome.after))},
      {"misalignment_rms_mm", outcome.after.prediction ? Json(outcome.after.prediction->Rms().mm) : Json()},
      {"penalty_deg_per_mm", outcome.problem.penalty_deg_per_mm},
      {"cuff_penalty_deg_per_n", outcome.problem.cuff_penalty_deg_per_n},
      {"links", LinksJson(outcome.after.design.links)},
      {"placement_mm", outcome.after.design.placement_mm},
      {"stroke_program", ProgramJson(outcome)},
      {"trial", TrialJson(outcome)},
      {"trial_text", TrialText(outcome)},
      {"placement_range", PlacementRangeJson(outcome)},
      {"build_text", outcome.IsSolved() ? Json(BuildText(outcome)) : Json()},
      {"noise_floor_percent", outcome.measured.noise_floor_percent},
      {"walking", WalkJson(outcome)},
      {"moments", MomentsJson(outcome.moments)},
      {"balance", ProgramBalanceJson(outcome)}};
  for (const redesign::Quantity& quantity : redesign::kQuantities)
    if (*quantity.key) json[quantity.key] = NumberOrNull(quantity.limit(outcome.problem));
  for (const NamedDesign& named : DesignsOf(outcome))
    json[named.name] = named.design ? BeforeAfterJson(*named.design) : Json();
  for (const CuffCase& one : CuffCases(outcome)) json[one.name]["cuffs"] = CuffsJson(one.course);
  return json;
}

Json SolvedJson(const synthesis::LocalSolve& best, const synthesis::ActiveSet& active) {
  return {{"multipliers_unique", active.multipliers_unique},
          {"active", ActiveJson(active)},
          {"iterations", best.iterations}};
}

}  // namespace

std::string DesignFigure::Key() const {
  return name + KeyEnding(unit);
}

std::vector<DesignFigure> DesignFigures() {
  using Design = redesign::DesignInMotion;
  const auto limited = [](const redesign::Quantity& quantity, const char* label = "") {
    return DesignFigure{std::string(quantity.column), quantity.unit,
                        [&quantity](const Design& d) { return ValueOf(quantity, d); }, label};
  };
  const auto compared = [](const std::string& name, const char* unit, auto value, std::string label,
                           double factor = 1) {
    return DesignFigure{name, unit, [value](const Design& d) { return d.misalignment ? value(*d.misalignment) : kNaN; },
                        std::move(label), factor};
  };
  const auto predicted = [](const char* name, auto value, const char* label, int decimals) {
    return DesignFigure{name,  "mm", [value](const Design& d) { return d.prediction ? value(*d.prediction) : kNaN; },
                        label, 1,    decimals};
  };
  const auto placement = [](int axis, const char* label) {
    return DesignFigure{redesign::PlacementName(axis),
                        "mm",
                        [axis](const Design& d) { return d.design.placement_mm[axis]; },
                        label,
                        1,
                        0};
  };
  using compare::Misalignment, redesign::Prediction;
  std::vector<DesignFigure> all;
  for (std::size_t i = 0; i < 6; ++i)
    all.push_back({problem::LinkName(i), "mm", [i](const Design& d) { return d.design.links.Values()[i]; }});
  all.insert(all.end(),
             {{"range", "deg", [](const Design& d) { return d.evaluation.range_deg; }, "range of rotation (°)"},
              limited(redesign::kMisalignment, "path difference, RMS (% of the shank length)"),
              predicted(
                  "misalignment_rms", [](const Prediction& p) { return p.Rms().mm; }, "path difference, RMS (mm)", 1),
              compared(
                  "misalignment_max", "mm", [](const Misalignment& m) { return m.metrics.max_mm; },
                  "path difference, largest (mm)")});
  for (const compare::Part& part : compare::kParts)
    all.push_back(compared(
        fmt::format("part_{}", part.name), "1",
        [&part](const Misalignment& m) { return m.decomposition.*part.fraction; },
        fmt::format("{} share (%)", part.name), 100));
  all.insert(
      all.end(),
      {compared(
           "knee_rmse", "deg", [](const Misalignment& m) { return m.metrics.knee_rmse_deg; },
           "knee angle, RMS from the human's (°)"),
       predicted(
           "joint_misalignment_rms", [](const Prediction& p) { return p.joint.mm; }, "joint misalignment, RMS (mm)", 0),
       limited(redesign::kAngleMismatch, "knee angle, largest difference from the human's (°)"),
       limited(redesign::kCuffForce),
       limited(redesign::kBalanceMargin, "centre of pressure inside the foot, least (mm; negative: outside)"),
       placement(0, "joint in front of the knee (mm)"),
       placement(1, "joint above the knee, along the shank (mm)"),
       limited(redesign::kDuration, "time (s)"),
       {"exact_tracking_time", "s", [](const Design& d) { return d.tracking_time_s.value_or(kNaN); },
        "minimum time for exact tracking (s)"},
       {"stroke_when_standing", "mm", [](const Design& d) { return d.evaluation.stands_mm.value_or(kNaN); }},
       predicted(
           "program_travel",
           [](const Prediction& p) { return std::ranges::max(p.stroke_mm) - std::ranges::min(p.stroke_mm); },
           "actuator travel along the program (mm)", 1)});
  return all;
}

Json WriteRedesign(const redesign::RedesignOutcome& outcome, Run& run) {
  const synthesis::LocalSolve* best = outcome.IsSolved() ? &outcome.result.Best().local : nullptr;
  const redesign::DesignInMotion &before = outcome.before, &after = outcome.after;
  const OptimumView optimum{.problem = outcome.problem.design,
                            .links_before = before.design.links,
                            .links_after = after.design.links,
                            .before = before.evaluation,
                            .after = after.evaluation,
                            .best = best,
                            .active = outcome.active,
                            .not_a_solution = best ? "" : outcome.infeasible->sentence};
  WriteTables(outcome, optimum, run);
  Json summary = HeadJson(optimum, after.evaluation.violation, outcome.certificate);
  summary.update(MotionJson(outcome));
  SayWalk(summary["walking"], run);
  WarnOfRedesign(outcome, run);
  summary.update(best ? SolvedJson(*best, outcome.active) : InfeasibleJson(*outcome.infeasible));
  summary["clearances"] = ClearancesJson(outcome.problem.design);
  summary["optimum"] = EvaluationJson(after.evaluation);
  if (outcome.certificate) {
    summary["certificate"] = CertificateJson(*outcome.certificate, NotInBound(outcome.problem));
    if (outcome.moments) summary["certificate"]["moments_of_s"] = outcome.moments->duration_s;
  }
  if (outcome.yield) {
    summary["yield"] = YieldJson(*outcome.yield);
    WriteYields({{"optimum", &*outcome.yield}}, run);
  }
  if (!outcome.fronts.empty()) summary["pareto"] = FrontsJson(outcome);
  if (best)
    run.Report(RangeText(after.evaluation.range_deg, outcome.certificate) + MotionText(outcome) +
               LinksText(after.design.links) + ActiveText(outcome.active) +
               (outcome.yield ? YieldText(*outcome.yield) : ""));
  return summary;
}

}  // namespace lake::commands
