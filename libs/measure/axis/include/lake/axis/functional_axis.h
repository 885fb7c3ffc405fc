// The axis about which two segments turn, from two or more markers on each: mean axis, and the instantaneous centre of
// rotation over the flexion. Planar points turn about z.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "lake/exchange/point_recording.h"

namespace lake::axis {

struct SegmentMarkers {
  std::vector<std::string> shank, thigh;  // at least two each, in space three
};

// Where a segment's frame lies in the file's frame: x_file = turn · x_segment + origin. The segment's frame has its
// origin at the mean of its markers, and the file's axes of the first frame that has all of them.
struct Pose {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());  // mm; NaN: not seen

  bool IsSeen() const { return origin.allFinite(); }
};

// Both segments at each frame. Frames where a segment has too few markers (two, in space three) have no pose.
struct SegmentMotion {
  std::vector<Pose> shank, thigh;
  Eigen::Vector3d shank_marker, thigh_marker;  // the first of each, in its segment's frame, mm
};

// Throws UsageError for too few markers or one on both segments; Error, with the file's markers, for an unknown one,
// for image points, or where no frame has all markers of a segment.
SegmentMotion MotionOf(const exchange::PointRecording& points, const SegmentMarkers& markers);

// An axis over frames first … last. Points are mm in the segments' frames, the points of the axis nearest the mean of
// the shank's markers.
struct MeanAxis {
  std::size_t window = 0;           // 0: the whole recording; else the window, from 1
  std::size_t first = 0, last = 0;  // indices into the motion
  Eigen::Vector3d in_shank, in_thigh, direction_shank, direction_thigh;
  Eigen::Vector3d in_file, direction_file;  // their mean place over the window
  double sd_mm = 0;                         // of the point, along each of the two directions across the axis
  double pin_residual_mm = 0;               // how far the two points stand apart, across the axis: root mean square
  double flexion_deg = 0;                   // how far the segments turn within the window
};

struct MeanAxesResult {
  MeanAxis whole;
  std::vector<MeanAxis> windows;
  std::vector<std::string> warnings;  // of the windows that are left out
};

// The windows follow each other with `window_frames` each (0: none); a shorter rest at the end is none. The
// symmetrical axis of rotation (SARA: R. M. Ehrig et al., J. Biomech. 40, 2007), with Huber's weights. Its standard
// deviation takes the residuals' correlation in time from the whole recording. Throws Error where the segments turn by
// less than `least_turn_deg` over the whole recording; windows that do so are left out with a warning.
MeanAxesResult MeanAxes(const SegmentMotion& motion, std::size_t window_frames, double least_turn_deg);

// The knee angle at each frame, degrees: 0 where the shank's first marker, the axis and the thigh's first marker are in
// line across the axis, continuous over full turns; positive on average. NaN where a segment is not seen.
std::vector<double> KneeAngles(const SegmentMotion& motion, const MeanAxis& axis);

// The centre about which the thigh turns on the shank at a frame's knee angle, across the mean axis.
struct InstantaneousCentre {
  std::size_t frame = 0;  // index into the motion
  double knee_deg = 0;
  Eigen::Vector3d in_shank, in_file;  // mm
  // Of in_shank, along the shank's axes: of the smoothing alone, without the mean axis's own and without what one
  // recording repeats at each passage. Too small on a measured hinge: see the README.
  Eigen::Vector3d sd_mm;
};

// A joint with one degree of freedom passes the same centres at the same angle: how the thigh's point of the mean axis
// strays from the shank's is smoothed over the knee angle, each passage through an angle one draw, and its slope gives
// the centre. Frames without both segments have none. Throws Error with too small a range of angles.
std::vector<InstantaneousCentre> InstantaneousCentres(const SegmentMotion& motion, const MeanAxis& axis);

}  // namespace lake::axis
