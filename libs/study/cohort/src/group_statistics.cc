#include "lake/cohort/group_statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "lake/core/distributions.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"
#include "lake/core/statistics.h"
#include "lake/report/report.h"

namespace lake::cohort {
namespace {

std::vector<std::string> TrialsOf(const GroupData& group) {
  std::vector<std::string> trials;
  for (const GroupRow& row : group.rows)
    if (std::find(trials.begin(), trials.end(), row.trial) == trials.end()) trials.push_back(row.trial);
  return trials;
}

// Of each participant who has all of them, a row of values.
struct JudgedTable {
  std::vector<std::vector<double>> rows;

  Eigen::MatrixXd Matrix() const {
    Eigen::MatrixXd values(rows.size(), rows.empty() ? 0 : rows.front().size());
    for (std::size_t i = 0; i < rows.size(); ++i)
      for (std::size_t j = 0; j < rows[i].size(); ++j)
        values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) = rows[i][j];
    return values;
  }
};

std::vector<std::string> CommonSessions(const GroupData& group) {
  std::map<std::string, std::set<std::string>> who;
  for (const GroupRow& row : group.rows) who[row.session].insert(row.participant);
  const std::size_t all = ParticipantsOf(group).size();
  std::vector<std::string> sessions;
  for (const auto& [session, participants] : who)
    if (2 * participants.size() >= all) sessions.push_back(session);
  return sessions;
}

JudgedTable BySession(const GroupData& group, const std::string& trial, const std::string& quantity) {
  JudgedTable table;
  const std::vector<std::string> sessions = CommonSessions(group);
  for (const std::string& participant : ParticipantsOf(group)) {
    std::vector<double> values;
    for (const std::string& session : sessions)
      if (const auto value = ValueOf(group, participant, trial, quantity, session)) values.push_back(*value);
    if (values.size() == sessions.size()) table.rows.push_back(std::move(values));
  }
  return table;
}

// The first recording of each participant that has repetitions of this quantity.
std::vector<double> FirstRepetitions(const GroupData& group, const std::string& participant, const std::string& trial,
                                     const std::string& quantity) {
  std::vector<double> values;
  const GroupRow* first = nullptr;
  for (const GroupRow& row : group.rows) {
    if (row.participant != participant || row.trial != trial || !row.repetition || !row.values.contains(quantity))
      continue;
    if (!first) first = &row;
    if (row.session == first->session && row.run == first->run) values.push_back(row.values.at(quantity));
  }
  return values;
}

// As many repetitions as all have who have more than one.
JudgedTable ByRepetition(const GroupData& group, const std::string& trial, const std::string& quantity) {
  JudgedTable table;
  std::size_t judges = std::numeric_limits<std::size_t>::max();
  for (const std::string& participant : ParticipantsOf(group)) {
    std::vector<double> values = FirstRepetitions(group, participant, trial, quantity);
    if (values.size() < 2) continue;
    judges = std::min(judges, values.size());
    table.rows.push_back(std::move(values));
  }
  for (std::vector<double>& row : table.rows) row.resize(judges);
  return table;
}

void AddReliability(const JudgedTable& table, const std::string& trial, const std::string& quantity, const char* across,
                    std::vector<ReliabilityRow>& rows) {
  const Eigen::MatrixXd values = table.Matrix();
  if (values.rows() < 2 || values.cols() < 2) return;
  ReliabilityRow row{trial, quantity, across, values.mean(), reliability::MeanSquaresOf(values), {}, {}, {}, 0, {}};
  row.icc2 = Icc2Single(row.squares);
  row.icc3 = Icc3Single(row.squares);
  row.sem = StandardErrorOfMeasurement(row.squares);
  row.mdc95 = reliability::MinimalDetectableChange(row.sem.value);
  std::vector<double> first, second;
  for (const std::vector<double>& judged : table.rows) {
    first.push_back(judged[0]);
    second.push_back(judged[1]);
  }
  row.agreement = reliability::LimitsOfAgreementOf(first, second);
  rows.push_back(std::move(row));
}

Curve MeanCurve(const std::vector<const Curve*>& curves) {
  Curve mean;
  for (std::size_t i = 0; i < mean.size(); ++i) {
    std::vector<double> values;
    for (const Curve* curve : curves)
      if (std::isfinite((*curve)[i])) values.push_back((*curve)[i]);
    mean[i] = values.empty() ? kNaN : Mean(values);
  }
  return mean;
}

}  // namespace

const std::vector<MainQuantity>& MainQuantities() {
  static const std::vector<MainQuantity> kMain = {
      {"human", "rise_s", "rise time, human", "s", 2},
      {"exo", "rise_s", "rise time, exoskeleton", "s", 2},
      {"human", "stride_s", "stride time, human", "s", 2},
      {"exo", "stride_s", "stride time, exoskeleton", "s", 2},
      {"human", "speed_mm_s", "walking speed, human", "mm/s", 0},
      {"exo", "speed_mm_s", "walking speed, exoskeleton", "mm/s", 0},
      {"human", "knee_range_deg", "knee range, human", "°", 1},
      {"exo", "knee_range_deg", "knee range, exoskeleton", "°", 1},
      {"human", "knee_extension_max_deg_s", "knee extension speed, human", "°/s", 1},
      {"exo", "knee_extension_max_deg_s", "knee extension speed, exoskeleton", "°/s", 1},
      {"human", "trunk_max_deg", "trunk lean, human", "°", 1},
      {"exo", "trunk_max_deg", "trunk lean, exoskeleton", "°", 1},
      {"human", "shank_mm", "shank", "mm", 1},
      {"human", "thigh_mm", "thigh", "mm", 1},
      {"comparison", "joint_rms_mm", "joint misalignment, RMS", "mm", 1},
      {"comparison", "joint_offset_x_mm", "joint in front of the knee", "mm", 1},
      {"comparison", "joint_offset_y_mm", "joint above the knee", "mm", 1},
      {"comparison", "rms_mm", "path difference, RMS", "mm", 1},
      {"design", "range_deg", "range of rotation of the design", "°", 1},
  };
  return kMain;
}

std::vector<ReliabilityRow> ReliabilityOf(const GroupData& group) {
  std::vector<ReliabilityRow> rows;
  for (const std::string& trial : TrialsOf(group))
    for (const std::string& quantity : group.quantities) {
      AddReliability(BySession(group, trial, quantity), trial, quantity, "session", rows);
      AddReliability(ByRepetition(group, trial, quantity), trial, quantity, "repetition", rows);
    }
  return rows;
}

std::vector<DifferenceRow> DifferencesOf(const GroupData& group) {
  std::vector<DifferenceRow> rows;
  for (const std::string& quantity : group.quantities) {
    std::vector<double> human, exo, difference;
    for (const std::string& participant : ParticipantsOf(group)) {
      const auto without = ValueOf(group, participant, "human", quantity);
      const auto with = ValueOf(group, participant, "exo", quantity);
      if (!without || !with) continue;
      human.push_back(*without);
      exo.push_back(*with);
      difference.push_back(*with - *without);
    }
    if (!difference.empty()) rows.push_back({quantity, Mean(human), Mean(exo), reliability::MeanOf(difference)});
  }
  const auto of_certain = [](const DifferenceRow& row) { return std::isfinite(row.StandardErrors()); };
  const auto uncertain = std::stable_partition(rows.begin(), rows.end(), of_certain);
  std::stable_sort(rows.begin(), uncertain, [](const DifferenceRow& a, const DifferenceRow& b) {
    return std::abs(a.StandardErrors()) > std::abs(b.StandardErrors());
  });
  return rows;
}

double DifferenceRow::StandardErrors() const {
  const double subjects = static_cast<double>(difference.subjects);
  return difference.subjects > 1 && difference.standard_deviation > 0
             ? difference.mean.value / (difference.standard_deviation / std::sqrt(subjects))
             : kNaN;
}

bool DifferenceRow::IsClearAmong(std::size_t comparisons) const {
  constexpr double kChance = 0.05;
  if (!std::isfinite(StandardErrors())) return false;
  const double least = StudentQuantile(static_cast<double>(difference.subjects) - 1,
                                       1 - kChance / (2 * static_cast<double>(comparisons)));
  return std::abs(StandardErrors()) > least;
}

std::string OutlierRow::Why() const {
  return fmt::format("{} {} {}, median {} {}: {} robust standard deviations from it", quantity.label,
                     report::NumberText(value, quantity.decimals), quantity.unit,
                     report::NumberText(median, quantity.decimals), quantity.unit, report::NumberText(score, 1));
}

std::vector<OutlierRow> OutliersOf(const GroupData& group) {
  std::vector<OutlierRow> rows;
  for (const MainQuantity& quantity : MainQuantities()) {
    std::vector<std::string> who;
    std::vector<double> values;
    for (const std::string& participant : ParticipantsOf(group))
      if (const auto value = ValueOf(group, participant, quantity.trial, quantity.name)) {
        who.push_back(participant);
        values.push_back(*value);
      }
    const std::vector<double> scores = reliability::RobustScores(values);
    for (std::size_t i = 0; i < scores.size(); ++i)
      if (std::abs(scores[i]) > reliability::kOutlierScore)
        rows.push_back({who[i], quantity, values[i], Median(values), scores[i]});
  }
  return rows;
}

std::string IccCaution(std::size_t participants) {
  constexpr std::size_t kEnough = 18;
  if (participants >= kEnough) return "";
  return fmt::format(
      "With {} participants an ICC means nothing yet: its interval holds nearly every value. It takes about {} with "
      "two measurements each to distinguish an ICC of 0.9 from one of 0.7 (Walter, Eliasziw & Donner 1998).",
      participants, kEnough);
}

std::vector<CurveRow> CurvesOf(const GroupData& group) {
  std::vector<CurveRow> rows;
  std::map<std::pair<std::string, std::string>, std::map<std::string, std::vector<const Curve*>>> by;
  for (const GroupCurve& curve : group.curves)
    by[{curve.trial, curve.quantity}][curve.participant].push_back(&curve.values);
  for (const auto& [of, participants] : by) {
    CurveRow row{of.first, of.second, {}, {}};
    for (const auto& [participant, curves] : participants)
      row.participants.emplace_back(participant, MeanCurve(curves));
    for (std::size_t i = 0; i < kPercents; ++i) {
      std::vector<double> values;
      for (const auto& [participant, curve] : row.participants)
        if (std::isfinite(curve[i])) values.push_back(curve[i]);
      row.percent.push_back(reliability::MeanOf(values));
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace lake::cohort
