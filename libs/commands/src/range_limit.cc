#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/uncertain_text.h"
#include "lake/report/report.h"
#include "movement_tables.h"

namespace lake::commands {
namespace {

using namespace report;

constexpr double kCoverage = 2;
constexpr double kMostUnknown_percent = 5;

// Frames in which the angle was not measured, as a marker was hidden: the fit's bridge over them is no test of a limit.
struct Unknown {
  int frames = 0;
  double percent = 0;  // of those between the first and the last measured angle
};

// One end of the range, in the frame that is nearest to its limit, U counted.
struct End {
  std::string name;
  double limit_deg = 0;
  int towards = 1;  // 1: the upper one
  double measured_deg = 0, time_s = 0, expanded_deg = 0;
  int visits = 0;       // how often the mechanism went to this end
  bool is_seen = true;  // in enough of the frames

  double MarginDeg() const { return towards * (limit_deg - measured_deg); }
  bool IsInside() const { return MarginDeg() >= expanded_deg; }
  bool Passes() const { return IsInside() && is_seen; }
  const char* Verdict() const { return Passes() ? "pass" : IsInside() ? "not shown" : "fail"; }
  std::string Why() const {
    if (Passes()) return "inside the limit by U or more";
    if (IsInside()) return "inside where it was measured, but not measured often enough";
    return MarginDeg() < -expanded_deg ? "the limit is passed" : "the limit is nearer than U: not shown to be kept";
  }
};

// The standard deviation of the knee angle by all but the detection, which is each frame's own.
double SharedDeviation(const gait::LegFitResult& leg, const compare::RecordingBudgetOptions& options) {
  for (const compare::Budget& budget : compare::BudgetsOf(leg, options))
    if (budget.quantity.starts_with("knee_angle")) {
      double square = 0;
      for (const compare::BudgetRow& row : budget.rows)
        if (row.source != compare::kDetection) square += std::pow(row.Contribution(), 2);
      return std::sqrt(square);
    }
  throw Fail(
      "--range-limit: the lengths are in px, and without mm nobody knows how uncertain the angle is: give --camera "
      "or --scale");
}

Unknown FindUnknown(const motion::LegMotion& motion) {
  const auto is_known = [](const motion::LegSample& sample) {
    return std::isfinite(sample.knee_raw_deg) && std::isfinite(sample.knee_deg);
  };
  const auto known = std::ranges::count_if(motion.samples, is_known);
  if (known == 0) throw Fail("--range-limit: the knee angle is not measured in any frame");
  const auto first = std::ranges::find_if(motion.samples, is_known);
  const auto last = std::find_if(motion.samples.rbegin(), motion.samples.rend(), is_known).base();
  const auto between = static_cast<double>(last - first);
  return {.frames = static_cast<int>(std::ssize(motion.samples) - known),
          .percent = 100 * (1 - static_cast<double>(known) / between)};
}

End Find(const motion::LegMotion& motion, const char* name, int towards, double limit_deg, double shared_deg) {
  End end{.name = name, .limit_deg = limit_deg, .towards = towards};
  double farthest = -INFINITY, nearest = INFINITY, least = INFINITY;
  for (std::size_t i = 0; i < motion.samples.size(); ++i) {
    const motion::LegSample& sample = motion.samples[i];
    const double at = towards * sample.knee_deg;
    nearest = std::fmin(nearest, at);
    farthest = std::fmax(farthest, at);
    const double expanded_deg = kCoverage * std::hypot(shared_deg, sample.knee_sigma_deg);
    const double inside_deg = towards * limit_deg - at - expanded_deg;
    if (!(inside_deg < least)) continue;  // also where it is not known
    least = inside_deg;
    end.measured_deg = sample.knee_deg;
    end.time_s = motion.time_s[i];
    end.expanded_deg = expanded_deg;
  }
  // A visit begins in the last tenth of the range and ends beyond its middle.
  bool there = false;
  for (const motion::LegSample& sample : motion.samples) {
    const double to_go = (farthest - towards * sample.knee_deg) / (farthest - nearest);
    if (!there && to_go < 0.1) {
      there = true;
      ++end.visits;
    }
    if (to_go > 0.5) there = false;
  }
  return end;
}

void WriteTable(const std::filesystem::path& path, const std::vector<End>& ends, const Unknown& unknown) {
  CsvWriter csv({"end", "measured_deg", "expanded_deg", "coverage", "limit_deg", "margin_deg", "time_s", "visits",
                 "unknown_frames", "unknown_percent", "result"});
  for (const End& end : ends)
    csv.AddRow(end.name, end.measured_deg, end.expanded_deg, kCoverage, end.limit_deg, end.MarginDeg(), end.time_s,
               end.visits, unknown.frames, unknown.percent, end.Verdict());
  csv.Write(path);
}

Table EndsTable(const std::vector<End>& ends) {
  Table table{
      .caption = "Measured range, ± U (k = 2), against the limits",
      .columns = {{"end"}, {"measured (°)"}, {"limit (°)"}, {"inside by (°)", 2}, {"visits", 0}, {"result"}, {""}}};
  for (const End& end : ends)
    table.rows.push_back({end.name, PlusMinusText(end.measured_deg, end.expanded_deg, 2), NumberText(end.limit_deg, 2),
                          end.MarginDeg(), static_cast<double>(end.visits), end.Verdict(), end.Why()});
  return table;
}

LineChart AngleChart(const motion::LegMotion& motion, const std::vector<End>& ends) {
  Series knee{.name = "knee angle"};
  for (std::size_t i = 0; i < motion.samples.size(); i += ChartStep(motion.samples.size())) {
    knee.x.push_back(motion.time_s[i]);
    knee.y.push_back(motion.samples[i].knee_deg);
  }
  LineChart chart{.title = "Knee angle of the mechanism",
                  .caption = "Dashed: the limits.",
                  .x = {.label = "time (s)"},
                  .y = {.label = "angle (°)"},
                  .series = {std::move(knee)}};
  for (const End& end : ends) {
    Series limit{.name = end.towards > 0 ? "upper limit" : "lower limit", .mark = Mark::kDashed};
    limit.x = {motion.time_s.front(), motion.time_s.back()};
    limit.y = {end.limit_deg, end.limit_deg};
    chart.series.push_back(std::move(limit));
  }
  return chart;
}

Section Method() {
  return {
      "How it is measured",
      {report::List{
          {"Markers on the mechanism's joints, filmed or captured as in any trial; the angle is that of the leg's "
           "knee. Without load, or with a dummy: nobody wears a prototype whose range is not known.",
           "U = 2 u, u of the detection in that frame, of the three markers' places beside the joints' axes "
           "(--placement-sd) and of their distances from the plane (--depth-sd, --view-slope); no soft tissue, and a "
           "scale changes no angle. The frame counts that is nearest to the limit with its U, not a mean.",
           fmt::format("An end passes if it keeps within its limit by U or more (guard band, ILAC-G8:09/2019), and if "
                       "at most {} % of the frames between the first and the last measured angle have none.",
                       kMostUnknown_percent),
           "After the COVR protocols for the safety skill “limit range of movement” (ROB-LRM-2: the range is "
           "assessed by optical tracking of markers); a manufacturer's limits and how often each is tried are those "
           "of the risk assessment (IEC 80601-2-78, ISO 14971)."}}}};
}

// In how many frames the angle is unknown; empty where in none.
std::string UnknownText(const Unknown& unknown) {
  if (unknown.frames == 0) return "";
  return fmt::format(
      "Frames without a measured angle: {}; between the first and the last of those with one, {:.1f} % of the "
      "recording.",
      unknown.frames, unknown.percent);
}

// For the terminal.
std::string EndText(const End& end) {
  return fmt::format("{} {}° (k = 2), limit {:.2f}°: {}\n", end.name,
                     PlusMinusText(end.measured_deg, end.expanded_deg, 2), end.limit_deg, end.Verdict());
}

}  // namespace

void WriteRangeLimit(const gait::LegFitResult& leg, compare::RecordingBudgetOptions budget,
                     const std::array<double, 2>& limit_deg, Json& results, Run& run) {
  budget.soft_tissue_mm = 0;
  const double shared_deg = SharedDeviation(leg, budget);
  const Unknown unknown = FindUnknown(leg.motion);
  std::vector<End> ends = {Find(leg.motion, "smallest angle", -1, limit_deg[0], shared_deg),
                           Find(leg.motion, "largest angle", 1, limit_deg[1], shared_deg)};
  for (End& end : ends) end.is_seen = unknown.percent <= kMostUnknown_percent;
  WriteTable(run.Result("range_limit.csv"), ends, unknown);
  const bool passes = ends[0].Passes() && ends[1].Passes();
  Json json = {{"passes", passes},
               {"ends", Json::array()},
               {"unknown_frames", unknown.frames},
               {"unknown_percent", unknown.percent}};
  for (const End& end : ends)
    json["ends"].push_back({{"end", end.name},
                            {"measured_deg", end.measured_deg},
                            {"expanded_deg", end.expanded_deg},
                            {"limit_deg", end.limit_deg},
                            {"result", end.Verdict()}});
  for (const End& end : ends) run.Report(EndText(end));
  const std::string unknown_text = UnknownText(unknown);
  if (!unknown_text.empty()) run.Report(unknown_text + "\n");
  results["range_limit"] = std::move(json);
  Report page{.title = "Measured range of the mechanism", .warnings = run.Warnings()};
  const bool fails = std::ranges::any_of(ends, [](const End& end) { return !end.IsInside(); });
  const std::string verdict = passes  ? "Pass: the measured range keeps within both limits."
                              : fails ? "Fail: the range is not shown to keep within both limits."
                                      : "Not shown: the angle was not measured in too much of the recording.";
  Section result{"", {Paragraph{verdict}, EndsTable(ends), AngleChart(leg.motion, ends)}};
  if (!unknown_text.empty()) result.blocks.insert(result.blocks.begin() + 1, Paragraph{unknown_text});
  page.sections = {std::move(result), Method(), ProvenanceSection(run.Head())};
  WriteReport(run.Result("range_limit.html"), page);
}

}  // namespace lake::commands
