#include <algorithm>
#include <cmath>

#include "lake/core/colours.h"
#include "lake/core/csv.h"
#include "study_chapters.h"

namespace lake::study {

using namespace report;

namespace {

namespace fs = std::filesystem;

struct BeforeAfterRow {
  const char *key, *what;
  double factor;
};
constexpr BeforeAfterRow kRows[] = {
    {"range_deg", "range of rotation (°)", 1},
    {"misalignment_percent", "misalignment, RMS (% of the shank)", 1},
    {"misalignment_rms_mm", "misalignment, RMS (mm)", 1},
    {"misalignment_max_mm", "misalignment, largest (mm)", 1},
    {"part_placement", "of it placement (%)", 100},
    {"part_timing", "of it timing (%)", 100},
    {"part_shape", "of it shape (%)", 100},
    {"knee_rmse_deg", "knee angle against the human's, RMS (°)", 1},
    {"placement_x_mm", "joint sits in front of the knee (mm)", 1},
    {"placement_y_mm", "joint sits above the knee, along the shank (mm)", 1},
    {"program_duration_s", "duration of the stroke program (s)", 1},
    {"exact_tracking_time_s", "time that following the knee exactly needs (s)", 1},
    {"l1_mm", "l1 (mm)", 1},
    {"l2_mm", "l2 (mm)", 1},
    {"l3_mm", "l3 (mm)", 1},
    {"l4_mm", "l4 (mm)", 1},
    {"l5_mm", "l5 (mm)", 1},
    {"l6_mm", "l6 (mm)", 1},
};

Table BeforeAfterTable(const Json& summary) {
  const Json &before = summary.at("before"), &after = summary.at("after");
  Table table{"Before and after", {{"Quantity"}, {"Before", 2}, {"After", 2}, {"Change", 2}}, {}};
  for (const BeforeAfterRow& row : kRows) {
    const double from = row.factor * NumberOrNaN(before.at(row.key)), to = row.factor * NumberOrNaN(after.at(row.key));
    table.rows.push_back({row.what, from, to, to - from});
  }
  return table;
}

KeyFigures BeforeAfterFigures(const Json& summary) {
  const auto figure = [&](const char* label, const char* key, const char* unit) {
    const double before = NumberOrNaN(summary.at("before").at(key));
    return KeyFigure{label,
                     NumberOrNaN(summary.at("after").at(key)),
                     2,
                     unit,
                     std::nullopt,
                     std::isnan(before) ? "" : fmt::format("before: {:.2f} {}", before, unit)};
  };
  return {{figure("misalignment, RMS", "misalignment_percent", "%"), figure("range of rotation", "range_deg", "°"),
           figure("misalignment, RMS", "misalignment_rms_mm", "mm"),
           figure("stroke program", "program_duration_s", "s")}};
}

// What holds the design back, and what a step further would bring.
List ActiveList(const Json& summary) {
  List list;
  for (const Json& limit : summary.at("active")) {
    std::string item = limit.at("limit").get<std::string>();
    if (limit.at("multiplier").is_number())
      item += fmt::format(": {:+.3g} {}", limit["multiplier"].get<double>(), limit.at("unit").get<std::string>());
    list.items.push_back(std::move(item));
  }
  return list;
}

Series Path(const Json& curves, const std::string& prefix, const char* name, const char* colour, Mark mark) {
  Series path;
  path.name = name, path.colour = colour, path.mark = mark;
  for (const Json& x : curves.at(prefix + "_x_mm")) path.x.push_back(NumberOrNaN(x));
  for (const Json& y : curves.at(prefix + "_y_mm")) path.y.push_back(NumberOrNaN(y));
  for (std::size_t i = 0; i < path.x.size(); ++i) path.labels.push_back(fmt::format("{} %", i));
  return path;
}

LineChart PathsChart(const StudyResults& results) {
  const Json predicted = ReadJsonFile(results.Folder() / "redesign/predicted/comparison.json").at("curves");
  LineChart chart;
  chart.title = "Where the knees go";
  chart.alt = "Paths of the human knee, of the exoskeleton's knee as measured and as predicted for the new design";
  chart.caption = "Leg frame: origin at the seated ankle, x forward, y up.";
  chart.x.label = "anterior (mm)", chart.y.label = "up (mm)";
  chart.equal_scales = true, chart.width = Width::kHalf;
  chart.series = {Path(predicted, "human_knee", "human", colour::kHuman, Mark::kLine)};
  if (const fs::path measured = "comparison/comparison.json"; results.HasFile(measured))
    chart.series.push_back(Path(ReadJsonFile(results.Folder() / measured).at("curves"), "exo_knee",
                                "exoskeleton as measured", colour::kExoskeleton, Mark::kDotted));
  chart.series.push_back(Path(predicted, "exo_knee", "new design, predicted", colour::kHip, Mark::kDashed));
  return chart;
}

Series ColumnSeries(const CsvTable& table, const char* x, const char* y, const char* name, const char* colour,
                    Mark mark) {
  Series series;
  series.name = name, series.colour = colour, series.mark = mark;
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    series.x.push_back(table.Number(row, table.Column(x)).value_or(std::nan("")));
    series.y.push_back(table.Number(row, table.Column(y)).value_or(std::nan("")));
  }
  return series;
}

LineChart AnglesChart(const fs::path& program) {
  const CsvTable table = CsvTable::Read(program);
  LineChart chart;
  chart.title = "Knee angles";
  chart.x = {"sit-to-stand (%)", 0, 100}, chart.y.label = "knee flexion (°)";
  chart.width = Width::kHalf;
  chart.caption = "The human's, and the design's under its stroke program.";
  chart.series = {ColumnSeries(table, "percent", "human_knee_deg", "human", colour::kHuman, Mark::kLine),
                  ColumnSeries(table, "percent", "knee_deg", "new design", colour::kHip, Mark::kDashed)};
  return chart;
}

LineChart ParetoChart(const Json& summary) {
  LineChart chart;
  chart.title = "What range costs in misalignment";
  chart.alt = "Pareto fronts: the least misalignment for each range of rotation";
  chart.caption = "Each point is a design of its own; none has more range and less misalignment.";
  chart.x.label = "range of rotation (°)", chart.y = {"misalignment, RMS (% of the shank)", 0, std::nullopt};
  for (const Json& front : summary.at("pareto")) {
    Series series;
    series.name = front.at("program").get<std::string>() + " program";
    for (const Json& point : front.at("range_deg_and_misalignment_percent"))
      series.x.push_back(NumberOrNaN(point.at(0))), series.y.push_back(NumberOrNaN(point.at(1)));
    chart.series.push_back(std::move(series));
  }
  double least_deg = NumberOrNaN(summary.at("range_deg")), most_deg = least_deg;
  for (const Series& front : chart.series)
    for (const double range_deg : front.x)
      least_deg = std::min(least_deg, range_deg), most_deg = std::max(most_deg, range_deg);
  chart.x.from = std::floor(least_deg / 5 - 0.2) * 5, chart.x.to = std::ceil(most_deg / 5 + 0.2) * 5;
  Series design;
  design.name = "the design", design.mark = Mark::kPoints, design.colour = colour::kText;
  design.x = {NumberOrNaN(summary.at("range_deg"))}, design.y = {NumberOrNaN(summary.at("misalignment_percent"))};
  chart.series.push_back(std::move(design));
  return chart;
}

// How far the actuator may be from its plan, and whether that leaves the linkage's room.
std::string DriftText(const Json& firmware) {
  const Json &drift = firmware.at("drift"), &nearest = drift.at("nearest");
  std::string text = fmt::format(
      " With speeds within {:.3g} % of the duty table the actuator is at {:.2f} ± {:.2f} mm where it comes nearest to "
      "the "
      "linkage's end at {:.2f} mm.",
      NumberOrNaN(drift.at("tolerance_percent")), NumberOrNaN(nearest.at("planned_mm")),
      NumberOrNaN(nearest.at("drift_mm")), NumberOrNaN(drift.at("end_mm")));
  text += fmt::format(" The retract end stop belongs at {:.2f} mm", NumberOrNaN(firmware.at("home_stroke_mm")));
  if (firmware.at("extend_stop_mm").is_number())
    text += fmt::format(", the extend end stop, which ends what the drift carries too far, at {:.2f} mm",
                        NumberOrNaN(firmware.at("extend_stop_mm")));
  text += '.';
  if (drift.at("accepted").get<bool>())
    text += " This drift was accepted: the firmware is only for a bench without a person.";
  return text;
}

}  // namespace

Section RedesignChapter(const StudyResults& results) {
  const Json summary = results.Summary("redesign");
  Section section{"The design for this person", {BeforeAfterFigures(summary)}};
  section.blocks.push_back(Paragraph{summary.at("build_text").get<std::string>()});
  section.blocks.push_back(Paragraph{summary.at("trial_text").get<std::string>()});
  section.blocks.push_back(PathsChart(results));
  section.blocks.push_back(AnglesChart(results.Folder() / "redesign/program.csv"));
  section.blocks.push_back(BeforeAfterTable(summary));
  if (List active = ActiveList(summary); !active.items.empty()) {
    section.blocks.push_back(Paragraph{"At their limits, with what a step further would bring where that is known:"});
    section.blocks.push_back(std::move(active));
  }
  if (summary.contains("pareto")) section.blocks.push_back(ParetoChart(summary));
  return section;
}

Section StrokeChapter(const StudyResults& results) {
  const Json summary = results.Summary("stroke");
  const CsvTable table = CsvTable::Read(results.Folder() / "stroke/program.csv");
  LineChart stroke, knee;
  stroke.title = "Stroke over time", stroke.x.label = "time (s)", stroke.y.label = "stroke (mm)";
  stroke.series = {ColumnSeries(table, "time_s", "stroke_mm", "stroke", colour::kAnkle, Mark::kLine)};
  knee.title = "Knee angle that it makes", knee.x.label = "time (s)", knee.y.label = "knee flexion (°)";
  knee.series = {ColumnSeries(table, "time_s", "knee_deg", "knee", colour::kHip, Mark::kLine)};
  stroke.width = knee.width = Width::kHalf;
  const Json& limits = summary.at("soft_limits_mm");
  std::string text = fmt::format(
      "The actuator goes from {:.2f} to {:.2f} mm in {:.2f} s, at most at {:.2f} mm/s; it may be sent to {:.2f} to "
      "{:.2f} mm.",
      NumberOrNaN(summary.at("start").at("stroke_mm")), NumberOrNaN(summary.at("end").at("stroke_mm")),
      NumberOrNaN(summary.at("duration_s")), NumberOrNaN(summary.at("largest_speed_mm_s")), NumberOrNaN(limits.at(0)),
      NumberOrNaN(limits.at(1)));
  if (const double rest_s = NumberOrNaN(summary.at("added_rest_s")); rest_s >= 0.005)
    text += fmt::format(" Of that {:.2f} s are rests that the controller adds to the design's program.", rest_s);
  if (summary.at("firmware").is_object())
    text += fmt::format(" The firmware for the UNO lies beside, {} segments, its plan within {:.3f} mm.",
                        summary["firmware"].at("segments").get<int>(),
                        NumberOrNaN(summary["firmware"].at("rounding_error_mm"))) +
            DriftText(summary["firmware"]);
  return {"The actuator's program", {Paragraph{std::move(text)}, std::move(stroke), std::move(knee)}};
}

}  // namespace lake::study
