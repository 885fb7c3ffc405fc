// Positions of markers over time, in the plane frame (mm; x right in the image, y up, z towards the camera), for
// renderings.
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

  // The motion runs from 0 to here. Where nothing is known of the time before and after, its ends are held.
  virtual double DurationS() const = 0;

  // One position per name, in mm in the plane frame; smooth in time (its second derivative is continuous).
  virtual std::vector<Eigen::Vector2d> At(double time_s) const = 0;

  // How far each marker is in front of the plane at that time, in mm; zeros unless the motion was recorded in space.
  virtual std::vector<double> DepthsAt(double time_s) const;

  // Both together.
  std::vector<Eigen::Vector3d> InSpace(double time_s) const;
};

// The place of a name, or -1.
int IndexOfMarker(const MarkerMotion& motion, std::string_view name);

// The angle of the marker vectors knee−ankle and hip−knee: 0 straight, positive in flexion, −180..180 (the paper,
// section 6, signed by the side to which the shank folds).
double KneeAngleDeg(const Eigen::Vector2d& ankle, const Eigen::Vector2d& knee, const Eigen::Vector2d& hip,
                    motion::Facing facing);

// Recorded positions: times in s (increasing, at least 3), positions[marker][time] in mm in the plane frame, and
// depth_mm[marker][time], how far they are in front of the plane (empty: all in it). The motion begins before_s after
// the first time and ends after_s before the last: the rest is what an exposure sees that begins earlier or ends later.
struct MotionTable {
  std::vector<double> time_s;
  std::vector<std::string> names;
  std::vector<std::vector<Eigen::Vector2d>> positions;
  std::vector<std::vector<double>> depth_mm;
  double before_s = 0, after_s = 0;
};

// The side on which the knee stands of the line from ankle to hip, on average; right if one of them is absent.
motion::Facing FacingOf(const MotionTable& table);

// Reads columns time_s, M_x_mm, M_y_mm (other columns are passed over; a truth.csv is such a file). Throws Error naming
// file and line: no marker, an empty cell, times that do not increase.
MotionTable ReadMotionTable(const std::filesystem::path& path);

// Natural cubic splines through the table; the motion's begin becomes 0. With `mirror` x changes its sign.
std::unique_ptr<MarkerMotion> MakeTableMotion(MotionTable table, bool mirror = false);

}  // namespace lake::synth
