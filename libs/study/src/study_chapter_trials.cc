#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <vector>

#include "lake/core/colours.h"
#include "lake/core/deviation_text.h"
#include "lake/core/statistics.h"
#include "lake/core/uncertain_text.h"
#include "lake/gait/gait_cycles.h"
#include "lake/motion/leg_motion.h"
#include "lake/report/misalignment_sections.h"
#include "study_chapters.h"

namespace lake::study {

using namespace report;

namespace {

namespace fs = std::filesystem;

struct TrialNames {
  const char *step, *what, *colour;
};
constexpr TrialNames kHuman{"human", "without exoskeleton", colour::kHuman};
constexpr TrialNames kExo{"exo", "with exoskeleton", colour::kExoskeleton};

std::vector<double> RiseTimes(const Json& summary) {
  std::vector<double> seconds;
  for (const Json& rise : summary.at("sit_to_stands"))
    if (rise.contains("duration_s")) seconds.push_back(rise["duration_s"]);
  return seconds;
}

// "436.0 mm, SD 0.12 mm"
Cell SegmentCell(const Json& summary, const std::string& name) {
  for (const Json& segment : summary.at("segments"))
    for (const char* unit : {"mm", "px"})
      if (segment.at("name") == name && segment.contains(fmt::format("length_{}", unit)))
        return fmt::format(
            "{:.1f} {}, SD {}", NumberOrNaN(segment[fmt::format("length_{}", unit)]), unit,
            DeviationText(NumberOrNaN(segment[fmt::format("variation_{}", unit)]), 2, fmt::format(" {}", unit)));
  return "–";
}

Cell DetectedCell(const Json& summary) {
  int detected = 0, all = 0;
  for (const Json& marker : summary.at("markers")) {
    detected += marker["detected"].get<int>();
    all += marker["detected"].get<int>() + marker["filled"].get<int>() + marker["missing"].get<int>();
  }
  return fmt::format("{:.1f} %", all > 0 ? 100.0 * detected / all : 0.0);
}

Cell KneeCell(const Json& summary) {
  const Json& knee = summary.at("knee");
  if (knee.at("largest").is_null()) return "–";
  return fmt::format("{:.1f}° to {:.1f}°, marker noise {} (SD)", NumberAt(knee, "smallest/deg"),
                     NumberAt(knee, "largest/deg"), DeviationText(NumberAt(knee, "rms_sigma_deg"), 3, "°"));
}

Cell RecordingCell(const StudyTrial& trial, const Json& summary) {
  std::string text = trial.Recording().filename().string();
  if (summary.contains("video"))
    text += fmt::format(", {} frames of {}×{} px at {} Hz", summary["video"]["frames"].get<int>(),
                        summary["video"]["width"].get<int>(), summary["video"]["height"].get<int>(),
                        SignificantText(NumberAt(summary, "video/frame_rate_hz"), 4));
  return text;
}

std::vector<Cell> TrialColumn(const StudyTrial& trial, const Json& summary) {
  const std::vector<double> rises = RiseTimes(summary);
  std::string times = "none found";
  if (const Json walking = summary.value("walking", Json()); walking.is_object() && walking.at("strides") != 0)
    times = fmt::format(
        "{} strides, {} s (SD)", walking["strides"].get<int>(),
        PlusMinusText(NumberAt(walking, "measures/stride_s/mean"), NumberAt(walking, "measures/stride_s/sd"), 2));
  if (rises.size() == 1) times = fmt::format("1, {:.1f} s", rises.front());
  if (rises.size() > 1)
    times = fmt::format("{}, {} s (SD)", rises.size(), PlusMinusText(Mean(rises), StandardDeviation(rises), 1));
  return {
      RecordingCell(trial, summary), times, KneeCell(summary), SegmentCell(summary, "ak"), SegmentCell(summary, "kh"),
      DetectedCell(summary)};
}

Table TrialsTable(const StudyFile& study, const StudyResults& results) {
  Table table{"Trials",
              {{"Quantity"}},
              {{"recording"},
               {RepetitionIn(results) == "rise" ? "rises (onset to standing), and their mean time"
                                                : "whole strides, and their mean time"},
               {"knee angle: range, and standard deviation of a sample"},
               {"shank, ankle to knee"},
               {"thigh, knee to hip"},
               {"marker samples detected"}}};
  const auto add = [&](const TrialNames& names, const StudyTrial& trial) {
    table.columns.push_back({names.what});
    const std::vector<Cell> column = TrialColumn(trial, results.Summary(names.step));
    for (std::size_t row = 0; row < column.size(); ++row) table.rows[row].push_back(column[row]);
  };
  add(kHuman, study.human);
  if (study.exo) add(kExo, *study.exo);
  return table;
}

// `of`: "rise" or "stride".
void AddRepetitions(const motion::LegMotion& motion, const std::string& of, LineChart& chart) {
  std::map<int, std::pair<double, double>> times;
  for (std::size_t i = 0; i < motion.samples.size(); ++i)
    if (const auto& repetition = motion.samples[i].repetition)
      times.try_emplace(*repetition, motion.time_s[i], 0).first->second.second = motion.time_s[i];
  for (const auto& [repetition, time_s] : times)
    chart.intervals.push_back({time_s.first, time_s.second, fmt::format("{} {}", of, repetition)});
}

// What was measured of the strides, mean and standard deviation over them; no rows where nobody walks.
Table StridesTable(const StudyResults& results) {
  Table table{"Strides: mean and standard deviation over them",
              {{"Quantity"}, {"without exoskeleton"}, {"with exoskeleton"}}};
  const auto measures = [&](const TrialNames& names) {
    return results.Has(names.step) ? results.Summary(names.step).value("/walking/measures"_json_pointer, Json())
                                   : Json();
  };
  const Json human = measures(kHuman), exo = measures(kExo);
  for (const gait::Field<gait::GaitCycle>& field : gait::GaitCycle::Fields()) {
    const auto cell = [&](const Json& of) -> std::string {
      const std::string column = field.Column(motion::LengthUnit::kMm);
      if (!of.contains(column) || of[column].at("mean").is_null()) return "–";
      return PlusMinusText(NumberOrNaN(of[column]["mean"]), NumberOrNaN(of[column]["sd"]), field.digits);
    };
    if (const std::string without = cell(human), with = cell(exo); without != "–" || with != "–")
      table.rows.push_back({fmt::format("{} ({})", field.meaning, field.Unit(motion::LengthUnit::kMm)), without, with});
  }
  return table;
}

// The band of the joint beneath the skin; without one where the recording's budget is not known (lengths in px).
std::optional<Series> BeneathTheSkin(const Series& knee, const Json& summary) {
  const Json sd_deg = Find(summary, "uncertainty/knee_angle_deg/anatomical_sd");
  if (sd_deg.is_null()) return std::nullopt;
  Series beneath{.name = "beneath the skin", .x = knee.x, .y = knee.y, .colour = colour::kGuide, .mark = Mark::kThin};
  const double half_deg = 2 * NumberOrNaN(sd_deg);
  for (const double knee_deg : knee.y) {
    beneath.lower.push_back(knee_deg - half_deg);
    beneath.upper.push_back(knee_deg + half_deg);
  }
  return beneath;
}

LineChart KneeChart(const StudyResults& results, const TrialNames& names) {
  const fs::path folder = results.Folder() / names.step;
  const motion::LegMotion motion = motion::ReadKinematicsCsv(folder / "kinematics.csv");
  LineChart chart;
  chart.title = fmt::format("Knee angle, {}", names.what);
  chart.x.label = "time (s)";
  chart.y.label = "knee flexion (°)";
  chart.width = Width::kHalf;
  Series knee;
  knee.name = "knee";
  knee.colour = names.colour;
  for (std::size_t i = 0; i < motion.samples.size(); i += ChartStep(motion.samples.size())) {
    const motion::LegSample& sample = motion.samples[i];
    knee.x.push_back(motion.time_s[i]);
    knee.y.push_back(sample.knee_deg);
    knee.lower.push_back(sample.knee_deg - 2 * sample.knee_sigma_deg);
    knee.upper.push_back(sample.knee_deg + 2 * sample.knee_sigma_deg);
  }
  auto beneath = BeneathTheSkin(knee, results.Summary(names.step));
  const std::string of = RepetitionIn(results);
  chart.caption =
      fmt::format("{} Shaded: {}.",
                  beneath ? "Bands: ± 2 standard deviations, of the markers and of the knee beneath the skin."
                          : "Band: ± 2 standard deviations, of the markers.",
                  of == "rise" ? "from onset to standing" : "whole strides");
  if (beneath) chart.series.push_back(*std::move(beneath));
  chart.series.push_back(std::move(knee));
  AddRepetitions(motion, of, chart);
  return chart;
}

// The same angles at the same height, so that the trials can be compared.
void ShareAxis(std::vector<LineChart>& charts) {
  double least_deg = std::numeric_limits<double>::infinity(), most_deg = -least_deg;
  for (const LineChart& chart : charts)
    for (const Series& series : chart.series)
      for (const std::vector<double>* angles_deg : {&series.lower, &series.upper})
        for (const double knee_deg : *angles_deg)
          if (std::isfinite(knee_deg)) {
            least_deg = std::min(least_deg, knee_deg);
            most_deg = std::max(most_deg, knee_deg);
          }
  if (least_deg > most_deg) return;
  constexpr double kStep_deg = 10;
  for (LineChart& chart : charts) {
    chart.y.from = std::floor(least_deg / kStep_deg) * kStep_deg;
    chart.y.to = std::ceil(most_deg / kStep_deg) * kStep_deg;
  }
}

// The interval of the headline by the markers alone, with skin movement, and what would narrow it.
std::string BudgetText(const Json& comparison) {
  const Json rms = Find(comparison, "uncertainty/joint_rms_mm");
  if (rms.is_null()) return "";
  const int decimals = FactOf(comparison, kJointRms).Decimals();
  const auto interval = [&](const char* name) {
    return fmt::format("{} to {} mm", RoundedText(NumberOrNaN(rms.at(name)[0]), decimals),
                       RoundedText(NumberOrNaN(rms.at(name)[1]), decimals));
  };
  return fmt::format(
      "The joint misalignment is {} mm RMS between the joints beneath the skin: {} with all sources, {} of the markers "
      "alone (95 % each). {} Each source is in comparison/uncertainty_budget.csv.",
      RoundedText(NumberAt(rms, "value"), decimals), interval("anatomical_interval"), interval("marker_interval"),
      rms.at("narrower").get<std::string>());
}

}  // namespace

Section TrialsChapter(const StudyFile& study, const StudyResults& results) {
  Section section{"Recordings", {TrialsTable(study, results)}};
  std::vector<LineChart> charts = {KneeChart(results, kHuman)};
  if (study.exo) charts.push_back(KneeChart(results, kExo));
  ShareAxis(charts);
  for (LineChart& chart : charts) section.blocks.push_back(std::move(chart));
  if (Table strides = StridesTable(results); !strides.rows.empty()) section.blocks.push_back(std::move(strides));
  return section;
}

Section MisalignmentChapter(const StudyFile&, const StudyResults& results) {
  const Json comparison = ReadJsonFile(results.Folder() / "comparison" / "comparison.json");
  LineChart paths = KneePathsChart(comparison), error = PathDifferenceChart(comparison);
  BarChart parts = DecompositionChart(comparison);
  paths.width = error.width = parts.width = Width::kHalf;
  Section section{"Knee misalignment", {MisalignmentKeyFigures(comparison), std::move(paths)}};
  if (!results.Has("redesign")) section.blocks.push_back(std::move(error));  // else the first screen has it
  section.blocks.push_back(std::move(parts));
  section.blocks.push_back(Paragraph{DecompositionAdvice(comparison)});
  section.blocks.push_back(
      Paragraph{"Placement is an offset constant in the frame of the shank, which moving the joint removes; timing "
                "is a change of pace within the repetition; shape is the rest."});
  if (std::string budget = BudgetText(comparison); !budget.empty())
    section.blocks.push_back(Paragraph{std::move(budget)});
  return section;
}

}  // namespace lake::study
