// The knee's extension torque over the stroke or over the knee angle.
#pragma once

#include <filesystem>
#include <map>

#include "lake/linkage/linkage.h"

namespace lake::commands {

class TorqueTable {
 public:
  explicit TorqueTable(double constant_nm) : constant_nm_(constant_nm) {}

  // A CSV table with stroke_mm or knee_deg, and knee_torque_nm. Throws Error with file and line: no such columns, fewer
  // than two rows, two rows for one place.
  static TorqueTable Read(const std::filesystem::path& path);

  // N m, linear between rows; NaN beyond them.
  double At(const linkage::Pose& pose) const;

 private:
  double constant_nm_ = 0;
  std::map<double, double> rows_;  // none: the same torque everywhere
  bool over_stroke_ = false;
};

}  // namespace lake::commands
