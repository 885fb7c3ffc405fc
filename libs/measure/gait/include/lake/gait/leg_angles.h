// The leg in one frame: its vectors in the leg frame's axes and its angles, from marker positions in the plane frame.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "lake/motion/leg_motion.h"

namespace lake::gait {

// What the leg's markers are called in the recording. Without a waist the trunk is unknown.
struct LegMarkers {
  std::string ankle = "ankle";
  std::string knee = "knee";
  std::string hip = "hip";
  std::string waist = "waist";

  std::string Of(motion::LegMarker marker) const;  // a marker beside these has its usual name
};

// Marker positions in the plane frame; nullopt where not known.
struct LegPoints {
  std::optional<Eigen::Vector2d> ankle, knee, hip, waist;

  std::optional<Eigen::Vector2d> Of(motion::LegMarker marker) const;  // of one beside these nullopt
};

// The axes of the leg frame: x anterior, y up. `up` is a direction in the plane frame.
Eigen::Vector2d LegFromPlane(const Eigen::Vector2d& in_plane, motion::Facing facing, const Eigen::Vector2d& up);
Eigen::Vector2d PlaneFromLeg(const Eigen::Vector2d& in_leg, motion::Facing facing, const Eigen::Vector2d& up);

// From the vertical, positive when the upper end leans forward, −180..180; of a vector in the leg frame's axes.
double SegmentAngleDeg(const Eigen::Vector2d& in_leg);

// The segment's vector and angle; that of one that lies is from the horizontal.
void SetSegment(const motion::Segment& segment, const Eigen::Vector2d& in_leg, motion::LegSample& sample);

// cos(theta) = AK·KH / (|AK||KH|) (Gautam, Singla & Singla, Eq. (9)), signed by the side to which the shank folds: 0
// straight, positive in flexion.
double KneeAngleDeg(const Eigen::Vector2d& ak_in_leg, const Eigen::Vector2d& kh_in_leg);

// Vectors and angles of one frame; knee_raw_deg is not set.
motion::LegSample MakeLegSample(const LegPoints& points, motion::Facing facing, const Eigen::Vector2d& up);

// Knees fold one way: the side of the largest flexions is the one the subject faces, whatever the recording begins
// with.
struct FacingFound {
  motion::Facing facing = motion::Facing::kRight;
  double largest_flexion_deg = 0;  // 98 % quantile of |knee angle|; below 20° the side is not certain
  bool IsCertain() const { return largest_flexion_deg >= 20; }
};
FacingFound FindFacing(const std::vector<LegPoints>& frames);

}  // namespace lake::gait
