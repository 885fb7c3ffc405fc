#include "lake/actuator/duty_table.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <optional>

#include "lake/core/csv.h"
#include "lake/core/error.h"
#include "lake/core/numbers.h"

namespace lake::actuator {
namespace {

// Fritsch & Carlson's slopes by Brodlie's weighted harmonic mean; one-sided at the ends, limited so that the ends stay
// monotone. Boost's pchip has the same inner slopes, but takes four points or more, where a table may have two, and the
// secant as the slope at an end: of duties that rise with speed², it is 0.011 off through 4 points and 0.0012 through
// 10, this 0.0035 and 0.0003.
std::vector<double> MonotoneSlopes(const std::vector<double>& x, const std::vector<double>& y) {
  const std::size_t n = x.size();
  std::vector<double> secant(n - 1), slope(n);
  for (std::size_t i = 0; i + 1 < n; ++i) secant[i] = (y[i + 1] - y[i]) / (x[i + 1] - x[i]);
  if (n == 2) return {secant[0], secant[0]};
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = x[i] - x[i - 1], after = x[i + 1] - x[i];
    const double w1 = 2 * after + before, w2 = after + 2 * before;
    slope[i] = (w1 + w2) / (w1 / secant[i - 1] + w2 / secant[i]);
  }
  const auto end = [](double near_gap, double far_gap, double near, double far) {
    const double slope = ((2 * near_gap + far_gap) * near - near_gap * far) / (near_gap + far_gap);
    return std::clamp(slope, 0.0, 3 * near);
  };
  slope[0] = end(x[1] - x[0], x[2] - x[1], secant[0], secant[1]);
  slope[n - 1] = end(x[n - 1] - x[n - 2], x[n - 2] - x[n - 3], secant[n - 2], secant[n - 3]);
  return slope;
}

void CheckRow(const DutyRow& row, const DutyRow* before, const std::string& name) {
  if (!(row.duty >= 0 && row.duty <= 1))
    throw Fail("{}: duty {} is not within 0..1{}", name, row.duty,
               row.duty > 1 && row.duty <= 255 ? "; divide values of analogWrite by 255" : "");
  if (before && !(row.duty > before->duty))
    throw Fail("{}: duties must ascend; {} after {} does not", name, row.duty, before->duty);
  for (const double speed : {row.extend_mm_s, row.retract_mm_s})
    if (speed < 0 || speed > 1000)
      throw Fail("{}: the speed {} mm/s at duty {} is not within 0..1000; speeds are positive in both directions", name,
                 speed, row.duty);
  if (row.tolerance_percent < 0 || row.tolerance_percent > 100)
    throw Fail("{}: the tolerance {} % at duty {} is not within 0..100", name, row.tolerance_percent, row.duty);
}

// One column as a curve: the last still duty, then every duty that is faster than all before.
DutyCurve MakeCurve(const std::vector<DutyRow>& rows, double DutyRow::*column, const std::string& where) {
  std::vector<double> speeds, duties;
  double fastest = 0;
  for (const DutyRow& row : rows) {
    const double speed = row.*column;
    if (std::isnan(speed)) continue;
    if (speed < fastest)
      throw Fail("{}: the speed falls from {} to {} mm/s at duty {}; it must not fall as the duty rises", where,
                 fastest, speed, row.duty);
    fastest = speed;
    if (!speeds.empty() && speed == speeds.back()) {
      if (speed == 0) duties.back() = row.duty;
      continue;
    }
    speeds.push_back(speed);
    duties.push_back(row.duty);
  }
  return DutyCurve(std::move(speeds), std::move(duties), where);
}

}  // namespace

DutyCurve::DutyCurve(std::vector<double> speeds_mm_s, std::vector<double> duties, const std::string& where)
    : speeds_(std::move(speeds_mm_s)), duties_(std::move(duties)) {
  if (speeds_.size() < 2 || speeds_.size() != duties_.size())
    throw Fail("{}: {} different speeds; a curve needs at least two", where, speeds_.size());
  for (std::size_t i = 1; i < speeds_.size(); ++i)
    if (!(speeds_[i] > speeds_[i - 1] && duties_[i] > duties_[i - 1]))
      throw Fail("{}: speeds and duties must ascend; {} mm/s at duty {} does not", where, speeds_[i], duties_[i]);
  slopes_ = MonotoneSlopes(speeds_, duties_);
}

double DutyCurve::DutyFor(double speed) const {
  assert(speed >= LeastSpeed() && speed <= MostSpeed());
  const auto above = std::upper_bound(speeds_.begin() + 1, speeds_.end() - 1, speed);
  const auto i = static_cast<std::size_t>(above - speeds_.begin()) - 1;
  const double width = speeds_[i + 1] - speeds_[i], t = (speed - speeds_[i]) / width, u = 1 - t;
  return u * u * (1 + 2 * t) * duties_[i] + t * t * (3 - 2 * t) * duties_[i + 1] + width * t * u * u * slopes_[i] -
         width * t * t * u * slopes_[i + 1];
}

double DutyCurve::SpeedFor(double duty) const {
  if (duty >= MostDuty()) return MostSpeed();
  if (duty < DeadBandDuty()) return 0;
  double low = LeastSpeed(), high = MostSpeed();
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (DutyFor(middle) > duty ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

std::optional<double> DutyTable::TolerancePercent() const {
  std::optional<double> largest;
  for (const DutyRow& row : rows)
    if (!std::isnan(row.tolerance_percent)) largest = std::max(largest.value_or(0), row.tolerance_percent);
  return largest;
}

DutyTable MakeDutyTable(std::vector<DutyRow> rows, const std::string& name) {
  for (std::size_t i = 0; i < rows.size(); ++i) CheckRow(rows[i], i > 0 ? &rows[i - 1] : nullptr, name);
  DutyCurve extend = MakeCurve(rows, &DutyRow::extend_mm_s, name + ": extend_mm_s");
  DutyCurve retract = MakeCurve(rows, &DutyRow::retract_mm_s, name + ": retract_mm_s");
  return {.name = name, .rows = std::move(rows), .extend = std::move(extend), .retract = std::move(retract)};
}

DutyTable ReadDutyTable(const std::filesystem::path& path) {
  const CsvTable table = CsvTable::Read(path);
  const std::size_t duty = table.Column("duty");
  const std::size_t extend = table.Column("extend_mm_s"), retract = table.Column("retract_mm_s");
  const auto optional_column = [&](const char* name) {
    return table.Has(name) ? std::optional(table.Column(name)) : std::nullopt;
  };
  const auto extend_se = optional_column("extend_se_mm_s"), retract_se = optional_column("retract_se_mm_s"),
             tolerance = optional_column("tolerance_percent");
  const auto number = [&](std::size_t row, std::optional<std::size_t> column) {
    return column ? table.Number(row, *column).value_or(kNaN) : kNaN;
  };
  std::vector<DutyRow> rows;
  for (std::size_t i = 0; i < table.Rows(); ++i)
    rows.push_back({.duty = table.RequiredNumber(i, duty),
                    .extend_mm_s = number(i, extend),
                    .retract_mm_s = number(i, retract),
                    .extend_se_mm_s = number(i, extend_se),
                    .retract_se_mm_s = number(i, retract_se),
                    .tolerance_percent = number(i, tolerance)});
  return MakeDutyTable(std::move(rows), path.string());
}

void WriteDutyTable(const std::filesystem::path& path, const std::vector<DutyRow>& rows) {
  CsvWriter table({"duty", "extend_mm_s", "retract_mm_s", "extend_se_mm_s", "retract_se_mm_s", "tolerance_percent"});
  for (const DutyRow& row : rows)
    table.AddRow(row.duty, row.extend_mm_s, row.retract_mm_s, row.extend_se_mm_s, row.retract_se_mm_s,
                 row.tolerance_percent);
  table.Write(path);
}

}  // namespace lake::actuator
