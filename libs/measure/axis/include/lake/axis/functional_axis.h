// The axis of rotation between shank and thigh from two or more markers on each: over a recording, over windows, over a
// range of flexion and in each frame.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

#include "lake/dynamics/rigid_segment.h"
#include "lake/exchange/point_recording.h"

namespace lake::axis {

struct SegmentMarkers {
  std::vector<std::string> shank, thigh;  // at least two each, in space three
};

// In the file's axes, mm.
using Pose = dynamics::Pose;
using Segment = dynamics::RigidSegment;

struct SegmentMotion {
  Segment shank, thigh;
};

// Fits the mean shape of each segment's markers to each frame (Procrustes; Kabsch 1976). Planar points turn about z;
// points of a 3-D file that keep to one plane, about its normal. Throws UsageError for too few markers or one on both
// segments; Error, with the file's markers, for an unknown one, for image points, or where no frame has all markers of
// a segment.
SegmentMotion MotionOf(const exchange::PointRecording& points, const SegmentMarkers& markers);

// The axis of rotation over frames first … last. The points are those of the axis nearest the mean of the shank's
// markers, mm; `in_shank` and `in_thigh` are in the segments' frames.
struct MeanAxis {
  std::size_t window = 0;           // 0: the whole recording; else the window, from 1
  std::size_t first = 0, last = 0;  // indices into the motion
  Eigen::Vector3d in_shank, in_thigh, direction_shank;
  Eigen::Vector3d in_file, direction_file;  // their mean over the frames
  double sd_mm = 0;                         // of the point, along each of the two directions across the axis
  double pin_residual_mm = 0;  // root mean square distance across the axis between the thigh's point and the shank's
  double flexion_deg = 0;      // the range of rotation about the axis
};

struct MeanAxesResult {
  MeanAxis whole;
  std::vector<MeanAxis> windows;
  std::vector<std::string> warnings;  // one for each window that is left out
};

// Symmetrical axis of rotation estimation (SARA: Ehrig et al., J. Biomech. 40, 2007, doi
// 10.1016/j.jbiomech.2006.10.026): the two points, constant in shank and thigh, that are nearest to each other over the
// frames,
//
//   Σ |turn · p_thigh + offset - p_shank|² → min    (turn, offset: the thigh in the shank's frame, across the axis)
//
// with the axis' direction from the mean of the turns. The standard deviation is the larger of two:
// - each coordinate of the markers' deformation, over all frames, is taken as an error of the poses, so that movement
// of
//   the skin with the flexion, drift and noise count as the recording has them;
// - the joint's points are in error in proportion to the flexion, by as much as the residual has in each other power of
//   it and by 0.1 mm at least.
// Both are widened for how few coordinates they come from (F distribution), so that an ellipse of 2.45 standard
// deviations holds 95 %.
//
// The windows follow each other with `window_frames` each (0: none); a shorter rest at the end is none. Throws Error
// where the segments turn by less than `least_turn_deg` over the recording, and where the axis is farther from a
// segment's markers than a segment is long; windows that turn too little are left out with a warning.
MeanAxesResult MeanAxes(const SegmentMotion& motion, std::size_t window_frames, double least_turn_deg);

// The knee angle at each frame, degrees: 0 where the shank's first marker, the axis and the thigh's first marker are in
// line across the axis, continuous over full turns; positive on average. NaN where a segment is not seen.
std::vector<double> KneeAngles(const SegmentMotion& motion, const MeanAxis& axis);

// The axis over the frames between two knee angles of the whole recording. Throws Error with fewer than ten of them.
MeanAxis PinOver(const SegmentMotion& motion, const MeanAxesResult& axes, double from_deg, double to_deg);

// The centre of rotation in a frame, across the mean axis.
struct InstantaneousCentre {
  std::size_t frame = 0;  // index into the motion
  double knee_deg = 0;
  Eigen::Vector3d in_shank, in_file;  // mm
  Eigen::Vector3d sd_mm;              // of in_shank, along the shank's axes
};

// Where shank and thigh carry the axis of the whole recording in each frame that shows both: the mean of the two
// points, each weighted by how precisely the segment's markers show it (PointSdMm).
std::vector<InstantaneousCentre> InstantaneousCentres(const SegmentMotion& motion, const MeanAxesResult& axes);

}  // namespace lake::axis
