// A segment's pose from its markers, and where it carries the knee. Not part of the interface.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "lake/dynamics/rigid_segment.h"
#include "lake/gait/learnt_knee.h"

namespace lake::gait {

// A marker in the leg's axes (x anterior, y up, z to the right), mm; NaN where not seen, with its noise per axis.
struct MarkerPlaces {
  std::vector<Eigen::Vector3d> place;
  std::vector<double> noise;
};
using LegPlaces = std::map<std::string, MarkerPlaces>;

// A segment of the leg that ends at the knee.
struct KneeSegment {
  const char* name;
  std::string LegMarkers::*end;    // its other end
  std::string LegMarkers::*other;  // the far end of the other segment
  double upward;                   // 1 where the knee is its upper end, −1 where it is its lower one
};
const KneeSegment& KneeSegmentOf(const std::string& name);

// Of the frames' places of these markers, a column each.
Eigen::Matrix3Xd PlacesAt(const LegPlaces& places, const std::vector<std::string>& markers, std::size_t frame);

dynamics::TurnNormal NormalOf(bool in_space);

// How far markers at these places (NaN: not seen) are from those of the posed shape, per axis, root mean square.
double StrainOf(const SegmentKnee& segment, const dynamics::Pose& pose, const Eigen::Matrix3Xd& places);

// Between the segment (its frame's y axis) and the other one, whose far end is at `other`; positive in flexion, both
// places in the segment's frame.
double FlexionDeg(const KneeSegment& segment, const Eigen::Vector3d& knee, const Eigen::Vector3d& other);

// Where a segment carries the knee at this flexion, in its frame, with the standard deviation per axis in the sagittal
// plane. Beyond the range that was learnt the polynomial goes on straight, and its deviation grows.
struct KneeAt {
  Eigen::Vector3d place;
  double sd = 0;
};
KneeAt KneeAtFlexion(const LearntKnee& learnt, const SegmentKnee& segment, double flexion_deg);

}  // namespace lake::gait
