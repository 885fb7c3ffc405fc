// What a duty of the bridge gives in speed: measured once per actuator, bridge and supply, as duty_table.csv.
#pragma once

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace lake::actuator {

// One direction: the smallest duty for a speed. Between the points monotone cubic (Fritsch & Carlson 1980,
// doi:10.1137/0717021), so it neither overshoots nor turns back.
class DutyCurve {
 public:
  // Speeds in mm/s and duties (0..1) both strictly ascending, at least two points. A first point of speed 0 is the edge
  // of the dead band. Throws Error naming `where` otherwise.
  DutyCurve(std::vector<double> speeds_mm_s, std::vector<double> duties, const std::string& where);

  double LeastSpeed() const { return speeds_.front(); }  // 0 if the table has the edge of the dead band
  double LeastMovingSpeed() const { return speeds_.front() > 0 ? speeds_[0] : speeds_[1]; }
  double MostSpeed() const { return speeds_.back(); }
  double DeadBandDuty() const { return duties_.front(); }
  double MostDuty() const { return duties_.back(); }

  // For a speed within LeastSpeed()..MostSpeed() (asserted).
  double DutyFor(double speed_mm_s) const;

  // The inverse; 0 at and below the dead band, MostSpeed() beyond the last point.
  double SpeedFor(double duty) const;

 private:
  std::vector<double> speeds_, duties_, slopes_;
};

// A row as in the file: duty 0..1, speeds in mm/s >= 0; NaN where that direction was not measured.
struct DutyRow {
  double duty = 0;
  double extend_mm_s = 0, retract_mm_s = 0;
  double extend_se_mm_s = 0, retract_se_mm_s = 0;  // standard errors; NaN where not known
  // By how much a speed at this duty differed from the table's at most, both directions; NaN where not known.
  double tolerance_percent = std::numeric_limits<double>::quiet_NaN();
};

struct DutyTable {
  std::string name;  // of the file, for messages
  std::vector<DutyRow> rows;
  DutyCurve extend, retract;

  const DutyCurve& Curve(int direction) const { return direction > 0 ? extend : retract; }

  // The largest of the rows'; none if no row has one.
  std::optional<double> TolerancePercent() const;
};

// Throws Error naming `name` and the row's values: duties that do not ascend within 0..1, a speed that is negative or
// falls with the duty, a tolerance outside 0..100 %, fewer than two different speeds in a direction.
DutyTable MakeDutyTable(std::vector<DutyRow> rows, const std::string& name);

// duty,extend_mm_s,retract_mm_s and, optional, extend_se_mm_s,retract_se_mm_s,tolerance_percent.
DutyTable ReadDutyTable(const std::filesystem::path& path);
void WriteDutyTable(const std::filesystem::path& path, const std::vector<DutyRow>& rows);

}  // namespace lake::actuator
