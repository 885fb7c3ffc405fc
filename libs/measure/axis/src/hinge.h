// The hinge that fits some frames best, and how precisely it is known.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "lake/axis/functional_axis.h"

namespace lake::axis {

// The thigh in the shank's frame at one frame, across the axis: place_shank = turn · place_thigh + offset.
struct HingeFrame {
  Eigen::Matrix2d turn;
  Eigen::Vector2d offset;  // mm
  double angle_rad = 0;    // of `turn`, continuous over the frames
};

struct Hinge {
  Eigen::Matrix3d shank, thigh;  // AcrossAndAlong in the segment's frame
  double thigh_along_mm = 0;     // of the axis' point, along the axis in the thigh's frame
  std::vector<HingeFrame> frames;
  double range_rad = 0;                // of the frames' angles
  Eigen::Vector2d shank_mm, thigh_mm;  // the axis across itself
  double sd_mm = 0;                    // of shank_mm, along each axis

  Eigen::Vector2d Residual(const HingeFrame& frame) const { return frame.turn * thigh_mm + frame.offset - shank_mm; }
};

// A frame whose first two columns lie across the axis and whose third is the axis.
Eigen::Matrix3d AcrossAndAlong(const Eigen::Vector3d& axis);

// The thigh's pose on the shank at a frame, its turn.
Eigen::Matrix3d TurnOf(const SegmentMotion& motion, std::size_t frame);

// `frames` show both segments; there are ten at least, of more than one angle.
Hinge FitHinge(const SegmentMotion& motion, const std::vector<std::size_t>& frames);

}  // namespace lake::axis
