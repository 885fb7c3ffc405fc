// Where markers are over time, in the plane frame (mm; x right in the image, y up): what a rendering shows.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "lake/motion/leg_motion.h"

namespace lake::synth {

class MarkerMotion {
 public:
  virtual ~MarkerMotion() = default;

  virtual const std::vector<std::string>& Names() const = 0;
  virtual motion::Facing FacingInImage() const = 0;

  // The motion runs from 0 to here; before and after, its ends are held.
  virtual double DurationS() const = 0;

  // One position per name, in mm in the plane frame; smooth in time (its second derivative is continuous).
  virtual std::vector<Eigen::Vector2d> At(double time_s) const = 0;
};

// The place of a name, or -1.
int IndexOfMarker(const MarkerMotion& motion, std::string_view name);

// The angle of the marker vectors knee−ankle and hip−knee: 0 straight, positive in flexion, −180..180 (the paper,
// section 6, signed by the side to which the shank folds).
double KneeAngleDeg(const Eigen::Vector2d& ankle, const Eigen::Vector2d& knee, const Eigen::Vector2d& hip,
                    motion::Facing facing);

// Recorded positions: times in s (increasing, at least 3), positions[marker][time] in mm in the plane frame.
struct MotionTable {
  std::vector<double> time_s;
  std::vector<std::string> names;
  std::vector<std::vector<Eigen::Vector2d>> positions;
};

// Reads columns time_s, M_x_mm, M_y_mm (other columns are passed over; a truth.csv is such a file). Throws Error naming
// file and line: no marker, an empty cell, times that do not increase.
MotionTable ReadMotionTable(const std::filesystem::path& path);

// Natural cubic splines through the table, whose first time becomes 0. With `mirror` x changes its sign. The subject
// faces to the side on which the knee stands of the line from ankle to hip, on average (right if one of them is
// absent).
std::unique_ptr<MarkerMotion> MakeTableMotion(MotionTable table, bool mirror = false);

}  // namespace lake::synth
