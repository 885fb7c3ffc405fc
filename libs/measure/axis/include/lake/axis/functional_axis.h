// The axis about which two segments turn, from two or more markers on each: mean axis, the best pin over a range of
// flexion, and the instantaneous centre of rotation over the flexion. Planar points turn about z.
#pragma once

#include <Eigen/Core>
#include <cmath>
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

// How the markers of a segment move against each other: skin, and noise. Principal components of what the poses leave.
struct Deformation {
  Eigen::MatrixXd modes;    // frames × modes, mm, root mean square over the markers; a gap is bridged by a line
  double marker_sd_mm = 0;  // of each marker, along each axis, if the markers' errors are independent
  double pose_sd_mm = 0;    // what these leave in the pose's origin, along each axis
  double pose_sd_rad = 0;   // and in its turn about an axis
  double radius_mm = 0;     // of the shape: root mean square of the markers' distances from their mean

  // Along each axis, in a point of the segment so far from the pose's origin.
  double PointSdMm(double distance_mm) const { return std::hypot(pose_sd_mm, pose_sd_rad * distance_mm); }
};

// A segment at each frame. Frames with too few markers (two, in space three) have no pose.
struct Segment {
  std::vector<Pose> poses;
  Eigen::Vector3d first_marker;  // in the segment's frame, mm
  Deformation deformation;
};

struct SegmentMotion {
  Segment shank, thigh;
};

// Throws UsageError for too few markers or one on both segments; Error, with the file's markers, for an unknown one,
// for image points, or where no frame has all markers of a segment.
SegmentMotion MotionOf(const exchange::PointRecording& points, const SegmentMarkers& markers);

// An axis over frames first … last. Points are mm in the segments' frames, the points of the axis nearest the mean of
// the shank's markers.
struct MeanAxis {
  std::size_t window = 0;           // 0: the whole recording; else the window, from 1
  std::size_t first = 0, last = 0;  // indices into the motion
  Eigen::Vector3d in_shank, in_thigh, direction_shank;
  Eigen::Vector3d in_file, direction_file;  // their mean place over the window
  double sd_mm = 0;                         // of the point, along each of the two directions across the axis
  // How far the two points stand apart across the axis, root mean square, where the markers' deformation is taken away.
  double pin_residual_mm = 0;
  double flexion_deg = 0;  // how far the segments turn within the window
};

// One supposition on what keeps the segments from turning as a hinge does, along each axis: a part that repeats with
// the angle, a slow process in time, and noise.
struct ErrorModel {
  double probability = 0;
  double repeated_mm = 0, angle_memory_rad = 0;
  double slow_mm = 0, memory_frames = 0;
  double noise_mm = 0;
};

// What the whole recording tells of the markers, for parts of it.
struct LearntErrors {
  std::vector<ErrorModel> models;  // their probabilities sum to 1
  double residual_mm = 0;          // what a hinge leaves, along each axis
  // How the deformations' modes carry the joint with them.
  Eigen::VectorXd carried;
  Eigen::MatrixXd carried_covariance;
  // The pin that fits all frames, in the shank's frame, where the deformation is none; along each axis.
  Eigen::Vector3d pin_in_shank = Eigen::Vector3d::Zero();
  double pin_sd_mm = 0;
};

struct MeanAxesResult {
  MeanAxis whole;
  LearntErrors errors;
  std::vector<MeanAxis> windows;
  std::vector<std::string> warnings;  // of the windows that are left out
};

// The windows follow each other with `window_frames` each (0: none); a shorter rest at the end is none. Throws Error
// where the segments turn by less than `least_turn_deg` over the whole recording; windows that do so are left out with
// a warning.
//
// All angles count alike, however many frames show them.
//
//   turn(θ) (p_thigh + B_thigh s_thigh) + offset − p_shank − B_shank s_shank = error,    s: the deformations' modes
//
// by least squares across the mean axis of the turns, both segments alike (as in SARA: R. M. Ehrig et al., J. Biomech.
// 40, 2007), corrected for what the poses' own turning errors pull the points towards the markers. The covariance of
// the errors is learnt by restricted likelihood; before it, they are as large as the markers' deformation lets expect
// at the joint: a part that repeats with the angle is not told from a hinge elsewhere, and the standard deviation says
// so. Windows know of the whole recording's pin, from which theirs strays by no more than a joint does or the recording
// shows.
MeanAxesResult MeanAxes(const SegmentMotion& motion, std::size_t window_frames, double least_turn_deg);

// The knee angle at each frame, degrees: 0 where the shank's first marker, the axis and the thigh's first marker are in
// line across the axis, continuous over full turns; positive on average. NaN where a segment is not seen.
std::vector<double> KneeAngles(const SegmentMotion& motion, const MeanAxis& axis);

// The pin that fits the frames between two knee angles best. Throws Error with too few of them.
MeanAxis PinOver(const SegmentMotion& motion, const MeanAxesResult& axes, double from_deg, double to_deg);

// The centre about which the thigh turns on the shank at a frame's knee angle, across the mean axis.
struct InstantaneousCentre {
  std::size_t frame = 0;  // index into the motion
  double knee_deg = 0;
  Eigen::Vector3d in_shank, in_file;  // mm
  Eigen::Vector3d sd_mm;              // of in_shank, along the shank's axes
};

// c = p_shank + j + z × dj/dθ, with j(θ) the part of the errors that repeats with the angle, as far as it is the
// joint's and not the skin's: the share that a knee's own stray has in the sum of that and of the markers' deformation,
// carried out to the joint. The standard deviation holds both readings. Frames without both segments have none.
std::vector<InstantaneousCentre> InstantaneousCentres(const SegmentMotion& motion, const MeanAxesResult& axes);

}  // namespace lake::axis
