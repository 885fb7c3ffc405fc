#include "torque_table.h"

#include <limits>

#include "lake/core/angles.h"
#include "lake/core/csv.h"
#include "lake/core/error.h"

namespace lake::commands {

TorqueTable TorqueTable::Read(const std::filesystem::path& path) {
  const CsvTable table = CsvTable::Read(path);
  TorqueTable torques(0);
  torques.over_stroke_ = table.Has("stroke_mm");
  if (!torques.over_stroke_ && !table.Has("knee_deg"))
    throw Fail("{}: a table of torques needs a column stroke_mm or knee_deg", path.string());
  const std::size_t place = table.Column(torques.over_stroke_ ? "stroke_mm" : "knee_deg");
  const std::size_t torque = table.Column("knee_torque_nm");
  for (std::size_t row = 0; row < table.Rows(); ++row) {
    const double at = table.RequiredNumber(row, place);
    if (!torques.rows_.emplace(at, table.RequiredNumber(row, torque)).second)
      throw Fail("{}: a second torque for {} {}", table.Where(row), table.Header()[place], at);
  }
  if (torques.rows_.size() < 2) throw Fail("{}: a table of torques needs two rows or more", path.string());
  return torques;
}

double TorqueTable::At(const linkage::Pose& pose) const {
  if (rows_.empty()) return constant_nm_;
  const double place = over_stroke_ ? pose.stroke_mm : DegreesFromRadians(pose.theta_rad);
  const auto after = rows_.lower_bound(place);
  if (after == rows_.end()) return std::numeric_limits<double>::quiet_NaN();
  if (after->first == place) return after->second;
  if (after == rows_.begin()) return std::numeric_limits<double>::quiet_NaN();
  const auto before = std::prev(after);
  const double part = (place - before->first) / (after->first - before->first);
  return before->second + part * (after->second - before->second);
}

}  // namespace lake::commands
