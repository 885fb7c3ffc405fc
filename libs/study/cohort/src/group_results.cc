#include "group_results.h"

#include <algorithm>

#include "group_figures.h"
#include "group_page.h"
#include "lake/cohort/group_statistics.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"

namespace lake::cohort {
namespace {

using reliability::Estimate;

void WriteTrials(const GroupData& group, Run& run) {
  std::vector<std::string> header = {"participant_id", "session", "run", "trial", "repetition"};
  header.insert(header.end(), group.quantities.begin(), group.quantities.end());
  CsvWriter csv(header);
  for (const GroupRow& row : group.rows) {
    csv.Add(row.participant).Add(row.session).Add(row.run).Add(row.trial).Add(row.repetition);
    for (const std::string& quantity : group.quantities) {
      const auto found = row.values.find(quantity);
      csv.Add(found == row.values.end() ? std::nullopt : std::optional(found->second));
    }
    csv.EndRow();
  }
  csv.Write(run.Result("trials.csv"));
}

void AddEstimate(const Estimate& estimate, CsvWriter& csv) {
  csv.Add(estimate.value).Add(estimate.interval.low).Add(estimate.interval.high);
}

void WriteCurves(const std::vector<CurveRow>& rows, Run& run) {
  CsvWriter csv({"trial", "quantity", "percent", "participants", "mean", "sd", "low", "high"});
  for (const CurveRow& row : rows)
    for (int percent = 0; percent < kPercents; ++percent) {
      const reliability::MeanOfSubjects& of = row.percent[static_cast<std::size_t>(percent)];
      csv.AddRow(row.trial, row.quantity, percent, of.subjects, of.mean.value, of.standard_deviation,
                 of.mean.interval.low, of.mean.interval.high);
    }
  csv.Write(run.Result("curves.csv"));
}

void WriteReliability(const std::vector<ReliabilityRow>& rows, Run& run) {
  std::vector<std::string> header = {"trial", "quantity", "across", "participants", "judges", "mean"};
  for (const char* estimate : {"icc_2_1", "icc_3_1", "sem"})
    for (const char* end : {"", "_low", "_high"}) header.push_back(std::string(estimate) + end);
  header.push_back("mdc95");
  for (const char* estimate : {"bias", "lower_limit", "upper_limit"})
    for (const char* end : {"", "_low", "_high"}) header.push_back(std::string(estimate) + end);
  CsvWriter csv(header);
  for (const ReliabilityRow& row : rows) {
    csv.Add(row.trial).Add(row.quantity).Add(row.across);
    csv.Add(row.squares.targets).Add(row.squares.judges).Add(row.mean);
    for (const Estimate& estimate : {row.icc2, row.icc3, row.sem}) AddEstimate(estimate, csv);
    csv.Add(row.mdc95);
    for (const Estimate& estimate : {row.agreement.bias, row.agreement.lower, row.agreement.upper})
      AddEstimate(estimate, csv);
    csv.EndRow();
  }
  csv.Write(run.Result("reliability.csv"));
}

void WriteDifferences(const std::vector<DifferenceRow>& rows, Run& run) {
  CsvWriter csv({"quantity", "participants", "human", "exo", "difference", "sd", "low", "high"});
  for (const DifferenceRow& row : rows)
    csv.AddRow(row.quantity, row.difference.subjects, row.human, row.exo, row.difference.mean.value,
               row.difference.standard_deviation, row.difference.mean.interval.low, row.difference.mean.interval.high);
  csv.Write(run.Result("differences.csv"));
}

void WriteOutliers(const std::vector<OutlierRow>& rows, Run& run) {
  CsvWriter csv({"participant_id", "trial", "quantity", "value", "median", "robust_score", "why"});
  for (const OutlierRow& row : rows)
    csv.AddRow(row.participant, row.quantity.trial, row.quantity.name, row.value, row.median, row.score, row.Why());
  csv.Write(run.Result("outliers.csv"));
}

void WriteFailures(const std::vector<Failure>& failures, Run& run) {
  CsvWriter csv({"participant_id", "session", "run", "step", "error"});
  for (const Failure& of : failures) csv.AddRow(of.participant, of.session, of.run, of.step, of.error);
  csv.Write(run.Result("failures.csv"));
}

std::vector<DoneStudy> StudiesOf(const Workflow& workflow, const WorkflowState& state) {
  std::vector<DoneStudy> studies;
  for (const WorkflowStudy& of : workflow.studies)
    studies.push_back({.participant = of.participant,
                       .session = of.session,
                       .run = of.run,
                       .folder = of.folder,
                       .steps = state.done.at(of.name),
                       .has_redesign = std::ranges::find(of.steps, "redesign") != of.steps.end()});
  return studies;
}

}  // namespace

Json WriteGroup(const Workflow& workflow, const WorkflowState& state, Run& run) {
  const GroupData group = ReadGroup(StudiesOf(workflow, state));
  if (group.rows.empty())
    throw Fail("{}: no study has results{}", workflow.out.string(),
               state.failures.empty() ? "" : "; " + state.failures.front().Text());
  const GroupFindings findings{.repetition = gait::MovementOf(group.movement).repetition,
                               .curves = CurvesOf(group),
                               .reliability = ReliabilityOf(group),
                               .differences = DifferencesOf(group),
                               .outliers = OutliersOf(group),
                               .failures = state.failures};
  std::vector<std::string> names = {"trials.csv",   "curves.csv",   "reliability.csv", "differences.csv",
                                    "outliers.csv", "failures.csv", "group.html"};
  for (const GroupFigure& figure : GroupFigures()) std::ranges::copy(FileNames(figure), std::back_inserter(names));
  run.Begin(names);
  WriteTrials(group, run);
  WriteCurves(findings.curves, run);
  WriteReliability(findings.reliability, run);
  WriteDifferences(findings.differences, run);
  WriteOutliers(findings.outliers, run);
  WriteFailures(findings.failures, run);
  DrawGroupFigures(findings.curves, run);
  report::WriteReport(run.Result("group.html"), MakeGroupPage(workflow, group, findings, run.Head()));
  return {{"participants", ParticipantsOf(group).size()},
          {"rows", group.rows.size()},
          {"failures", findings.failures.size()},
          {"outliers", findings.outliers.size()}};
}

}  // namespace lake::cohort
