#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "lake/commands/optimize_tables.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "lake/problem/problem_file.h"
#include "optimum_tables.h"

namespace lake::commands {
namespace {

namespace fs = std::filesystem;
using redesign::PersonOutcome;

std::vector<std::string> PartsOf(const fs::path& path) {
  std::vector<std::string> parts;
  fs::path whole = fs::absolute(path).lexically_normal();
  if (!whole.has_filename()) whole = whole.parent_path();  // "folder/"
  for (const fs::path& part : whole) parts.push_back(part.string());
  return parts;
}

std::string FileOf(const std::string& person, const char* file) {
  return fmt::format("people/{}/{}", person, file);
}

void AddNothing(CsvWriter& table, int cells) {
  for (int i = 0; i < cells; ++i) table.AddEmpty();
}

// A row of people.csv.
struct PersonRow {
  const redesign::GroupOutcome& group;  // of the size that is worn, or of all
  std::size_t index;                    // in it
  std::size_t size = 0;
};

void AddResult(const redesign::DesignInMotion& design, CsvWriter& table) {
  table.Add(design.evaluation.range_deg)
      .Add(ValueOf(redesign::kMisalignment, design))
      .Add(design.prediction ? design.prediction->Rms().mm : kNaN);
}

void AddPerson(const PersonRow& row, CsvWriter& table) {
  const PersonOutcome& person = row.group.people[row.index];
  const redesign::DesignInMotion& design = person.with_group;
  const redesign::SegmentLengths leg = redesign::SegmentsOf(row.group.problem.people[row.index].human);
  double multipliers = 0;
  for (const PersonOutcome& other : row.group.people) multipliers += other.multiplier;
  table.Add(person.name).Add(row.size + 1).Add(person.counts);
  table.Add(leg.shank_mm).Add(leg.thigh_mm);
  AddResult(design, table);
  table.Add(multipliers > 0 ? person.multiplier / multipliers : 0);
  table.Add(design.design.placement_mm[0]).Add(design.design.placement_mm[1]);
  if (design.prediction)
    table.Add(design.duration_s).Add(design.prediction->stroke_mm.front()).Add(design.prediction->stroke_mm.back());
  else
    AddNothing(table, 3);
  table.Add(person.cost_deg);
  if (!person.own) {
    AddNothing(table, 9);
    return;
  }
  AddResult(*person.own, table);
  table.Add(person.own->design.links.Values());
}

void WritePeople(const std::vector<PersonRow>& rows, Run& run) {
  std::vector<std::string> header = SplitText(
      "person,size,counts,shank_mm,thigh_mm,range_deg,misalignment_percent,misalignment_rms_mm,price_share,placement_x_"
      "mm,placement_y_mm,program_duration_s,stroke_from_mm,stroke_to_mm,cost_deg,own_range_deg,own_misalignment_"
      "percent,own_misalignment_rms_mm",
      ',');
  std::ranges::copy(LinkColumns("own_"), std::back_inserter(header));
  CsvWriter table(header);
  for (const PersonRow& row : rows) {
    AddPerson(row, table);
    table.EndRow();
  }
  table.Write(run.Result("people.csv"));
}

std::vector<PersonRow> RowsOf(const redesign::GroupOutcome& outcome) {
  std::vector<PersonRow> rows;
  for (std::size_t i = 0; i < outcome.people.size(); ++i) rows.push_back({outcome, i});
  return rows;
}

// In the order in which people were given.
std::vector<PersonRow> RowsOf(const redesign::SizesOutcome& outcome) {
  std::vector<PersonRow> rows;
  for (std::size_t i = 0; i < outcome.size_of.size(); ++i) {
    const std::size_t size = outcome.size_of[i];
    const auto place = std::ranges::find(outcome.members[size], i);
    rows.push_back({outcome.sizes[size], static_cast<std::size_t>(place - outcome.members[size].begin()), size});
  }
  return rows;
}

// The links, and of each who wears them placement and program.
void WriteDesigns(const redesign::GroupOutcome& outcome, const std::string& name, Run& run) {
  const std::string remark = outcome.IsSolved() ? "" : ": NOT A SOLUTION: " + outcome.reason;
  const problem::SynthesisProblem& problem = outcome.problem.shared.design;
  WriteOptimumDesign(DesignOf(problem, outcome.nearest.Links()), problem, outcome.evaluation, remark, name, run);
  for (std::size_t i = 0; i < outcome.people.size(); ++i) {
    const PersonOutcome& person = outcome.people[i];
    WriteOptimumDesign(person.with_group.design, problem, outcome.evaluation, remark,
                       FileOf(person.name, "design.yaml"), run);
    WriteProgramTable(person.with_group, outcome.problem.people[i].human,
                      run.Result(FileOf(person.name, "program.csv")));
  }
}

std::string SizeFile(std::size_t size) {
  return fmt::format("sizes/{}/design.yaml", size + 1);
}

void WriteSizeTables(const redesign::SizesOutcome& outcome, Run& run) {
  std::vector<std::string> header = {"size", "people", "range_deg", "misalignment_percent"};
  std::ranges::copy(LinkColumns(""), std::back_inserter(header));
  CsvWriter sizes(header);
  for (std::size_t k = 0; k < outcome.sizes.size(); ++k) {
    const redesign::GroupOutcome& size = outcome.sizes[k];
    sizes.AddRow(k + 1, size.people.size(), size.evaluation.range_deg, size.Misalignment_percent(),
                 size.nearest.Links().Values());
  }
  sizes.Write(run.Result("sizes.csv"));
  CsvWriter rule({"quantity", "from_mm", "to_mm", "size"});
  for (const redesign::RuleRange& range : outcome.rule.ranges)
    rule.AddRow(outcome.rule.quantity, range.from_mm, range.to_mm, range.size + 1);
  rule.Write(run.Result("size_rule.csv"));
  CsvWriter left_out({"person", "size", "size_by_rule", "holds", "misalignment_percent", "range_deg"});
  const std::vector<PersonRow> rows = RowsOf(outcome);
  for (std::size_t i = 0; i < outcome.left_out.size(); ++i) {
    const redesign::LeftOut& of = outcome.left_out[i];
    left_out.AddRow(rows[i].group.people[rows[i].index].name, outcome.size_of[i] + 1, of.size + 1, of.fit.holds,
                    of.fit.percent, of.fit.range_deg);
  }
  left_out.Write(run.Result("left_out.csv"));
}

const char* NameOf(redesign::Across across) {
  switch (across) {
    case redesign::Across::kWorst:
      return "worst";
    case redesign::Across::kMean:
      return "mean";
    case redesign::Across::kQuantile:
      return "quantile";
  }
  return "";
}

// Who would gain most by a design of their own.
Json CostJson(const std::vector<PersonRow>& rows) {
  std::vector<double> costs;
  const PersonOutcome* most = nullptr;
  for (const PersonRow& row : rows) {
    const PersonOutcome& person = row.group.people[row.index];
    if (!person.cost_deg) continue;
    costs.push_back(*person.cost_deg);
    if (!most || *person.cost_deg > *most->cost_deg) most = &person;
  }
  if (!most) return nullptr;
  return {{"mean_deg", Mean(costs)}, {"largest_deg", *most->cost_deg}, {"largest_of", most->name}};
}

Json PeopleJson(const std::vector<PersonRow>& rows) {
  Json people = Json::array();
  for (const PersonRow& row : rows) {
    const PersonOutcome& person = row.group.people[row.index];
    people.push_back({{"person", person.name},
                      {"size", row.size + 1},
                      {"counts", person.counts},
                      {"misalignment_percent", NumberOrNull(ValueOf(redesign::kMisalignment, person.with_group))},
                      {"cost_deg", NumberOrNull(person.cost_deg)},
                      {"placement_mm", person.with_group.design.placement_mm},
                      {"program_duration_s", person.with_group.duration_s}});
  }
  return people;
}

void WarnOfGroup(const std::vector<PersonRow>& rows, Run& run) {
  const redesign::RedesignProblem& shared = rows.front().group.problem.shared;
  WarnWithoutLimit(shared, run);
  std::vector<std::string> without_own, left_out;
  for (const PersonRow& row : rows) {
    const PersonOutcome& person = row.group.people[row.index];
    if (!person.own) without_own.push_back(person.name);
    if (!person.counts) left_out.push_back(person.name);
  }
  if (!without_own.empty())
    run.Warn("for {} no design of their own was found, so what the common one costs them is not known",
             fmt::join(without_own, ", "));
  if (!left_out.empty()) run.Warn("the misalignment of {} does not count in the quantile", fmt::join(left_out, ", "));
}

// Of those who were left out: whom the rule gives the size that they wear, and whose limits it keeps.
struct LeftOutCounts {
  std::size_t same_size = 0, hold = 0;
};

LeftOutCounts CountLeftOut(const redesign::SizesOutcome& outcome) {
  LeftOutCounts counts;
  for (std::size_t i = 0; i < outcome.left_out.size(); ++i) {
    counts.same_size += outcome.left_out[i].size == outcome.size_of[i];
    counts.hold += outcome.left_out[i].fit.holds;
  }
  return counts;
}

// By which quantity, and what became of those who were left out.
Json RuleJson(const redesign::SizesOutcome& outcome) {
  Json ranges = Json::array();
  for (const redesign::RuleRange& range : outcome.rule.ranges)
    ranges.push_back(
        {{"from_mm", NumberOrNull(range.from_mm)}, {"to_mm", NumberOrNull(range.to_mm)}, {"size", range.size + 1}});
  const LeftOutCounts counts = CountLeftOut(outcome);
  // Where somebody's limit is not held there is no mean in degrees.
  const Json loss_deg = outcome.rule_not_held ? Json() : Json(outcome.rule.loss_deg);
  return {{"quantity", outcome.rule.quantity},
          {"ranges", ranges},
          {"loss_deg", loss_deg},
          {"not_held", outcome.rule_not_held},
          {"left_out", outcome.left_out.size()},
          {"left_out_same_size", counts.same_size},
          {"left_out_hold", counts.hold}};
}

// Whom the design is for, and what it costs each.
std::string PeopleText(const std::vector<PersonRow>& rows) {
  const auto cell = [](double value, int digits) {
    return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : std::string("-");
  };
  std::string text = fmt::format("  {:<20}{:>16}{:>22}\n", "person", "misalignment", "costs, against their own");
  for (const PersonRow& row : rows) {
    const PersonOutcome& person = row.group.people[row.index];
    text += fmt::format("  {:<20}{:>14} %{:>20} °\n", person.name,
                        cell(ValueOf(redesign::kMisalignment, person.with_group), 2),
                        cell(person.cost_deg.value_or(kNaN), 1));
  }
  return text;
}

// Each size, who gets it by which rule, and how that went for those who were left out.
std::string SizesText(const redesign::SizesOutcome& outcome) {
  std::string text;
  for (std::size_t k = 0; k < outcome.sizes.size(); ++k)
    text += fmt::format("size {}: range {:.2f} deg, {} people\n", k + 1, outcome.sizes[k].evaluation.range_deg,
                        outcome.sizes[k].people.size());
  const std::vector<redesign::RuleRange>& ranges = outcome.rule.ranges;
  for (const redesign::RuleRange& range : ranges)
    if (std::isfinite(range.to_mm))
      text += fmt::format("  {} up to {:.1f}: size {}\n", outcome.rule.quantity, range.to_mm, range.size + 1);
    else
      text += fmt::format("  {}: size {}\n", ranges.size() > 1 ? "else" : "everybody", range.size + 1);
  const LeftOutCounts counts = CountLeftOut(outcome);
  return text +
         fmt::format("leaving one out: the rule gives {} of {} the size that they wear, and {} keep the limits\n",
                     counts.same_size, outcome.left_out.size(), counts.hold);
}

}  // namespace

std::vector<std::string> NamesOfFolders(const std::vector<fs::path>& folders) {
  std::vector<std::vector<std::string>> all;
  for (const fs::path& folder : folders) all.push_back(PartsOf(folder));
  for (std::size_t i = 0; i < all.size(); ++i)
    if (std::find(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(i), all[i]) !=
        all.begin() + static_cast<std::ptrdiff_t>(i))
      throw UsageError("--comparison {}: is named twice", folders[i].string());
  const auto common = [&](bool from_end) {
    for (std::size_t k = 0;; ++k)
      for (const auto& parts : all) {
        const auto& first = all.front();
        if (k >= parts.size() || k >= first.size()) return k;
        if (parts[from_end ? parts.size() - 1 - k : k] != first[from_end ? first.size() - 1 - k : k]) return k;
      }
  };
  const std::size_t before = common(false), after = common(true);
  std::vector<std::string> names;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::size_t end = std::max(before + 1, all[i].size() - after);
    std::vector<std::string> own;
    for (std::size_t k = before; k < std::min(end, all[i].size()); ++k) own.push_back(all[i][k]);
    names.push_back(own.empty() ? all[i].back() : fmt::format("{}", fmt::join(own, "_")));
  }
  for (std::size_t i = 0; i < names.size(); ++i)
    if (const auto same = std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i), names[i]);
        same != names.begin() + static_cast<std::ptrdiff_t>(i))
      throw UsageError("--comparison {} and {}: both would be called {}; rename a folder",
                       folders[static_cast<std::size_t>(same - names.begin())].string(), folders[i].string(), names[i]);
  return names;
}

std::vector<std::string> GroupResultNames(const std::vector<std::string>& people, std::optional<int> sizes) {
  std::vector<std::string> names = {"summary.json", "people.csv"};
  if (!sizes) names.push_back("design.yaml");
  if (sizes) names.insert(names.end(), {"sizes.csv", "size_rule.csv", "left_out.csv"});
  for (int k = 0; k < sizes.value_or(0); ++k) names.push_back(SizeFile(static_cast<std::size_t>(k)));
  for (const std::string& person : people)
    for (const char* file : {"design.yaml", "program.csv"}) names.push_back(FileOf(person, file));
  return names;
}

Json WriteGroup(const redesign::GroupOutcome& outcome, Run& run) {
  const std::vector<PersonRow> rows = RowsOf(outcome);
  WriteDesigns(outcome, "design.yaml", run);
  WritePeople(rows, run);
  WarnOfGroup(rows, run);
  const redesign::GroupProblem& problem = outcome.problem;
  Json summary = {{"range_deg", NumberOrNull(outcome.evaluation.range_deg)},
                  {"status", outcome.IsSolved() ? "solved" : "infeasible"},
                  {"constraint_violation", NumberOrNull(outcome.evaluation.violation)},
                  {"links", LinksJson(outcome.nearest.Links())},
                  {"across", NameOf(problem.across)},
                  {"quantile", problem.across == redesign::Across::kQuantile ? Json(problem.quantile) : Json()},
                  {"misalignment_percent", NumberOrNull(outcome.Misalignment_percent())},
                  {"max_misalignment_percent", NumberOrNull(problem.shared.max_misalignment_percent)},
                  {"penalty_deg_per_mm", problem.shared.penalty_deg_per_mm},
                  {"starts", outcome.starts},
                  {"usable_starts", outcome.usable_starts},
                  {"cost", CostJson(rows)},
                  {"people", PeopleJson(rows)},
                  {"optimum", EvaluationJson(outcome.evaluation)}};
  if (!outcome.IsSolved()) summary["reason"] = outcome.reason;
  run.Report(RangeText(outcome.evaluation.range_deg, {}) + PeopleText(rows) +
             fmt::format("{} misalignment {:.3f} % of the shank, RMS\n", NameOf(problem.across),
                         outcome.Misalignment_percent()) +
             LinksText(outcome.nearest.Links()));
  return summary;
}

Json WriteSizes(const redesign::SizesOutcome& outcome, Run& run) {
  const std::vector<PersonRow> rows = RowsOf(outcome);
  Json sizes = Json::array();
  for (std::size_t k = 0; k < outcome.sizes.size(); ++k) {
    const redesign::GroupOutcome& size = outcome.sizes[k];
    WriteDesigns(size, SizeFile(k), run);
    sizes.push_back({{"size", k + 1},
                     {"people", size.people.size()},
                     {"range_deg", NumberOrNull(size.evaluation.range_deg)},
                     {"misalignment_percent", NumberOrNull(size.Misalignment_percent())},
                     {"links", LinksJson(size.nearest.Links())}});
  }
  WritePeople(rows, run);
  WriteSizeTables(outcome, run);
  WarnOfGroup(rows, run);
  if (!outcome.is_settled)
    run.Warn(
        "who wears which size had not settled after ten rounds of designs and assignments: some would be better off "
        "with another size; more --starts or fewer --sizes help");
  const redesign::RedesignProblem& shared = outcome.sizes.front().problem.shared;
  Json summary = {{"status", outcome.IsSolved() ? "solved" : "infeasible"},
                  {"mean_value_deg", NumberOrNull(outcome.mean_value_deg)},
                  {"settled", outcome.is_settled},
                  {"max_misalignment_percent", NumberOrNull(shared.max_misalignment_percent)},
                  {"penalty_deg_per_mm", shared.penalty_deg_per_mm},
                  {"sizes", sizes},
                  {"rule", RuleJson(outcome)},
                  {"cost", CostJson(rows)},
                  {"people", PeopleJson(rows)}};
  if (!outcome.IsSolved()) summary["reason"] = outcome.Reason();
  run.Report(SizesText(outcome) + PeopleText(rows));
  return summary;
}

}  // namespace lake::commands
