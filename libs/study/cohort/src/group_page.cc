#include "group_page.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "lake/core/colours.h"
#include "lake/core/counted.h"
#include "lake/core/error.h"
#include "lake/core/statistics.h"
#include "lake/figure/charts.h"
#include "lake/gait/gait_cycles.h"
#include "lake/gait/sit_to_stand.h"
#include "lake/report/uncertain.h"

namespace lake::cohort {

using namespace report;

namespace {

namespace fs = std::filesystem;

// In words, with the unit: a column of trials.csv that both trials have.
std::string NameOf(const std::string& column) {
  constexpr auto kMm = motion::LengthUnit::kMm;
  const auto name_in = [&](const auto& fields) -> std::string {
    for (const auto& field : fields)
      if (column == field.Column(kMm)) return fmt::format("{} ({})", field.meaning, field.Unit(kMm));
    return "";
  };
  if (std::string name = name_in(gait::SitToStand::Fields()); !name.empty()) return name;
  constexpr std::pair<std::string_view, const char*> kNames[] = {
      {"five_times_power_w_kg", "mean power of the five-times test (W/kg)"},
      {"com_forward_seat_off_mm_s", "speed forward of the centre of mass at seat-off (mm/s)"},
      {"com_forward_lead_s", "from the centre of mass's largest speed forward to seat-off (s)"},
      {"com_forward_max_ns", "largest momentum forward (N s)"},
      {"com_upward_max_ns", "largest momentum upward (N s)"},
      {"knee_min_deg", "smallest knee angle (°)"},
      {"knee_range_deg", "knee range (°)"},
      {"shank_max_deg", "largest shank lean (°)"},
      {"shank_mm", "shank, knee to ankle (mm)"},
      {"thigh_mm", "thigh, hip to knee (mm)"}};
  for (const auto& [known, name] : kNames)
    if (column == known) return name;
  const std::string name = name_in(gait::GaitCycle::Fields());
  return name.empty() ? column : name;
}

const MainQuantity* FindMain(const std::string& trial, const std::string& name) {
  for (const MainQuantity& main : MainQuantities())
    if (main.trial == trial && main.name == name) return &main;
  return nullptr;
}

std::string IntervalText(const reliability::Interval& interval, int decimals) {
  if (std::isnan(interval.low) && std::isnan(interval.high)) return "–";  // of a single participant
  return fmt::format("{} to {}", NumberText(interval.low, decimals), NumberText(interval.high, decimals));
}

std::string EstimateText(const reliability::Estimate& estimate, int decimals) {
  return fmt::format("{} ({})", NumberText(estimate.value, decimals), IntervalText(estimate.interval, decimals));
}

KeyFigure MeanFigure(const GroupData& group, const char* trial, const char* name) {
  const MainQuantity& main = *FindMain(trial, name);
  std::vector<double> values;
  for (const std::string& participant : ParticipantsOf(group))
    if (const auto value = ValueOf(group, participant, trial, name)) values.push_back(*value);
  const reliability::MeanOfSubjects of = reliability::MeanOf(values);
  KeyFigure figure{.label = main.label, .value = of.mean.value, .decimals = main.decimals, .unit = main.unit};
  if (of.subjects > 1) {
    figure.plus_minus = of.standard_deviation;
    figure.note = fmt::format("mean ± SD of {}; 95 % interval of the mean {} {}", of.subjects,
                              IntervalText(of.mean.interval, main.decimals), main.unit);
  }
  return figure;
}

Section ResultSection(const Workflow& workflow, const GroupData& group, const GroupFindings& findings) {
  Section section{"Result", {}};
  KeyFigures figures;
  figures.figures.push_back(
      {.label = "participants", .value = static_cast<double>(ParticipantsOf(group).size()), .decimals = 0});
  figures.figures.push_back(
      {.label = "recordings",
       .value = static_cast<double>(workflow.studies.size()),
       .decimals = 0,
       .note = findings.failures.empty() ? "all done" : fmt::format("{} not done", findings.failures.size())});
  for (const auto& [trial, name] : {std::pair{"human", "rise_s"},
                                    {"exo", "rise_s"},
                                    {"human", "stride_s"},
                                    {"exo", "stride_s"},
                                    {"human", "speed_mm_s"},
                                    {"exo", "speed_mm_s"},
                                    {"human", "knee_range_deg"},
                                    {"exo", "knee_range_deg"},
                                    {"comparison", "joint_rms_mm"},
                                    {"comparison", "rms_mm"},
                                    {"design", "range_deg"}}) {
    KeyFigure figure = MeanFigure(group, trial, name);
    if (std::isfinite(figure.value)) figures.figures.push_back(std::move(figure));
  }
  section.blocks.push_back(std::move(figures));
  return section;
}

Section FailuresSection(const std::vector<Failure>& failures) {
  Table table{"What was not done", {{"Recordings"}, {"Step"}, {"Error"}}};
  for (const Failure& failure : failures)
    table.rows.push_back(
        {Recordings{failure.participant, failure.session, failure.run, {}, {}}.Name(), failure.step, failure.error});
  return {"Failures", {std::move(table), Paragraph{"The steps after these were not begun; all others count."}}};
}

// nullptr where there is no such curve.
const CurveRow* FindCurve(const std::vector<CurveRow>& curves, const std::string& trial, const std::string& quantity) {
  for (const CurveRow& row : curves)
    if (row.trial == trial && row.quantity == quantity) return &row;
  return nullptr;
}

// The mean with its band; with `all` each participant's own curve too.
void AddCurve(const CurveRow* row, const std::string& name, const char* colour, Mark mark, bool all, LineChart& chart) {
  if (!row) return;
  Series mean{.name = name, .colour = colour, .mark = mark};
  for (int percent = 0; percent < kPercents; ++percent) {
    const reliability::Estimate& of = row->percent[static_cast<std::size_t>(percent)].mean;
    mean.x.push_back(percent);
    mean.y.push_back(of.value);
    mean.lower.push_back(of.interval.low);
    mean.upper.push_back(of.interval.high);
  }
  if (row->participants.size() < 2) {
    mean.lower.clear();
    mean.upper.clear();
  }
  chart.series.push_back(mean);
  if (!all) return;
  for (const auto& [participant, curve] : row->participants) {
    chart.series.push_back({.name = participant, .x = mean.x, .y = {curve.begin(), curve.end()}, .mark = Mark::kThin});
  }
}

// With and without exoskeleton, or of what is compared between them.
LineChart CurveChart(const GroupFindings& findings, const GroupFigure& figure) {
  LineChart chart{.title = figure.title,
                  .caption = "Mean over participants; band: 95 % interval of the mean at each percent.",
                  .x = {findings.repetition + " (%)", 0, 100},
                  .y = {.label = figure.axis},
                  .width = Width::kHalf};
  for (const auto& [trial, name, colour, mark] :
       {std::tuple{"human", "without exoskeleton", colour::kHuman, Mark::kLine},
        std::tuple{"exo", "with exoskeleton", colour::kExoskeleton, Mark::kDashed},
        std::tuple{"comparison", "with exoskeleton", colour::kExoskeleton, Mark::kDashed}})
    if (const CurveRow* row = FindCurve(findings.curves, trial, figure.quantity))
      AddCurve(row, fmt::format("{} (n = {})", name, row->participants.size()), colour, mark, false, chart);
  return chart;
}

LineChart EveryoneChart(const GroupFindings& findings, const char* trial, const char* quantity, const char* title,
                        const char* axis) {
  LineChart chart{.title = title,
                  .caption = "Thin: each participant; a click on a name hides it.",
                  .x = {findings.repetition + " (%)", 0, 100},
                  .y = {.label = axis},
                  .width = Width::kHalf};
  AddCurve(FindCurve(findings.curves, trial, quantity), "mean", colour::kText, Mark::kLine, true, chart);
  return chart;
}

Section CurvesSection(const GroupFindings& findings) {
  Section section{"Over the " + findings.repetition, {}};
  const auto add = [&](LineChart chart) {
    if (!chart.series.empty()) section.blocks.push_back(std::move(chart));
  };
  for (const GroupFigure& figure : {kGroupFigures[0], kGroupFigures[1]}) add(CurveChart(findings, figure));
  add(EveryoneChart(findings, "human", "knee_deg", "Knee angle without exoskeleton, everyone", "knee flexion (°)"));
  add(EveryoneChart(findings, "exo", "knee_deg", "Knee angle with exoskeleton, everyone", "knee flexion (°)"));
  add(EveryoneChart(findings, "comparison", "distance_mm", "Misalignment of the knees, everyone", "distance (mm)"));
  return section;
}

Section DifferencesSection(const std::vector<DifferenceRow>& rows) {
  Table table{"With exoskeleton minus without, in the same participants",
              {{"Quantity"}, {"Participants"}, {"Without"}, {"With"}, {"Difference"}, {"95 % interval"}}};
  for (const DifferenceRow& row : rows) {
    const int decimals = row.quantity.ends_with("_s") && !row.quantity.ends_with("deg_s") ? 2 : 1;
    table.rows.push_back({NameOf(row.quantity), fmt::format("{}", row.difference.subjects), Number{row.human, decimals},
                          Number{row.exo, decimals}, Number{row.difference.mean.value, decimals},
                          IntervalText(row.difference.mean.interval, decimals)});
  }
  const auto certain = static_cast<std::size_t>(
      std::ranges::count_if(rows, [](const DifferenceRow& row) { return std::isfinite(row.StandardErrors()); }));
  if (certain == 0) return {"Differences", {std::move(table)}};
  const auto beyond_zero = [&](std::size_t comparisons) {
    return std::ranges::count_if(rows, [&](const DifferenceRow& row) { return row.IsClearAmong(comparisons); });
  };
  return {"Differences",
          {std::move(table),
           Paragraph{fmt::format(
               "The largest differences, relative to their standard errors, come first. {}: where nothing differs, "
               "chance alone puts about {} of the intervals beside 0; here {} lie beside it, and {} with the intervals "
               "widened for so many comparisons (Bonferroni).",
               Counted(certain, "comparison"), NumberText(0.05 * static_cast<double>(certain), 1), beyond_zero(1),
               beyond_zero(certain))}}};
}

std::string EnoughText(const std::vector<ReliabilityRow>& rows) {
  std::size_t fewest = SIZE_MAX;
  for (const ReliabilityRow& row : rows) fewest = std::min(fewest, static_cast<std::size_t>(row.squares.targets));
  return IccCaution(fewest);
}

Section ReliabilitySection(const std::vector<ReliabilityRow>& rows) {
  Table table{"Repeated measurements",
              {{"Quantity"},
               {"Across"},
               {"Participants"},
               {"ICC(2,1)"},
               {"ICC(3,1)"},
               {"SEM"},
               {"MDC95"},
               {"Bias"},
               {"Limits of agreement"}}};
  for (const ReliabilityRow& row : rows) {
    const MainQuantity* main = FindMain(row.trial, row.quantity);
    if (!main) continue;
    const int decimals = main->decimals + 1;
    table.rows.push_back({fmt::format("{} ({})", main->label, main->unit),
                          fmt::format("{} {}s", row.squares.judges, row.across), fmt::format("{}", row.squares.targets),
                          EstimateText(row.icc2, 2), EstimateText(row.icc3, 2), EstimateText(row.sem, decimals),
                          Number{row.mdc95, decimals}, EstimateText(row.agreement.bias, decimals),
                          fmt::format("{} to {}", NumberText(row.agreement.lower.value, decimals),
                                      NumberText(row.agreement.upper.value, decimals))});
  }
  return {"Reliability",
          {std::move(table), Paragraph{EnoughText(rows)},
           Paragraph{"In brackets 95 % intervals. ICC(2,1): agreement, systematic differences between sessions or "
                     "repetitions count; ICC(3,1): consistency, they do not (Shrout & Fleiss 1979). SEM: the standard "
                     "error of one measurement; MDC95 = 1.96 √2 SEM: the least change of one person that is not error "
                     "(Weir 2005). Bias: the second minus the first; 95 % of such differences lie between the limits "
                     "(Bland & Altman 1999). reliability.csv has all quantities."}}};
}

std::string RuleText(const Json& rule) {
  const auto name = [&] {
    for (const auto& [known, text] : {std::pair{"height_mm", "body height"},
                                      {"leg_mm", "shank and thigh together"},
                                      {"shank_mm", "shank, knee to ankle"},
                                      {"thigh_mm", "thigh, hip to knee"}})
      if (rule["quantity"] == known) return text;
    return "";
  };
  std::string text;
  if (rule["ranges"].size() == 1)
    text = fmt::format("No quantity of the body predicts who needs which size: the next participant gets size {}.",
                       rule["ranges"][0]["size"].get<int>());
  else
    for (const Json& range : rule["ranges"])
      text += fmt::format(
          "{}size {}{}", text.empty() ? fmt::format("The next participant gets, by {}, ", name()) : ", ",
          range["size"].get<int>(),
          range["to_mm"].is_number() ? fmt::format(" up to {:.0f} mm", range["to_mm"].get<double>()) : " beyond.");
  return fmt::format("{} With each left out in turn it gives {} of {} the size that they wear, and {} keep the limits.",
                     text, rule["left_out_same_size"].get<int>(), rule["left_out"].get<int>(),
                     rule["left_out_hold"].get<int>());
}

// What the design for all, or each size, is to whom.
Section PopulationSection(const Json& summary) {
  const bool has_sizes = summary.contains("sizes");
  Section section{has_sizes ? "Sizes for all" : "One design for all", {}};
  Table designs{"Designs", {{"Size"}, {"Range (°)"}, {"Largest misalignment (% of the shank)"}}};
  const auto add = [&](const std::string& name, const Json& design) {
    designs.rows.push_back(
        {name, Number{NumberAt(design, "range_deg"), 1}, Number{NumberAt(design, "misalignment_percent"), 2}});
  };
  if (has_sizes) {
    for (const Json& size : summary["sizes"]) add(fmt::format("{}", size["size"].get<int>()), size);
    section.blocks.push_back(std::move(designs));
    section.blocks.push_back(Paragraph{RuleText(summary["rule"])});
  }
  Table people{has_sizes ? "Who wears which" : "What it is to each",
               {{"Participant"}, {"Size"}, {"Misalignment (% of the shank)"}, {"Costs, against their own (°)"}}};
  for (const Json& person : summary["people"])
    people.rows.push_back({person["person"].get<std::string>(), fmt::format("{}", person["size"].get<int>()),
                           Number{NumberAt(person, "misalignment_percent"), 2},
                           Number{NumberAt(person, "cost_deg"), 1}});
  if (!has_sizes)
    section.blocks.push_back(Paragraph{fmt::format(
        "The links with the largest range that all wear, each with placement and program of their own: {:.1f}°. "
        "population/design.yaml has them.",
        NumberAt(summary, "range_deg"))});
  section.blocks.push_back(std::move(people));
  section.blocks.push_back(Paragraph{
      "The cost is the range of the best design for this participant alone, under the same limits, less that of the "
      "common one. population/people.csv has placement, program and those designs."});
  return section;
}

Section OutliersSection(const std::vector<OutlierRow>& rows) {
  Table table{"Participants far from the others", {{"Participant"}, {"Why"}}};
  for (const OutlierRow& row : rows) table.rows.push_back({row.participant, row.Why()});
  return {"Outliers",
          {std::move(table), Paragraph{"More than 3.5 robust standard deviations from the median (Iglewicz & Hoaglin "
                                       "1993). They count in all tables above."}}};
}

// A participant's own page, or the picture that shows most; without either the name alone.
Cell LinkTo(const fs::path& study, const fs::path& out, const std::string& participant) {
  for (const char* file : {"report.html", "comparison/report.html", "human/track.png", "human/gait.png"})
    if (fs::is_regular_file(study / file))
      return Link{fs::path("..") / (study / file).lexically_relative(out), participant};
  return participant;
}

// Of one trial of one recording, over its repetitions; NaN where nothing is known.
double MeanIn(const std::vector<const GroupRow*>& rows, const char* trial, const char* quantity) {
  std::vector<double> values;
  for (const GroupRow* row : rows)
    if (row->trial == trial)
      if (const auto found = row->values.find(quantity); found != row->values.end()) values.push_back(found->second);
  return values.empty() ? std::nan("") : Mean(values);
}

// A row each recording and condition.
Section StudiesSection(const Workflow& workflow, const GroupData& group) {
  const bool is_walk = group.movement == gait::MovementKind::kWalking;
  const char *duration = is_walk ? "stride_s" : "rise_s", *lean = is_walk ? "trunk_range_deg" : "trunk_max_deg";
  std::map<std::array<std::string, 3>, std::vector<const GroupRow*>> of_recordings;
  for (const GroupRow& row : group.rows) of_recordings[{row.participant, row.session, row.run}].push_back(&row);
  Table table{"Means over the repetitions of each recording",
              {{"Participant"},
               {"Session"},
               {"Run"},
               {"Exoskeleton"},
               {is_walk ? "Stride time (s)" : "Rise time (s)", 2},
               {"Knee range (°)", 1},
               {is_walk ? "Trunk range (°)" : "Trunk lean (°)", 1},
               {"Misalignment, RMS (mm)", 1}},
              {},
              Width::kFull,
              {0, 1, 2, 3}};
  for (const WorkflowStudy& of : workflow.studies) {
    const std::vector<const GroupRow*>& rows = of_recordings[{of.participant, of.session, of.run}];
    for (const auto& [trial, condition] : {std::pair{"human", "without"}, {"exo", "with"}}) {
      if (std::ranges::none_of(rows, [&, trial = trial](const GroupRow* row) { return row->trial == trial; })) continue;
      const bool is_exo = std::string_view(trial) == "exo";
      table.rows.push_back({LinkTo(of.folder, workflow.out, of.participant), of.session, of.run, condition,
                            MeanIn(rows, trial, duration), MeanIn(rows, trial, "knee_range_deg"),
                            MeanIn(rows, trial, lean), is_exo ? MeanIn(rows, "comparison", "rms_mm") : std::nan("")});
    }
  }
  return {"Each participant",
          {Paragraph{"A name leads to the participant's own page. With one chosen, the charts of everyone show that "
                     "participant's curve alone beside the mean."},
           std::move(table)}};
}

Section TablesSection() {
  return {"Tables",
          {Files{{{"trials.csv", "every number of every trial and repetition"},
                  {"curves.csv", "mean, standard deviation and 95 % interval over 0 to 100 %"},
                  {"reliability.csv", "ICC, SEM, MDC95, limits of agreement"},
                  {"differences.csv", "with exoskeleton minus without"},
                  {"outliers.csv", "who is far from the others, and in what"},
                  {"failures.csv", "what was not done, and why"}}}}};
}

// For a paper.
Section FiguresSection(const std::vector<CurveRow>& curves) {
  Files files;
  for (const GroupFigure& figure : kGroupFigures)
    if (std::ranges::find(curves, figure.quantity, &CurveRow::quantity) != curves.end())
      for (const std::string& file : figure.Files())
        files.files.push_back({file, fmt::format("{}, means with their 95 % bands", figure.title)});
  return {"Figures", {std::move(files)}};
}

}  // namespace

void DrawGroupFigures(const GroupFindings& findings, Run& run) {
  for (const GroupFigure& figure : kGroupFigures)
    if (const LineChart chart = CurveChart(findings, figure); !chart.series.empty())
      for (const std::string& file : figure.Files()) figure::DrawCharts(run.Result(file), {chart});
}

Report MakeGroupPage(const Workflow& workflow, const GroupData& group, const GroupFindings& findings,
                     const Json& head) {
  Report page{workflow.name,
              fmt::format("With and without exoskeleton, over a group: {}", gait::MovementOf(group.movement).name),
              {},
              {}};
  for (const Failure& failure : findings.failures) page.warnings.push_back(failure.Text());
  page.sections.push_back(ResultSection(workflow, group, findings));
  page.sections.push_back(CurvesSection(findings));
  if (!findings.differences.empty()) page.sections.push_back(DifferencesSection(findings.differences));
  if (!findings.reliability.empty()) page.sections.push_back(ReliabilitySection(findings.reliability));
  const bool has_population =
      workflow.has_population &&
      std::ranges::none_of(findings.failures, [](const Failure& failure) { return failure.step == kPopulationStep; });
  if (const fs::path summary = workflow.out / "group" / "population" / "summary.json"; has_population)
    page.sections.push_back(PopulationSection(ReadJsonFile(summary)));
  if (!findings.outliers.empty()) page.sections.push_back(OutliersSection(findings.outliers));
  if (!findings.failures.empty()) page.sections.push_back(FailuresSection(findings.failures));
  page.sections.push_back(StudiesSection(workflow, group));
  if (!findings.curves.empty()) page.sections.push_back(FiguresSection(findings.curves));
  page.sections.push_back(TablesSection());
  page.sections.push_back(ProvenanceSection(head));
  return page;
}

}  // namespace lake::cohort
