// The leg's joints over time with their velocities and accelerations, from the curves of the leg fit.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "lake/gait/leg_angles.h"
#include "lake/motion/marker_recording.h"

namespace lake::loads {

enum Joint { kAnkle, kKnee, kHip, kTrunkTop };  // the last is the shoulder, or the waist
inline constexpr int kJoints = 4;

// Of a point in the leg frame's axes (x the way the subject faces, y up).
struct PointMotion {
  Eigen::Vector2d position_m = Eigen::Vector2d::Zero(), velocity_m_s = Eigen::Vector2d::Zero(),
                  acceleration_m_s2 = Eigen::Vector2d::Zero();
};

using LegPoints = std::array<PointMotion, kJoints>;

struct LegPath {
  std::vector<double> time_s;
  std::vector<LegPoints> frames;
  std::vector<char> known;              // 0 or 1 per frame: whether all points are
  std::array<double, kJoints> sigma_m;  // one standard deviation per axis, of the leg fit (median)
  std::array<std::string, kJoints> names;
  bool has_shoulder = false;  // else the trunk's upper end is the waist
};

struct LegPathOptions {
  motion::Facing facing = motion::Facing::kRight;
  Eigen::Vector2d up = Eigen::Vector2d::UnitY();  // in the plane frame
  gait::LegMarkers markers;
  std::string shoulder = "shoulder";  // taken for the trunk if the recording has it
  double cutoff_hz = 6;               // −3 dB of the smoother that gives the derivatives
};

// `trajectory`: the leg fit's, in mm. Throws Error: px, a marker that is absent, no trunk.
LegPath MakeLegPath(const motion::MarkerRecording& trajectory, const LegPathOptions& options);

// A segment's length and tilt (from the vertical, positive leaning forward) with their derivatives, and its axes.
struct SegmentMotion {
  double length_m = 0, length_rate_m_s = 0;
  double tilt_rad = 0, tilt_rate_rad_s = 0, tilt_acceleration_rad_s2 = 0;
  Eigen::Vector2d along = Eigen::Vector2d::UnitY(), across = Eigen::Vector2d::UnitX();  // up the segment, and forward
};
SegmentMotion SegmentBetween(const PointMotion& lower, const PointMotion& upper);

}  // namespace lake::loads
