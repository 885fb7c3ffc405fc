#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "first_screen.h"
#include "lake/actuator/firmware.h"
#include "lake/compare/decomposition.h"
#include "lake/core/colours.h"
#include "lake/core/csv.h"
#include "lake/core/uncertain_text.h"
#include "lake/report/redesign_charts.h"
#include "lake/report/uncertain.h"
#include "study_chapters.h"

namespace lake::study {

using namespace report;

namespace {

namespace fs = std::filesystem;

struct BeforeAfterRow {
  std::string key, what;
  const char* unit;
  double factor = 1;
};
std::vector<BeforeAfterRow> BeforeAfterRows() {
  std::vector<BeforeAfterRow> rows = {
      {"misalignment_percent", "path difference, RMS (% of the shank length)", "%"},
      {"misalignment_rms_mm", "path difference, RMS (mm)", "mm"},
      {"misalignment_max_mm", "path difference, largest (mm)", "mm"},
  };
  for (const compare::Part& part : compare::kParts)
    rows.push_back({fmt::format("part_{}", part.name), fmt::format("{} share (%)", part.name), "share", 100});
  rows.insert(rows.end(),
              {{"joint_misalignment_rms_mm", "joint misalignment, RMS (mm)", "joint"},
               {"knee_rmse_deg", "knee angle, RMS from the human's (°)", "°"},
               {"angle_mismatch_max_deg", "knee angle, largest difference from the human's (°)", "°"},
               {"balance_margin_mm", "centre of pressure inside the foot, least (mm; negative: outside)", "mm"},
               {"range_deg", "range of rotation (°)", "°"},
               {"placement_x_mm", "joint in front of the knee (mm)", "joint"},
               {"placement_y_mm", "joint above the knee, along the shank (mm)", "joint"},
               {"program_duration_s", "time (s)", "s"},
               {"exact_tracking_time_s", "minimum time for exact tracking (s)", "s"}});
  return rows;
}

// What the recording of the worn design showed, under the keys of the predictions.
Json MeasuredWorn(const StudyResults& results) {
  if (!results.Has("comparison")) return Json::object();
  const Json comparison = results.Summary("comparison");
  const Json &metrics = comparison.at("metrics"), &parts = comparison.at("decomposition");
  Json measured = {{"misalignment_percent", 100 * NumberOrNaN(metrics.at("relative_rms"))},
                   {"misalignment_rms_mm", metrics.at("rms_mm")},
                   {"misalignment_max_mm", metrics.at("max_mm")},
                   {"knee_rmse_deg", metrics.at("knee_rmse_deg")},
                   {"program_duration_s", comparison.at("duration_s").at("exo")}};
  for (const compare::Part& part : compare::kParts)
    measured[fmt::format("part_{}", part.name)] = parts.at(part.name).at("fraction");
  if (const Json joint = comparison.value("joint", Json()); !joint.is_null()) {
    measured["joint_misalignment_rms_mm"] = joint.at("rms_mm");
    measured["placement_x_mm"] = joint.at("offset_mm")[0];
    measured["placement_y_mm"] = joint.at("offset_mm")[1];
  }
  return measured;
}

// 95 %, in the rows' units, of what the recording shows.
Json IntervalsOfMeasured(const StudyResults& results) {
  if (!results.Has("comparison")) return Json::object();
  const Json comparison = results.Summary("comparison"), of = comparison.value("intervals", Json::object());
  Json intervals = {{"misalignment_rms_mm", of.value("rms_mm", Json())},
                    {"misalignment_max_mm", of.value("max_mm", Json())},
                    {"knee_rmse_deg", of.value("knee_rmse_deg", Json())},
                    {"program_duration_s", comparison.at("pace").value("exo_interval_s", Json())}};
  if (const Json relative = of.value("relative_rms", Json()); relative.is_array())
    intervals["misalignment_percent"] = {100 * NumberOrNaN(relative.at(0)), 100 * NumberOrNaN(relative.at(1))};
  return intervals;
}

// Rounded to its interval, where one is known.
Cell UncertainCell(const Uncertain& of, int otherwise) {
  if (!of.IsKnown()) return Number{of.value, otherwise};
  return UncertainText(of, "", otherwise);
}

// A headline number of a prediction, as the first screen has it.
Uncertain PredictedHeadline(const std::vector<Way>& ways, const StudyResults& results, const Json& summary,
                            const std::string& design, const BeforeAfterRow& row) {
  const Json& of = summary.at(design);
  if (!of.is_object()) return {};
  if (row.key == "knee_rmse_deg") return KneeAngleError(results, of);
  if (row.key == "misalignment_percent" && (design == "joint_moved" || design == "after"))
    for (const Way& way : ways)
      if (way.design == design) return way.misalignment_percent;
  return {.value = row.factor * NumberOrNaN(of.at(row.key))};
}

// The worn design as recorded and as predicted are not the same: the prediction leaves pace and lean of its trial out.
Table BeforeAfterTable(const StudyFile& study, const StudyResults& results, const Json& summary) {
  const Json &before = summary.at("before"), &after = summary.at("after"), measured = MeasuredWorn(results),
             intervals = IntervalsOfMeasured(results);
  const std::vector<Way> ways = WaysOf(study, results);
  Table table{
      "Worn, repaired and new design, with 95 % intervals where they are known; ranges, and places and times of a "
      "design, are exact. The predictions are for the human trial's movement, without the pace and lean of the "
      "exoskeleton trial, which a moved joint alone keeps",
      {{"Quantity"},
       {"Worn, measured"},
       {"Worn, predicted"},
       {"Joint moved, predicted"},
       {"Other program, predicted"},
       {"New, predicted"}},
      {}};
  for (const BeforeAfterRow& row : BeforeAfterRows()) {
    if (after.at(row.key).is_null() && before.at(row.key).is_null()) continue;
    Uncertain recorded = UncertainOf(measured.value(row.key, Json()), intervals.value(row.key, Json()));
    recorded.value *= row.factor;
    if (row.unit == std::string("%")) recorded.least_decimals = kPathDifferenceDecimals;
    const int decimals = DecimalsOf(row.unit);
    const std::string of = row.key == "program_duration_s" ? RepetitionIn(results) + " " : "";
    std::vector<Cell> cells{of + row.what, UncertainCell(recorded, decimals)};
    for (const char* design : {"before", "joint_moved", "other_program", "after"})
      cells.push_back(UncertainCell(PredictedHeadline(ways, results, summary, design, row), decimals));
    table.rows.push_back(std::move(cells));
  }
  if (const double floor = NumberOrNaN(summary.at("noise_floor_percent")); results.Has("comparison")) {
    const Number none{std::nan(""), DecimalsOf("%")};
    table.rows.push_back(
        {"noise floor of a recording (% of the shank length)", Number{floor, DecimalsOf("%")}, none, none, none, none});
  }
  return table;
}

Table BuildTable(const StudyResults& results, const Json& summary) {
  const Json simulation = results.Summary("simulation");
  const Json &before = summary.at("before"), &after = summary.at("after");
  Table table{"Links and actuator to build", {{"Quantity"}, {"Worn"}, {"New"}}, {}};
  for (int i = 1; i <= 6; ++i) {
    const std::string key = fmt::format("l{}_mm", i);
    table.rows.push_back(
        {fmt::format("l{} (mm)", i), Number{NumberOrNaN(before.at(key)), 2}, Number{NumberOrNaN(after.at(key)), 2}});
  }
  const auto add = [&](const char* what, double value, int decimals) {
    table.rows.push_back({what, Number{std::nan(""), decimals}, Number{value, decimals}});
  };
  add("shortest actuator, pin to pin (mm)", NumberOrNaN(simulation.at("used_stroke_mm").at(0)), 2);
  add("longest actuator, pin to pin (mm)", NumberOrNaN(simulation.at("used_stroke_mm").at(1)), 2);
  add("travel (mm)", NumberOrNaN(simulation.at("travel_mm")), 2);
  add("knee torque to hold (N m)", NumberOrNaN(simulation.at("knee_torque_nm")), DecimalsOf("N m"));
  add("largest actuator force for it (N)", LargestForce(results), DecimalsOf("N"));
  add("largest actuator speed (mm/s)", NumberOrNaN(summary.at("stroke_program").at("max_speed_mm_s")), 1);
  return table;
}

// What the cuffs do to the leg, worn, with the joint moved, and new; no rows without a prediction.
Table CuffTable(const Json& summary) {
  Table table{
      "Largest forces caused by misalignment over the rise, N (95 % interval: stiffness of cuff and flesh, "
      "placement of the joint)",
      {{"Design, predicted"}, {"Thigh cuff"}, {"Shank cuff"}, {"Shear at the knee"}},
      {}};
  constexpr std::pair<const char*, const char*> kDesigns[] = {{"before", "worn"},
                                                              {"joint_moved", "worn, joint moved"},
                                                              {"other_program", "worn, other program"},
                                                              {"after", "new"}};
  for (const auto& [design, name] : kDesigns) {
    const Json& of = summary.at(design);
    if (!of.is_object() || !of.contains("cuffs")) continue;
    std::vector<Cell> row{name};
    for (const char* force : {"thigh_cuff", "shank_cuff", "knee_shear"}) {
      const Json& cuffs = of["cuffs"];
      const Uncertain force_n =
          UncertainOf(cuffs.at(fmt::format("{}_n", force)), cuffs.at(fmt::format("{}_interval_n", force)));
      row.emplace_back(fmt::format("{} ({} to {})", force_n.Text(1), RoundedText(force_n.low, force_n.Decimals(1)),
                                   RoundedText(force_n.high, force_n.Decimals(1))));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

// Can this person be lifted, how fast, leaning how far, and what that costs; beside it what the person did.
Table ProgramBalanceTable(const StudyResults& results, const Json& summary, const Json& balance) {
  const Json &asked = balance.at("asked_mm"), &without = balance.at("without"), &after = summary.at("after");
  const Json did = results.Has("loads") ? results.Summary("loads").at("balance").at("own") : Json::object();
  Table table{asked.is_null() ? "Balance along the program; it was not required"
                              : fmt::format("Balance along the program: the centre of pressure at least {} inside the "
                                            "foot, and what that costs",
                                            Quantity(NumberOrNaN(asked), "mm")),
              {{"Quantity"}, {"New design"}, {"Without balance"}, {"The person's own rise"}},
              {}};
  const auto number = [](const Json& of, const char* key, const char* unit) {
    return Number{NumberOrNaN(of.value(key, Json())), DecimalsOf(unit)};
  };
  const auto add = [&](const char* what, const char* key, const char* unit, const char* did_key) {
    table.rows.push_back({what, number(after, key, unit),
                          number(without.is_null() ? Json::object() : without, key, unit), number(did, did_key, unit)});
  };
  add("centre of pressure inside the foot, least (mm; negative: outside)", "balance_margin_mm", "mm", "margin_mm");
  add("range of rotation (°)", "range_deg", "°", "");
  add("path difference, RMS (% of the shank length)", "misalignment_percent", "%", "");
  add("knee angle, largest difference from the human's (°)", "angle_mismatch_max_deg", "°", "");
  add("rise time (s)", "program_duration_s", "s", "rise_s");
  const auto own = [&](const char* what, const char* key, const char* unit, const char* did_key) {
    table.rows.push_back(
        {what, number(balance, key, unit), Number{std::nan(""), DecimalsOf(unit)}, number(did, did_key, unit)});
  };
  own("trunk leans farther forward than in the person's own rise, most (°; negative: back)", "trunk_lean_deg", "°", "");
  own("leg, ankle to hip, leans farther forward, most (°; negative: back)", "leg_lean_deg", "°", "");
  if (results.Has("loads"))
    table.rows.push_back({"knee moment at this pace, peak (% of the person's own rise's)",
                          Number{PeakPercent(balance, did), 0}, Number{std::nan(""), 0},
                          Number{PeakPercent(did, did), 0}});
  else
    own("knee moment at this pace, peak (N m)", "peak_knee_nm", "N m", "peak_knee_nm");
  return table;
}

// What holds the design back, and what a step further would bring.
List ActiveList(const Json& summary) {
  List list;
  for (const Json& limit : summary.at("active")) {
    std::string item = limit.at("limit").get<std::string>();
    if (limit.at("multiplier").is_number())
      item += fmt::format(": {} {}", WithSign(SignificantText(limit["multiplier"].get<double>(), 3)),
                          limit.at("unit").get<std::string>());
    list.items.push_back(std::move(item));
  }
  return list;
}

Series Path(const Json& curves, const std::string& prefix, const char* name, const char* colour, Mark mark) {
  Series path;
  path.name = name;
  path.colour = colour;
  path.mark = mark;
  for (const Json& x : curves.at(prefix + "_x_mm")) path.x.push_back(NumberOrNaN(x));
  for (const Json& y : curves.at(prefix + "_y_mm")) path.y.push_back(NumberOrNaN(y));
  for (std::size_t i = 0; i < path.x.size(); ++i) path.labels.push_back(fmt::format("{} %", i));
  return path;
}

Series ColumnSeries(const CsvTable& table, const char* x, const char* y, const char* name, const char* colour,
                    Mark mark) {
  Series series;
  series.name = name;
  series.colour = colour;
  series.mark = mark;
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    series.x.push_back(table.Number(row, table.Column(x)).value_or(std::nan("")));
    series.y.push_back(table.Number(row, table.Column(y)).value_or(std::nan("")));
  }
  return series;
}

LineChart AnglesChart(const fs::path& program, const std::string& repetition) {
  const CsvTable table = CsvTable::Read(program);
  LineChart chart;
  chart.title = "Knee angles";
  chart.x = {repetition + " (%)", 0, 100};
  chart.y.label = "knee flexion (°)";
  chart.width = Width::kHalf;
  chart.caption = "Knee angle of the person and of the new design.";
  chart.series = {ColumnSeries(table, "percent", "knee_deg", "new design", colour::kNew, Mark::kDashed),
                  ColumnSeries(table, "percent", "human_knee_deg", "human", colour::kHuman, Mark::kLine)};
  return chart;
}

Table TradeTable(const Json& summary) {
  Table table{
      "What giving up range buys, with the same stroke program",
      {{"Range of rotation (°)", 1}, {"Range given up (°)", 1}, {"Path difference, RMS (% of the shank length)", 1}},
      {}};
  // Where all range up to some leaves no misalignment, the points of the front are one design.
  std::vector<std::string> ranges;
  for (const TradePoint& point : OwnFront(summary)) {
    const std::string range = NumberText(point.range_deg, 1);
    if (std::ranges::find(ranges, range) != ranges.end()) continue;
    ranges.push_back(range);
    table.rows.push_back({range, NumberOrNaN(summary.at("range_deg")) - point.range_deg, point.misalignment_percent});
  }
  return table;
}

// What other limits would give: the ends of the other programs' fronts.
std::string OtherLimitsText(const Json& summary) {
  std::vector<std::string> others;
  for (const Json& front : summary.value("pareto", Json::array())) {
    const Json& points = front.at("range_deg_and_misalignment_percent");
    if (points.empty()) continue;
    others.push_back(fmt::format("with a {} program {} at best", front.at("program").get<std::string>(),
                                 Quantity(NumberOrNaN(points.front().at(1)), "%")));
  }
  if (others.empty()) return "";
  return fmt::format("What other limits would give: {}.", fmt::join(others, ", "));
}

// How far the actuator may be from its plan, and whether that leaves the linkage's room.
std::string DriftText(const Json& firmware) {
  const Json &drift = firmware.at("drift"), &nearest = drift.at("nearest");
  std::string text = fmt::format(
      " With speeds within {} % of the duty table the actuator is at {} mm where it comes nearest to "
      "the linkage's end at {:.2f} mm.",
      SignificantText(NumberOrNaN(drift.at("tolerance_percent")), 3),
      PlusMinusText(NumberOrNaN(nearest.at("planned_mm")), NumberOrNaN(nearest.at("drift_mm")), 2),
      NumberOrNaN(drift.at("end_mm")));
  text += fmt::format(" The retract end stop belongs at {:.2f} mm", NumberOrNaN(firmware.at("home_stroke_mm")));
  if (firmware.at("extend_stop_mm").is_number())
    text += fmt::format(", the extend end stop, which catches the drift, at {:.2f} mm",
                        NumberOrNaN(firmware.at("extend_stop_mm")));
  text += '.';
  if (drift.at("accepted").get<bool>())
    text += " This drift was accepted: the firmware is only for a bench without a person.";
  return text;
}

Table ProgramTable(const Json& summary) {
  const double duration_s = NumberOrNaN(summary.at("duration_s")), rest_s = NumberOrNaN(summary.at("added_rest_s"));
  const Json& limits = summary.at("soft_limits_mm");
  return {"Stroke program",
          {{"Quantity"}, {"Value", 2}},
          {{"start, pin to pin (mm)", NumberOrNaN(summary.at("start").at("stroke_mm"))},
           {"end, pin to pin (mm)", NumberOrNaN(summary.at("end").at("stroke_mm"))},
           {"permitted stroke, from (mm)", NumberOrNaN(limits.at(0))},
           {"permitted stroke, to (mm)", NumberOrNaN(limits.at(1))},
           {"time in motion, as designed (s)", duration_s - rest_s},
           {"rests that the controller adds at reversals (s)", rest_s},
           {"time in all (s)", duration_s},
           {"largest speed (mm/s)", NumberOrNaN(summary.at("largest_speed_mm_s"))}}};
}

}  // namespace

int DecimalsOf(const std::string& unit) {
  return unit == "N" || unit == "joint" ? 0 : 1;
}

std::string Quantity(double value, const std::string& unit) {
  return NumberText(value, DecimalsOf(unit)) + (unit == "°" ? "" : " ") + unit;
}

std::vector<TradePoint> OwnFront(const Json& redesign) {
  const Json& program = redesign.at("stroke_program");
  std::string own = program.at("kind").get<std::string>();
  if (own == "free" && program.at("duration_limit_s").is_number())
    own += fmt::format(" {} s", SignificantText(program["duration_limit_s"].get<double>(), 4));
  std::vector<TradePoint> points;
  for (const Json& front : redesign.value("pareto", Json::array()))
    if (front.at("program") == own && points.empty())
      for (const Json& point : front.at("range_deg_and_misalignment_percent"))
        points.push_back({NumberOrNaN(point.at(0)), NumberOrNaN(point.at(1))});
  return points;
}

double LargestForce(const StudyResults& results) {
  const CsvTable table = CsvTable::Read(results.Folder() / "simulation/angle_vs_stroke.csv");
  const std::size_t column = table.Column("force_n");
  double largest = 0;
  for (std::size_t row = 0; row < table.Rows(); ++row)
    largest = std::max(largest, std::abs(table.Number(row, column).value_or(std::nan(""))));
  constexpr double kNoActuator_n = 1e6;  // at a dead point
  return largest < kNoActuator_n ? largest : std::nan("");
}

LineChart PathsChart(const StudyResults& results) {
  const Json predicted = ReadJsonFile(results.Folder() / "redesign/predicted/comparison.json").at("curves");
  LineChart chart;
  chart.title = "Knee paths";
  chart.alt = "Paths of the human knee, of the exoskeleton's knee as measured and as predicted for the new design";
  chart.caption = fmt::format("Seen from the side, one {}, x forward, y up from {}.", RepetitionIn(results),
                              RepetitionIn(results) == "rise" ? "the seated ankle" : "the hip");
  chart.x.label = "anterior (mm)";
  chart.y.label = "up (mm)";
  chart.equal_scales = true;
  chart.width = Width::kHalf;
  // The first is drawn on top: a new path that covers the human's is still seen.
  chart.series = {Path(predicted, "exo_knee", "new design, predicted", colour::kNew, Mark::kDashed)};
  if (const fs::path measured = "comparison/comparison.json"; results.HasFile(measured))
    chart.series.push_back(Path(ReadJsonFile(results.Folder() / measured).at("curves"), "exo_knee", "worn, measured",
                                colour::kWorn, Mark::kDotted));
  chart.series.push_back(Path(predicted, "human_knee", "human", colour::kHuman, Mark::kLine));
  return chart;
}

Section RedesignChapter(const StudyFile& study, const StudyResults& results) {
  const Json summary = results.Summary("redesign");
  Section section{"New design", {}};
  if (summary.at("build_text").is_string())
    section.blocks.push_back(Paragraph{summary.at("build_text").get<std::string>()});
  section.blocks.push_back(Paragraph{summary.at("trial_text").get<std::string>()});
  section.blocks.push_back(BeforeAfterTable(study, results, summary));
  if (std::string others = OtherLimitsText(summary); !others.empty())
    section.blocks.push_back(Paragraph{std::move(others)});
  section.blocks.push_back(CuffTable(summary));
  section.blocks.push_back(BuildTable(results, summary));
  if (results.HasFile(kKneesPicture)) section.blocks.push_back(PathsChart(results));  // else the first screen has it
  section.blocks.push_back(AnglesChart(results.Folder() / "redesign/program.csv", RepetitionIn(results)));
  if (summary.contains("pareto")) {
    section.blocks.push_back(ParetoChart(summary));
    if (Table trade = TradeTable(summary); !trade.rows.empty()) section.blocks.push_back(std::move(trade));
  }
  if (const Json balance = summary.value("balance", Json()); balance.is_object()) {
    section.blocks.push_back(ProgramBalanceTable(results, summary, balance));
    results.AddPicture(
        "redesign/balance.svg", "Balance along the program",
        "Where the ground's force acts within the foot in a rise at the program's pace, once the seat is "
        "left; how the person leans for it; the knee's moment at that pace.",
        Width::kFull, section);
  }
  if (List active = ActiveList(summary); !active.items.empty()) {
    section.blocks.push_back(Paragraph{
        summary.value("multipliers_unique", false)
            ? "Active constraints and sensitivities (change of the range per unit by which a limit is relaxed):"
            : "Active constraints:"});
    section.blocks.push_back(std::move(active));
  }
  return section;
}

std::optional<Files::File> FirmwareOf(const StudyFile& study) {
  if (!study.stroke) return std::nullopt;
  return Files::File{fmt::format("stroke/{}/{}", actuator::kSketchFolder, actuator::kNotesFile),
                     "firmware for the Arduino UNO"};
}

Section StrokeChapter(const StudyFile& study, const StudyResults& results) {
  const Json summary = results.Summary("stroke");
  const CsvTable table = CsvTable::Read(results.Folder() / "stroke/program.csv");
  LineChart stroke, knee;
  stroke.title = "Stroke over time";
  stroke.x.label = "time (s)";
  stroke.y.label = "stroke (mm)";
  stroke.series = {ColumnSeries(table, "time_s", "stroke_mm", "stroke", colour::kNew, Mark::kLine)};
  knee.title = "Resulting knee angle";
  knee.x.label = "time (s)";
  knee.y.label = "knee flexion (°)";
  knee.series = {ColumnSeries(table, "time_s", "knee_deg", "knee", colour::kNew, Mark::kLine)};
  stroke.width = knee.width = Width::kHalf;
  Section section{"Stroke program", {ProgramTable(summary)}};
  if (summary.at("firmware").is_object())
    section.blocks.push_back(
        Paragraph{fmt::format("The {} has {} segments, which are within {:.3f} mm of the program.",
                              FirmwareOf(study)->what, summary["firmware"].at("segments").get<int>(),
                              NumberOrNaN(summary["firmware"].at("rounding_error_mm"))) +
                  DriftText(summary["firmware"])});
  section.blocks.push_back(std::move(stroke));
  section.blocks.push_back(std::move(knee));
  return section;
}

}  // namespace lake::study
