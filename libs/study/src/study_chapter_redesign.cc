#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "lake/actuator/firmware.h"
#include "lake/commands/optimize_tables.h"
#include "lake/compare/decomposition.h"
#include "lake/core/colours.h"
#include "lake/core/csv.h"
#include "lake/core/uncertain_text.h"
#include "lake/report/redesign_charts.h"
#include "study_chapters.h"

namespace lake::study {

using namespace report;

namespace {

namespace fs = std::filesystem;

// "rise time (s)", "stride time (s)".
std::string LabelIn(const StudyResults& results, const commands::DesignFigure& figure) {
  return (figure.name == "program_duration" ? RepetitionIn(results) + " " : "") + figure.label;
}

// What the recording of the worn design showed of a figure of the predictions, with its interval.
Uncertain MeasuredWorn(const Json& comparison, const std::string& key) {
  constexpr std::pair<const char*, Fact> kMeasured[] = {
      {"misalignment_percent", kPathPercent},
      {"misalignment_rms_mm", kPathMm},
      {"misalignment_max_mm", kPathMaxMm},
      {"knee_rmse_deg", kKneeRmse},
      {"program_duration_s", {"", "s", "duration_s/exo", "pace/exo_interval_s"}},
      {"joint_misalignment_rms_mm", {"", "mm", "joint/rms_mm", ""}},
      {"placement_x_mm", {"", "mm", "joint/offset_mm/0", ""}},
      {"placement_y_mm", {"", "mm", "joint/offset_mm/1", ""}}};
  for (const auto& [known, fact] : kMeasured)
    if (key == known) return FactOf(comparison, fact);
  for (const compare::Part& part : compare::kParts)
    if (key == fmt::format("part_{}", part.name))
      return UncertainOf(Find(comparison, fmt::format("decomposition/{}/fraction", part.name)), {}, 100);
  return {};
}

// Rounded to its interval, where one is known.
Cell UncertainCell(const Uncertain& of, int otherwise) {
  if (!of.IsKnown()) return Number{of.value, otherwise};
  return UncertainText(of, "", otherwise);
}

// A headline number of a prediction, as the first screen has it.
Uncertain PredictedHeadline(const std::vector<Way>& ways, const StudyResults& results, const Json& summary,
                            const std::string& design, const commands::DesignFigure& figure) {
  const Json& of = summary.at(design);
  if (!of.is_object()) return {};
  if (figure.Key() == "knee_rmse_deg") return KneeAngleError(results, of);
  if (figure.Key() == "misalignment_percent" && (design == "joint_moved" || design == "after"))
    for (const Way& way : ways)
      if (way.design == design) return way.misalignment_percent;
  return {.value = figure.factor * NumberAt(of, figure.Key())};
}

// The worn design as recorded and as predicted are not the same: the prediction leaves pace and lean of its trial out.
Table BeforeAfterTable(const StudyFile& study, const StudyResults& results, const Json& summary) {
  const Json comparison = results.Has("comparison") ? results.Summary("comparison") : Json();
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
  for (const commands::DesignFigure& figure : commands::DesignFigures()) {
    const std::string key = figure.Key();
    if (figure.label.empty() || (summary.at("after").at(key).is_null() && summary.at("before").at(key).is_null()))
      continue;
    std::vector<Cell> cells{LabelIn(results, figure), UncertainCell(MeasuredWorn(comparison, key), figure.decimals)};
    for (const char* design : {"before", "joint_moved", "other_program", "after"})
      cells.push_back(UncertainCell(PredictedHeadline(ways, results, summary, design, figure), figure.decimals));
    table.rows.push_back(std::move(cells));
  }
  if (const double floor = NumberAt(summary, "noise_floor_percent"); results.Has("comparison")) {
    const Number none{std::nan(""), DecimalsOf("%")};
    table.rows.push_back(
        {"noise floor of a recording (% of the shank length)", Number{floor, DecimalsOf("%")}, none, none, none, none});
  }
  return table;
}

Table BuildTable(const StudyResults& results, const Json& summary) {
  const Json simulation = results.Summary("simulation");
  Table table{"Links and actuator to build", {{"Quantity"}, {"Worn"}, {"New"}}};
  for (int i = 1; i <= 6; ++i)
    table.rows.push_back({fmt::format("l{} (mm)", i), Number{NumberAt(summary, fmt::format("before/l{}_mm", i)), 2},
                          Number{NumberAt(summary, fmt::format("after/l{}_mm", i)), 2}});
  const auto add = [&](const char* what, double value, int decimals) {
    table.rows.push_back({what, Number{std::nan(""), decimals}, Number{value, decimals}});
  };
  add("shortest actuator, pin to pin (mm)", NumberAt(simulation, "used_stroke_mm/0"), 2);
  add("longest actuator, pin to pin (mm)", NumberAt(simulation, "used_stroke_mm/1"), 2);
  add("travel (mm)", NumberAt(simulation, "travel_mm"), 2);
  add("knee torque to hold (N m)", NumberAt(simulation, "knee_torque_nm"), DecimalsOf("N m"));
  add("largest actuator force for it (N)", LargestForce(results), DecimalsOf("N"));
  add("largest actuator speed (mm/s)", NumberAt(summary, "stroke_program/max_speed_mm_s"), 1);
  return table;
}

// What the cuffs do to the leg, worn, with the joint moved, and new; no rows without a prediction.
Table CuffTable(const Json& summary) {
  Table table{
      "Largest forces caused by misalignment over the rise, N (95 % interval: stiffness of cuff and flesh, "
      "placement of the joint)",
      {{"Design, predicted"}, {"Thigh cuff"}, {"Shank cuff"}, {"Shear at the knee"}}};
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
      row.emplace_back(fmt::format("{} ({})", force_n.Text(), force_n.IntervalText()));
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

// Can this person be lifted, how fast, leaning how far, and what that costs; beside it what the person did.
Table ProgramBalanceTable(const StudyResults& results, const Json& summary, const Json& balance) {
  const Json &asked = balance.at("asked_mm"), &without = balance.at("without"), &after = summary.at("after");
  const Json did = results.Has("loads") ? results.Summary("loads").at("balance").at("own") : Json();
  Table table{asked.is_null() ? "Balance along the program; it was not required"
                              : fmt::format("Balance along the program: the centre of pressure at least {} inside the "
                                            "foot, and what that costs",
                                            QuantityAt(balance, "asked_mm")),
              {{"Quantity"}, {"New design"}, {"Without balance"}, {"The person's own rise"}},
              {}};
  // The key says the unit of all three.
  const auto add = [&](const std::string& what, const Json& of, const Json& without_it, const std::string& key,
                       const char* did_key) {
    const auto number = [&](const Json& from, const std::string& name) {
      return Number{NumberOrNaN(Find(from, name)), DecimalsOf(UnitOf(key))};
    };
    table.rows.push_back({what, number(of, key), number(without_it, key), number(did, did_key)});
  };
  const std::vector<commands::DesignFigure> figures = commands::DesignFigures();
  for (const auto& [name, did_key] : {std::pair{"balance_margin", "margin_mm"},
                                      {"range", ""},
                                      {"misalignment", ""},
                                      {"angle_mismatch_max", ""},
                                      {"program_duration", "rise_s"}}) {
    const auto figure = std::ranges::find(figures, name, &commands::DesignFigure::name);
    add(LabelIn(results, *figure), after, without, figure->Key(), did_key);
  }
  add("trunk leans farther forward than in the person's own rise, most (°; negative: back)", balance, {},
      "trunk_lean_deg", "");
  add("leg, ankle to hip, leans farther forward, most (°; negative: back)", balance, {}, "leg_lean_deg", "");
  if (results.Has("loads"))
    table.rows.push_back({"knee moment at this pace, peak (% of the person's own rise's)",
                          Number{PeakPercent(balance, did), 0}, Number{std::nan(""), 0},
                          Number{PeakPercent(did, did), 0}});
  else
    add("knee moment at this pace, peak (N m)", balance, {}, "peak_knee_nm", "peak_knee_nm");
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
  Series path{.name = name,
              .x = NumbersOrNaN(curves.at(prefix + "_x_mm")),
              .y = NumbersOrNaN(curves.at(prefix + "_y_mm")),
              .colour = colour,
              .mark = mark};
  for (std::size_t i = 0; i < path.x.size(); ++i) path.labels.push_back(fmt::format("{} %", i));
  return path;
}

std::vector<double> Column(const CsvTable& table, const char* name) {
  std::vector<double> values;
  for (std::size_t row = 0; row < table.Rows(); ++row)
    values.push_back(table.Number(row, table.Column(name)).value_or(std::nan("")));
  return values;
}

Series ColumnSeries(const CsvTable& table, const char* x, const char* y, const char* name, const char* colour,
                    Mark mark) {
  return {.name = name, .x = Column(table, x), .y = Column(table, y), .colour = colour, .mark = mark};
}

LineChart AnglesChart(const fs::path& program, const std::string& repetition) {
  const CsvTable table = CsvTable::Read(program);
  return {.title = "Knee angles",
          .caption = "Knee angle of the person and of the new design.",
          .x = {repetition + " (%)", 0, 100},
          .y = {.label = "knee flexion (°)"},
          .series = {ColumnSeries(table, "percent", "knee_deg", "new design", colour::kNew, Mark::kDashed),
                     ColumnSeries(table, "percent", "human_knee_deg", "human", colour::kHuman, Mark::kLine)},
          .width = Width::kHalf};
}

Table TradeTable(const Json& summary) {
  Table table{
      "What giving up range buys, with the same stroke program",
      {{"Range of rotation (°)", 1}, {"Range given up (°)", 1}, {"Path difference, RMS (% of the shank length)", 1}}};
  // Where all range up to some leaves no misalignment, the points of the front are one design.
  std::vector<std::string> ranges;
  for (const TradePoint& point : OwnFront(summary)) {
    const std::string range = NumberText(point.range_deg, 1);
    if (std::ranges::find(ranges, range) != ranges.end()) continue;
    ranges.push_back(range);
    table.rows.push_back({range, NumberAt(summary, "range_deg") - point.range_deg, point.misalignment_percent});
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
  std::string text = fmt::format(
      " With speeds within {} % of the duty table the actuator is at {} mm where it comes nearest to "
      "the linkage's end at {:.2f} mm.",
      SignificantText(NumberAt(firmware, "drift/tolerance_percent"), 3),
      PlusMinusText(NumberAt(firmware, "drift/nearest/planned_mm"), NumberAt(firmware, "drift/nearest/drift_mm"), 2),
      NumberAt(firmware, "drift/end_mm"));
  text += fmt::format(" The retract end stop belongs at {:.2f} mm", NumberAt(firmware, "home_stroke_mm"));
  if (firmware.at("extend_stop_mm").is_number())
    text += fmt::format(", the extend end stop, which catches the drift, at {:.2f} mm",
                        NumberAt(firmware, "extend_stop_mm"));
  text += '.';
  if (firmware.at("drift").at("accepted").get<bool>())
    text += " This drift was accepted: the firmware is only for a bench without a person.";
  return text;
}

Table ProgramTable(const Json& summary) {
  const double duration_s = NumberAt(summary, "duration_s"), rest_s = NumberAt(summary, "added_rest_s");
  return {"Stroke program",
          {{"Quantity"}, {"Value", 2}},
          {{"start, pin to pin (mm)", NumberAt(summary, "start/stroke_mm")},
           {"end, pin to pin (mm)", NumberAt(summary, "end/stroke_mm")},
           {"permitted stroke, from (mm)", NumberAt(summary, "soft_limits_mm/0")},
           {"permitted stroke, to (mm)", NumberAt(summary, "soft_limits_mm/1")},
           {"time in motion, as designed (s)", duration_s - rest_s},
           {"rests that the controller adds at reversals (s)", rest_s},
           {"time in all (s)", duration_s},
           {"largest speed (mm/s)", NumberAt(summary, "largest_speed_mm_s")}}};
}

}  // namespace

std::string UnitOf(const std::string& key) {
  for (const auto& [ending, unit] : {std::pair{"_mm_s", "mm/s"},
                                     {"_mm", "mm"},
                                     {"_s", "s"},
                                     {"_deg", "°"},
                                     {"_percent", "%"},
                                     {"_nm", "N m"},
                                     {"_ns", "N s"},
                                     {"_n", "N"},
                                     {"_kg", "kg"}})
    if (key.ends_with(ending)) return unit;
  return "";
}

int DecimalsOf(const std::string& unit) {
  return unit == "N" ? 0 : 1;
}

std::string Quantity(double value, const std::string& unit) {
  return NumberText(value, DecimalsOf(unit)) + (unit == "°" ? "" : " ") + unit;
}

std::string QuantityAt(const Json& summary, const std::string& path) {
  return Quantity(NumberAt(summary, path), UnitOf(path));
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
  double largest = 0;
  for (const double force_n : Column(CsvTable::Read(results.Folder() / "simulation/angle_vs_stroke.csv"), "force_n"))
    largest = std::max(largest, std::abs(force_n));
  constexpr double kNoActuator_n = 1e6;  // at a dead point
  return largest < kNoActuator_n ? largest : std::nan("");
}

LineChart PathsChart(const StudyResults& results) {
  const Json predicted = ReadJsonFile(results.Folder() / "redesign/predicted/comparison.json").at("curves");
  LineChart chart{
      .title = "Knee paths",
      .alt = "Paths of the human knee, of the exoskeleton's knee as measured and as predicted for the new design",
      .caption = fmt::format("Seen from the side, one {}, x forward, y up from {}.", RepetitionIn(results),
                             RepetitionIn(results) == "rise" ? "the seated ankle" : "the hip"),
      .x = {.label = "anterior (mm)"},
      .y = {.label = "up (mm)"},
      .equal_scales = true,
      .width = Width::kHalf};
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
  if (const Json balance = Find(summary, "balance"); balance.is_object()) {
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
  const auto over_time = [&](const char* title, const char* axis, const char* column, const char* name) {
    return LineChart{.title = title,
                     .x = {.label = "time (s)"},
                     .y = {.label = axis},
                     .series = {ColumnSeries(table, "time_s", column, name, colour::kNew, Mark::kLine)},
                     .width = Width::kHalf};
  };
  Section section{"Stroke program", {ProgramTable(summary)}};
  if (summary.at("firmware").is_object())
    section.blocks.push_back(Paragraph{
        fmt::format("The {} has {} segments, which are within {:.3f} mm of the program.", FirmwareOf(study)->what,
                    summary["firmware"].at("segments").get<int>(), NumberAt(summary, "firmware/rounding_error_mm")) +
        DriftText(summary["firmware"])});
  section.blocks.push_back(over_time("Stroke over time", "stroke (mm)", "stroke_mm", "stroke"));
  section.blocks.push_back(over_time("Resulting knee angle", "knee flexion (°)", "knee_deg", "knee"));
  return section;
}

}  // namespace lake::study
